#include "sim_server/contact/self_collision.hpp"

#include <catch2/catch.hpp>

#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::contact::self_collision_test {
namespace {

constexpr double kRadius_m = 0.003;

/// A thread with a sphere a node, 10 mm apart.
bodies::BodyDescription string_of(int nodes) {
  bodies::BodyDescription body =
      sim_server::thread(nodes, {0, 0, 0}, {0.01 * (nodes - 1), 0, 0}, 0.01, 10.0);
  sim_server::packing(body) = {0.01, kRadius_m};
  return body;
}

const bodies::SphereBinding& sphere_at(const bodies::World& world, int i) {
  return world.spheres[static_cast<std::size_t>(i)];
}

/// Whether spheres i and j of the world may collide; the order must not matter.
bool may_meet(const bodies::World& world, int i, int j) {
  const SelfCollision law(world);
  const bool may = law.may_collide(sphere_at(world, i), sphere_at(world, j));
  CHECK(law.may_collide(sphere_at(world, j), sphere_at(world, i)) == may);
  return may;
}

TEST_CASE("Different bodies may collide, a rigid one not with itself", "[self_collision]") {
  const bodies::World world = scene::build_world(
      sim_server::scene_of({sim_server::box({0, 0, 0}, {0.1, 0.1, 0.1}, 1.0, {0.02, 0.005}),
                            string_of(3), string_of(3)}));
  const auto boxes = static_cast<int>(world.spheres.size()) - 6;

  CHECK_FALSE(may_meet(world, 0, boxes - 1));
  CHECK(may_meet(world, 0, boxes));
  CHECK(may_meet(world, boxes, boxes + 3));  // at one place, but of two threads
}

TEST_CASE("What a spring joins does not collide, whatever its distance", "[self_collision]") {
  bodies::BodyDescription body = string_of(8);
  const bodies::World loose = scene::build_world(sim_server::scene_of({body}));
  sim_server::springs(body).bend_stiffness_N_per_m = 1.0;
  const bodies::World bent = scene::build_world(sim_server::scene_of({body}));

  CHECK_FALSE(may_meet(loose, 3, 4));  // gap 4 mm, more than half a radius
  CHECK(may_meet(loose, 3, 5));
  CHECK_FALSE(may_meet(bent, 3, 5));
  CHECK(may_meet(bent, 3, 6));
}

TEST_CASE("Spheres that hang on a node in common do not collide", "[self_collision]") {
  bodies::BodyDescription body = sim_server::thread(3, {0, 0, 0}, {0.1, 0, 0}, 0.01, 10.0);
  sim_server::springs(body).structural_stiffness_N_per_m = 0.0;  // no spring at all
  sim_server::packing(body) = {0.0125, 0.001};                   // four between two nodes
  const bodies::World world = scene::build_world(sim_server::scene_of({body}));
  REQUIRE(world.spheres.size() == 9);

  CHECK_FALSE(may_meet(world, 1, 3));  // both between nodes 0 and 1, 25 mm apart
  CHECK_FALSE(may_meet(world, 1, 5));  // on 0, 1 and on 1, 2
  CHECK(may_meet(world, 0, 8));        // on 0 and on 2
}

TEST_CASE("Neighbours at rest do not collide though no spring joins them; others do",
          "[self_collision]") {
  // Balls of 20 and 2 mm on a fine lattice: the small one at gaps of 0.9 and of 1.1 mm.
  const double gap_m = GENERATE(-0.001, 0.0009, 0.0011);
  const spheres::Ball large{{0, 0, 0}, 0.02}, small{{0.022 + gap_m, 0, 0}, 0.002};
  bodies::BodyDescription body = sim_server::soft_mesh({large, small}, 0.002, 1e-4, 10.0);
  const bodies::World world = scene::build_world(sim_server::scene_of({body}));

  CHECK(may_meet(world, 0, 1) == (gap_m > 0.001));
}

TEST_CASE("How a body is bent later makes no difference", "[self_collision]") {
  bodies::World world = scene::build_world(sim_server::scene_of({string_of(30)}));
  const SelfCollision law(world);
  for (bodies::Node& node : world.nodes) node.position_m.setZero();

  CHECK_FALSE(law.may_collide(sphere_at(world, 0), sphere_at(world, 1)));
  CHECK(law.may_collide(sphere_at(world, 0), sphere_at(world, 29)));
}

}  // namespace
}  // namespace stillgrid::contact::self_collision_test
