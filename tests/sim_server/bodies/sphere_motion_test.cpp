#include "sim_server/bodies/sphere_motion.hpp"

#include <catch2/catch.hpp>

#include "sim_server/bodies/rotation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::bodies::sphere_motion_test {
namespace {

/// A tumbling box and a sheet with a pinned corner, in no state of symmetry.
World tumbling_world() {
  BodyDescription tumbling =
      sim_server::moving(sim_server::box({0.1, 0.2, 0.3}, {0.03, 0.03, 0.02}, 0.02, {0.01, 0.005}),
                         {0.4, -0.3, 0.2}, {5.0, -9.0, 14.0});
  tumbling.orientation = Eigen::AngleAxisd(0.8, Eigen::Vector3d(3, 1, 2).normalized());
  BodyDescription cloth =
      sim_server::moving(sim_server::sheet({4, 3}, 0.02, 0.002, 500.0), {0.1, 0, 0}, {0, 3.0, 1.0});
  sim_server::packing(cloth) = {0.011, 0.004};
  sim_server::springs(cloth).pinned_nodes = {0};
  return scene::build_world(sim_server::scene_of({tumbling, cloth}));
}

TEST_CASE("A sphere's velocity is how its position changes", "[sphere_motion]") {
  const World world = tumbling_world();
  const double moment_s = 1e-6;
  World later = world;
  for (Node& node : later.nodes) node.position_m += moment_s * node.velocity_m_s;
  for (RigidBody& body : later.rigid_bodies) {
    body.position_m += moment_s * body.velocity_m_s;
    body.orientation = rotation_of(moment_s * body.angular_velocity_rad_s) * body.orientation;
  }

  for (const SphereBinding& sphere : world.spheres) {
    const SphereMotion now = sphere_motion(world, sphere);
    const Eigen::Vector3d change_m = sphere_motion(later, sphere).position_m - now.position_m;
    CHECK((change_m / moment_s - now.velocity_m_s).norm() < 1e-5);  // |w|^2 r moment / 2
  }
}

TEST_CASE("A sphere of a prescribed body moves as its motion says, one of pinned nodes not at all",
          "[sphere_motion]") {
  BodyDescription driven = sim_server::sphere({0, 0, 0}, 0.01, 0.1);
  driven.motion = Motion::kPrescribed;
  driven.prescribed.velocity_m_s = {0.5, 0.0, 0.0};
  const World world = scene::build_world(sim_server::scene_of(
      {driven, sim_server::thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.1, 10.0, {0, 1})}));

  REQUIRE(world.spheres.size() > 1);
  CHECK(sphere_motion(world, world.spheres[0]).velocity_m_s == Eigen::Vector3d(0.5, 0, 0));
  for (std::size_t i = 1; i < world.spheres.size(); ++i)
    CHECK(sphere_motion(world, world.spheres[i]).velocity_m_s.isZero(0.0));
}

}  // namespace
}  // namespace stillgrid::bodies::sphere_motion_test
