#include "sim_server/fields/contact_choice.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <stdexcept>

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

const ContactTrial& chosen_of(const ContactChoice& choice) {
  const auto is_chosen = [](const ContactTrial& trial) { return trial.refusal.empty(); };
  REQUIRE(std::count_if(choice.trials.begin(), choice.trials.end(), is_chosen) == 1);
  return *std::find_if(choice.trials.begin(), choice.trials.end(), is_chosen);
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
  const ContactTrial& chosen = chosen_of(choice);
  for (const ContactTrial& trial : choice.trials) {
    CHECK(trial.cost_ns == Approx(trial.tick_ns + need.steps_per_ms * trial.step_ns));
    if (!choice.keeps_error)
      CHECK(trial.error_share >= chosen.error_share);
    else if (trial.error_share <= error_share)
      CHECK(trial.cost_ns >= chosen.cost_ns);
  }
  CHECK(choice.keeps_error == (chosen.error_share <= error_share));
  CHECK((choice.field != nullptr) == (chosen.model == ContactModel::kField));
  CHECK(choice.balls.empty() == (choice.field != nullptr));
  if (choice.field) CHECK(choice.stiffness_scale == 1.0);
}

TEST_CASE("The same need gives the same choice", "[contact_choice]") {
  const mesh::TriangleMesh solid = spheres::star_mesh(5, 0.2);
  const ContactChoice once = choose_contact(solid, need_of(solid, 0.2)),
                      again = choose_contact(solid, need_of(solid, 0.2));
  REQUIRE(once.trials.size() == again.trials.size());
  for (std::size_t i = 0; i < once.trials.size(); ++i) {
    CHECK(once.trials[i].error_share == again.trials[i].error_share);
    CHECK(once.trials[i].cost_ns == again.trials[i].cost_ns);
    CHECK(once.trials[i].refusal == again.trials[i].refusal);
  }
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
  CHECK(std::none_of(choice.trials.begin(), choice.trials.end(), [](const ContactTrial& trial) {
    return trial.model == ContactModel::kField;
  }));
  need.cell_m = 0.02;
  CHECK_THROWS_WITH(choose_contact(solid, need), "too large");
}

TEST_CASE("A lens too thin for coarse even spheres is met all the same", "[contact_choice]") {
  mesh::TriangleMesh lens = mesh::ball_mesh(0.31, 34, 17);
  for (Eigen::Vector3d& vertex_m : lens.vertices_m) vertex_m.z() *= 0.004;
  REQUIRE(spheres::firm_surface_balls_if_any(lens, 0.88 / 20.0).empty());
  ContactNeed need = need_of(lens, 3.0);
  need.cell_m = 0.02;
  const ContactChoice choice = choose_contact(lens, need);
  CHECK(choice.keeps_error);
  CHECK(chosen_of(choice).error_share <= 3.0);
}

}  // namespace stillgrid::fields::contact_choice_test
