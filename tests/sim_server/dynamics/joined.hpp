#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics {

inline constexpr double kGravity_m_s2 = 9.81;

[[nodiscard]] inline scene::SceneDescription joined_scene(
    std::vector<bodies::BodyDescription> bodies, std::vector<scene::JointDescription> joints,
    double gravity_m_s2 = 0.0, const scene::MaterialDescription& material = {}) {
  scene::SceneDescription scene =
      sim_server::scene_of(std::move(bodies), material, {0.0, 0.0, -gravity_m_s2});
  scene.joints = std::move(joints);
  return scene;
}

[[nodiscard]] inline scene::JointDescription joint(int body_a, int body_b,
                                                   std::vector<Eigen::Vector3d> points_m,
                                                   double stiffness_N_per_m,
                                                   double damping_N_s_per_m = 0.0) {
  return {.name = "",
          .body_a = body_a,
          .body_b = body_b,
          .points_m = std::move(points_m),
          .stiffness_N_per_m = stiffness_N_per_m,
          .damping_N_s_per_m = damping_N_s_per_m};
}

/// A box of one sphere, so that it meets little.
[[nodiscard]] inline bodies::BodyDescription link(const Eigen::Vector3d& centre_m,
                                                  const Eigen::Vector3d& size_m, double mass_kg) {
  return sim_server::box(centre_m, size_m, mass_kg, {size_m.maxCoeff(), 0.2 * size_m.minCoeff()});
}

/// Boxes, a thread and a sheet in a row, of sizes, masses and motions that are drawn: each is
/// joined to the next at one, two or three points, by springs of 200 to 20,000 N/m.
[[nodiscard]] inline scene::SceneDescription drawn_chain(unsigned seed, double damping_N_s_per_m,
                                                         double gravity_m_s2, bool is_hung) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto any = [&](double most) {
    return Eigen::Vector3d(between(-most, most), between(-most, most), between(-most, most));
  };
  std::vector<bodies::BodyDescription> bodies;
  std::vector<scene::JointDescription> joints;
  const auto stiffness = [&] { return 200.0 * std::pow(100.0, between(0.0, 1.0)); };
  double x_m = 0.0;
  const auto hold = [&](int a, int b) {
    std::vector<Eigen::Vector3d> points_m = {{x_m, 0.0, 0.0}};
    const auto more = static_cast<int>(between(0.0, 3.0));
    if (more > 0) points_m.emplace_back(x_m, 0.01, 0.0);
    if (more > 1) points_m.emplace_back(x_m, 0.0, 0.01);
    joints.push_back(joint(a, b, points_m, stiffness(), damping_N_s_per_m));
  };
  const auto boxes = static_cast<int>(between(2.0, 5.0));
  if (is_hung) hold(0, -1);
  for (int i = 0; i < boxes; ++i) {
    const double length_m = between(0.03, 0.06);
    if (i > 0) hold(i - 1, i);
    bodies.push_back(
        sim_server::moving(link({x_m + 0.5 * length_m, 0.0, 0.0},
                                {length_m, between(0.01, 0.03), 0.02}, between(0.01, 0.1)),
                           any(0.2), any(3.0)));
    x_m += length_m;
  }
  bodies::BodyDescription thread = sim_server::moving(
      sim_server::thread(4, {x_m, 0.0, 0.0}, {x_m + 0.04, 0.0, 0.0}, 0.005, 400.0), any(0.2));
  sim_server::springs(thread).spring_damping_N_s_per_m = damping_N_s_per_m;
  bodies.push_back(thread);
  joints.push_back(joint(boxes - 1, boxes, {{x_m, 0.0, 0.0}}, stiffness(), damping_N_s_per_m));
  x_m += 0.04;
  bodies::BodyDescription sheet = sim_server::sheet({3, 3}, 0.02, 0.004, 300.0);
  // At the thread's end, or a millimetre off.
  sheet.position_m = {x_m + 0.02 + 0.001 * (seed % 2), 0.02, 0.0};
  bodies.push_back(sheet);
  joints.push_back(joint(boxes, boxes + 1, {{x_m, 0.0, 0.0}}, stiffness(), damping_N_s_per_m));
  return joined_scene(std::move(bodies), std::move(joints), gravity_m_s2,
                      sim_server::material_of(300.0));
}

/// How far a damped body hangs below the place where it is joined after 4 s, in units of m g / k.
[[nodiscard]] inline double hanging_share(const scene::Method& method, bool is_of_nodes) {
  constexpr double kMass_kg = 0.06, kStiffness_N_per_m = 150.0;
  bodies::BodyDescription body = link({0, 0, 0}, {0.02, 0.02, 0.02}, kMass_kg);
  if (is_of_nodes) {
    body = sim_server::thread(3, {0, 0, 0}, {0, 0, -0.02}, kMass_kg / 3.0, 1e3);
    sim_server::springs(body).spring_damping_N_s_per_m = 5.0;
  }
  scene::SceneDescription scene =
      joined_scene({body}, {joint(0, -1, {{0, 0, 0}}, kStiffness_N_per_m, 3.0)}, kGravity_m_s2);
  scene.method = method;
  Simulation simulation(scene);
  (void)advance(simulation, 0.005, 800);
  const bodies::World& world = simulation.world();
  const double z_m =
      is_of_nodes ? world.nodes[0].position_m.z() : world.rigid_bodies[0].position_m.z();
  return -z_m / (kMass_kg * kGravity_m_s2 / kStiffness_N_per_m);
}

/// The period of a rod that swings by 0.05 rad about its end, over 3 s, in units of a physical
/// pendulum's; zero where it hardly swings.
[[nodiscard]] inline double swing_share(const scene::Method& method, bool is_hinge) {
  constexpr double kLength_m = 0.2, kWidth_m = 0.01, kMass_kg = 0.1, kTilt_rad = 0.05;
  const Eigen::Vector3d out(std::sin(kTilt_rad), 0.0, -std::cos(kTilt_rad));
  bodies::BodyDescription rod =
      link(0.5 * kLength_m * out, {kWidth_m, kWidth_m, kLength_m}, kMass_kg);
  rod.orientation = Eigen::AngleAxisd(-kTilt_rad, Eigen::Vector3d::UnitY());
  std::vector<Eigen::Vector3d> points_m = {{0.0, 0.0, 0.0}};
  if (is_hinge) points_m = {{0.0, -0.005, 0.0}, {0.0, 0.005, 0.0}};
  scene::SceneDescription scene =
      joined_scene({rod}, {joint(0, -1, points_m, 2e4, 2.0)}, kGravity_m_s2);
  scene.method = method;
  Simulation simulation(scene);

  double first_s = 0.0, last_s = 0.0, before_m = 0.0;
  int crossings = 0;
  constexpr double kStep_s = 1e-3;
  for (int i = 1; i <= 3000; ++i) {
    (void)advance(simulation, kStep_s, 1);
    const double x_m = simulation.world().rigid_bodies[0].position_m.x();
    if (i > 1 && before_m * x_m < 0.0) {
      last_s = (i - x_m / (x_m - before_m)) * kStep_s;
      if (crossings++ == 0) first_s = last_s;
    }
    before_m = x_m;
  }

  // About its end, and a term for the tilt.
  const double inertia_kg_m2 = kMass_kg * ((kLength_m * kLength_m + kWidth_m * kWidth_m) / 12.0 +
                                           kLength_m * kLength_m / 4.0);
  const double period_s = 2.0 * std::numbers::pi *
                          std::sqrt(inertia_kg_m2 / (kMass_kg * kGravity_m_s2 * 0.5 * kLength_m)) *
                          (1.0 + kTilt_rad * kTilt_rad / 16.0);
  return crossings > 6 ? 2.0 * (last_s - first_s) / (crossings - 1) / period_s : 0.0;
}

inline constexpr std::array kBothIntegrators = {scene::IntegratorKind::kVelocityVerlet,
                                                scene::IntegratorKind::kImplicitEuler};

}  // namespace stillgrid::dynamics
