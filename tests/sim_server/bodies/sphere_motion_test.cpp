#include "sim_server/bodies/sphere_motion.hpp"

#include <catch2/catch.hpp>

#include "sim_server/bodies/rotation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid {
namespace {

constexpr double kStep_s = 0.03;

/// A tumbling box and a sheet with a pinned corner, in no state of symmetry.
World tumbling_world() {
  BodyDescription tumbling = moving(box({0.1, 0.2, 0.3}, {0.03, 0.03, 0.02}, 0.02, {0.01, 0.005}),
                                    {0.4, -0.3, 0.2}, {5.0, -9.0, 14.0});
  tumbling.orientation = Eigen::AngleAxisd(0.8, Eigen::Vector3d(3, 1, 2).normalized());
  BodyDescription cloth = moving(sheet({4, 3}, 0.02, 0.002, 500.0), {0.1, 0, 0}, {0, 3.0, 1.0});
  cloth.spheres = {0.011, 0.004};
  cloth.pinned_nodes = {0};
  return build_world(scene_of({tumbling, cloth}));
}

/// The world a step of velocities u later, as the implicit step moves it.
World moved(World world, const Eigen::VectorXd& u) {
  for (Node& node : world.nodes) {
    if (node.unknown == kNoUnknown) continue;
    node.velocity_m_s = u.segment<3>(node.unknown);
    node.position_m += kStep_s * node.velocity_m_s;
  }
  for (RigidBody& body : world.rigid_bodies) {
    body.velocity_m_s = u.segment<3>(body.unknown);
    body.angular_velocity_rad_s = u.segment<3>(body.unknown + 3);
    body.position_m += kStep_s * body.velocity_m_s;
    body.orientation = rotation_of(kStep_s * body.angular_velocity_rad_s) * body.orientation;
  }
  return world;
}

Eigen::VectorXd some_velocities(const World& world) {
  Eigen::VectorXd u(world.unknown_count);
  for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = 3.0 * std::sin(1.0 + 7.0 * double(i));
  return u;
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

TEST_CASE("A force on a sphere reaches its body whole, with the torque it has about any point",
          "[sphere_motion]") {
  const World world = tumbling_world();
  const Eigen::Vector3d force_N(0.3, -1.7, 0.9), about_m(-0.4, 0.3, 0.05);

  for (const SphereBinding& sphere : world.spheres) {
    Eigen::Vector3d total_N = Eigen::Vector3d::Zero(), torque_N_m = Eigen::Vector3d::Zero();
    const SphereParts parts = sphere_parts(world.nodes, world.rigid_bodies, sphere, kStep_s);
    for (const SpherePart& part : parts.all()) {
      const Eigen::Vector3d share = part.lever.transpose() * force_N;
      Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
      for (const Node& node : world.nodes)
        if (node.unknown == part.unknown) at_m = node.position_m;
      for (const RigidBody& body : world.rigid_bodies)
        if (body.unknown == part.unknown) at_m = body.position_m;
      total_N += part.is_rotation ? Eigen::Vector3d::Zero().eval() : share;
      torque_N_m += part.is_rotation ? share : (at_m - about_m).cross(share).eval();
    }
    // What a pinned node takes is not the body's to carry.
    for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
      const Node& node = world.nodes[static_cast<std::size_t>(sphere.nodes[i])];
      if (node.unknown != kNoUnknown) continue;
      total_N += sphere.weights[i] * force_N;
      torque_N_m += (node.position_m - about_m).cross(sphere.weights[i] * force_N);
    }
    CHECK((total_N - force_N).norm() < 1e-14);
    CHECK((torque_N_m - (sphere_motion(world, sphere).position_m - about_m).cross(force_N)).norm() <
          1e-14);
  }
}

TEST_CASE("A sphere's slopes are the derivatives of its motion through the step",
          "[sphere_motion]") {
  const World world = tumbling_world();
  const Eigen::VectorXd u = some_velocities(world);
  const World end = moved(world, u);
  constexpr double kChange = 1e-5;

  for (const SphereBinding& sphere : world.spheres) {
    const SphereParts parts = sphere_parts(end.nodes, end.rigid_bodies, sphere, kStep_s);
    for (const SpherePart& part : parts.all())
      for (int i = 0; i < 3; ++i) {
        Eigen::VectorXd change = Eigen::VectorXd::Zero(u.size());
        change[part.unknown + i] = kChange;
        const SphereMotion more = sphere_motion(moved(world, u + change), sphere);
        const SphereMotion less = sphere_motion(moved(world, u - change), sphere);
        const Eigen::Vector3d position_slope = (more.position_m - less.position_m) / (2 * kChange);
        const Eigen::Vector3d velocity_slope =
            (more.velocity_m_s - less.velocity_m_s) / (2 * kChange);
        CHECK((position_slope - part.position_by_unknown.col(i)).norm() < 1e-9);
        CHECK((velocity_slope - part.velocity_by_unknown.col(i)).norm() < 1e-9);
      }
  }
}

TEST_CASE("The lever is how velocity unknowns move a sphere at its pose", "[sphere_motion]") {
  const World world = tumbling_world();

  for (const SphereBinding& sphere : world.spheres) {
    const SphereParts parts = sphere_parts(world.nodes, world.rigid_bodies, sphere, kStep_s);
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
    for (const SpherePart& part : parts.all()) {
      Eigen::Vector3d u = Eigen::Vector3d::Zero();
      for (const Node& node : world.nodes)
        if (node.unknown == part.unknown) u = node.velocity_m_s;
      for (const RigidBody& body : world.rigid_bodies) {
        if (body.unknown == part.unknown) u = body.velocity_m_s;
        if (body.unknown + 3 == part.unknown) u = body.angular_velocity_rad_s;
      }
      velocity_m_s += part.lever * u;
    }
    CHECK((velocity_m_s - sphere_motion(world, sphere).velocity_m_s).norm() < 1e-14);
  }
}

TEST_CASE("What is pinned or prescribed moves a sphere by no unknown", "[sphere_motion]") {
  BodyDescription driven = sphere({0, 0, 0}, 0.01, 0.1);
  driven.motion = Motion::kPrescribed;
  driven.prescribed.velocity_m_s = 0.5;
  const World world =
      build_world(scene_of({driven, thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.1, 10.0, {0, 1})}));

  for (const SphereBinding& sphere : world.spheres)
    CHECK(sphere_parts(world.nodes, world.rigid_bodies, sphere, kStep_s).count == 0);
  CHECK(sphere_motion(world, world.spheres[0]).velocity_m_s == Eigen::Vector3d(0.5, 0, 0));
}

}  // namespace
}  // namespace stillgrid
