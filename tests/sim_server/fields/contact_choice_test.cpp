#include "sim_server/fields/contact_choice.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>

#include "sim_server/fields/mesh_field.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "tests/sim_server/spheres/generated_solids.hpp"

namespace stillgrid::fields::contact_choice_test {
namespace {

ContactNeed need_of(const mesh::TriangleMesh& solid, double error_share) {
  return {.tool_radius_m = 0.06,
          .press_depth_m = 0.015,
          .max_error_share = error_share,
          .make_field = [&solid](double cell_m) {
            return std::make_shared<const collision::DistanceField>(
                make_mesh_field(solid, {cell_m, 0.06, 0.06 + 4.0 * cell_m}));
          }};
}

}  // namespace

TEST_CASE("The chosen model keeps the error, and none that was tried keeps it for less",
          "[contact_choice]") {
  const unsigned seed = GENERATE(1U, 2U, 3U, 4U, 5U, 6U);
  const double error_share = std::array{0.1, 0.3, 1.5}.at(seed % 3);
  const mesh::TriangleMesh solid =
      seed % 2 == 0 ? spheres::random_box(seed) : spheres::star_mesh(seed, 0.15);
  ContactNeed need = need_of(solid, error_share);
  const bool moves = seed / 2 % 2 == 1;
  if (moves) {
    need.points = 500;
    need.steps_per_ms = 0.1;
  }
  const ContactChoice choice = choose_contact(solid, need);
  const choice::Record& chosen = choice.chosen;
  CHECK(std::ranges::count(choice.records, std::string(), &choice::Record::refusal) == 1);
  for (const choice::Record& record : choice.records) {
    if (!choice.keeps_error)
      CHECK(*record.error_share >= *chosen.error_share);
    else if (*record.error_share <= error_share)
      CHECK(record.work_per_ms >= chosen.work_per_ms);
  }
  CHECK(choice.keeps_error == (*chosen.error_share <= error_share));
  CHECK((choice.field != nullptr) == chosen.name.starts_with("field"));
  CHECK(choice.balls.empty() == (choice.field != nullptr));
  if (choice.field) CHECK(choice.stiffness_scale == 1.0);
}

TEST_CASE("The same need gives the same choice", "[contact_choice]") {
  const mesh::TriangleMesh solid = spheres::star_mesh(5, 0.2);
  const ContactChoice once = choose_contact(solid, need_of(solid, 0.2)),
                      again = choose_contact(solid, need_of(solid, 0.2));
  REQUIRE(once.records.size() == again.records.size());
  for (std::size_t i = 0; i < once.records.size(); ++i)
    CHECK(choice::json_line(once.records[i]) == choice::json_line(again.records[i]));
}

TEST_CASE("Where no field can be made a choice is among spheres; one of a given cell is refused",
          "[contact_choice]") {
  const mesh::TriangleMesh solid = spheres::star_mesh(5, 0.2);
  ContactNeed need = need_of(solid, 0.2);
  need.make_field = [](double) -> std::shared_ptr<const collision::DistanceField> {
    throw std::invalid_argument("too large");
  };
  const ContactChoice choice = choose_contact(solid, need);
  CHECK(choice.field == nullptr);
  CHECK(!choice.balls.empty());
  CHECK(std::ranges::none_of(choice.records, [](const choice::Record& record) {
    return record.name.starts_with("field");
  }));
  need.cell_m = 0.02;
  CHECK_THROWS_WITH(choose_contact(solid, need), "too large");
}

}  // namespace stillgrid::fields::contact_choice_test
