#include "sim_server/spheres/decomposition_cover.hpp"

#include <catch2/catch.hpp>

namespace stillgrid::spheres::decomposition_cover_test {
namespace {

using Numbers = std::vector<std::uint32_t>;

/// Every element in two neighbouring sets, and one set that holds them all.
SetCover chain(std::uint32_t elements) {
  SetCover cover;
  for (std::uint32_t set = 0; set <= elements + 1; ++set) cover.add_set({});
  for (std::uint32_t i = 0; i < elements; ++i) CHECK(cover.add_element({i, i + 1, elements + 1}));
  return cover;
}

TEST_CASE("One set that holds all is found", "[decomposition_cover]") {
  SetCover cover = chain(9);
  cover.cover_greedily();
  cover.improve(1000);
  CHECK(cover.chosen() == Numbers{10});
}

TEST_CASE("Without it every second set is enough, and none that is forbidden is taken",
          "[decomposition_cover]") {
  SetCover cover = chain(9);
  CHECK(cover.forbid(10).empty());
  cover.cover_greedily();
  cover.improve(10000);
  CHECK(cover.chosen().size() == 5);
}

TEST_CASE("What is in no set any more is asked for no more once it is forgotten",
          "[decomposition_cover]") {
  SetCover cover = chain(9);
  (void)cover.forbid(10);
  (void)cover.forbid(0);
  const Numbers lost = cover.forbid(1);
  REQUIRE(lost == Numbers{0});
  cover.forget_lost(lost[0]);
  cover.forget_lost(5);  // in a set: kept
  cover.cover_greedily();
  cover.improve(10000);
  CHECK(cover.chosen().size() == 4);
}

TEST_CASE("An element of forbidden sets alone is not added", "[decomposition_cover]") {
  SetCover cover = chain(2);
  (void)cover.forbid(0);
  CHECK_FALSE(cover.add_element({0}));
  CHECK(cover.elements() == 2);
}

}  // namespace
}  // namespace stillgrid::spheres::decomposition_cover_test
