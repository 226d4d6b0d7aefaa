// The shipped scenes are solid wherever a tool meets them: their bodies held still, their own
// covers, materials and tools.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/lab.hpp"
#include "tests/laboratory/path_file.hpp"

namespace stillgrid::laboratory::shipped_solids_test {
namespace {

using Catch::Matchers::WithinAbs;
using Eigen::Vector3d;

constexpr double kDepth_m = 0.004, kTick_s = 1e-3;

/// A scene with its first hand alone, whose bodies stay where they are.
scene::SceneDescription held_still(const std::string& name, bool has_friction) {
  scene::SceneDescription scene = scene::load_scene(std::filesystem::path(STILLGRID_SOURCE_DIR) /
                                                    "sim_server/scene/scenes" / (name + ".toml"));
  const scene::Hand hand = scene::hands_of(scene).front();
  scene.hands.clear();
  scene.tool = hand.tool;
  scene.tool_slip_speed_m_s = hand.tool_slip_speed_m_s;
  scene.device = hand.device;
  scene.gravity_m_s2.setZero();
  scene.joints.clear();
  for (bodies::BodyDescription& body : scene.bodies) {
    body.motion =
        body.motion == bodies::Motion::kPrescribed ? bodies::Motion::kStatic : body.motion;
    body.mass_kg *= 1e8;
    body.velocity_m_s.setZero();
    body.angular_velocity_rad_s.setZero();
  }
  for (scene::MaterialDescription& material : scene.materials) {
    material.contact_damping_N_s_per_m = 0.0;
    if (!has_friction) material.friction = 0.0;
  }
  return scene;
}

LabRun run_along(const scene::SceneDescription& scene, const std::vector<PathPoint>& points) {
  const PathFile path(scene.device, points);
  LabOptions options;
  options.device = "replay:file=" + path.path().string();
  options.duration_s = points.back().time_s - 0.01;
  return run_lab(scene, options);
}

/// Places of the scene's spheres, points of fields and rigid bodies.
std::vector<Vector3d> places_m(const scene::SceneDescription& scene) {
  const bodies::World world = scene::build_world(scene);
  std::vector<Vector3d> places;
  for (const bodies::SphereBinding& sphere : world.spheres)
    places.push_back(bodies::sphere_motion(world, sphere).position_m);
  for (const auto* fixed : {&world.static_spheres, &world.static_points})
    for (const bodies::StaticSphere& sphere : *fixed) places.push_back(sphere.position_m);
  for (const bodies::RigidBody& body : world.rigid_bodies) places.push_back(body.position_m);
  if (places.empty()) places.push_back(scene.bodies.front().position_m);
  return places;
}

/// A place high above one of the bodies.
Vector3d above_a_body(const scene::SceneDescription& scene, std::mt19937& random) {
  const std::vector<Vector3d> places = places_m(scene);
  const auto higher = [](const Vector3d& a, const Vector3d& b) { return a.z() < b.z(); };
  Vector3d place_m = places[random() % places.size()];
  place_m.z() = std::ranges::max_element(places, higher)->z() + 0.1;
  return place_m;
}

/// Where a tool from there, led straight down at 0.2 m/s, is first pushed back.
std::optional<Vector3d> first_contact_m(const scene::SceneDescription& scene,
                                        const Vector3d& from_m) {
  constexpr double kSpeed_m_s = 0.2, kLongest_m = 0.3;
  std::vector<PathPoint> points;
  for (int tick = 0; tick * kTick_s * kSpeed_m_s < kLongest_m; ++tick)
    points.push_back({tick * kTick_s, from_m - Vector3d(0.0, 0.0, tick * kTick_s * kSpeed_m_s)});
  for (const recording::TickRow& row : run_along(scene, points).rows)
    if (row.rendered_N.norm() > 0.0)
      return row.position_m + Vector3d(0.0, 0.0, kTick_s * kSpeed_m_s);
  return std::nullopt;
}

double stiffest_N_per_m(const scene::SceneDescription& scene) {
  double stiffest = 0.0;
  for (const scene::MaterialDescription& material : scene.materials)
    stiffest = std::max(stiffest, material.contact_stiffness_N_per_m);
  return stiffest * static_cast<double>(scene.tool.size());
}

/// A scene with the place where its tool meets it first.
struct Met {
  scene::SceneDescription scene;
  Vector3d contact_m;
};

std::optional<Met> met(const std::string& name, unsigned seed, bool has_friction) {
  scene::SceneDescription scene = held_still(name, has_friction);
  std::mt19937 random(seed);
  const std::optional<Vector3d> contact_m = first_contact_m(scene, above_a_body(scene, random));
  if (!contact_m) return std::nullopt;
  return Met{std::move(scene), *contact_m};
}

Vector3d mean_N(const LabRun& run, std::size_t first, std::size_t count) {
  Vector3d sum_N = Vector3d::Zero();
  for (std::size_t i = first; i < first + count; ++i) sum_N += run.rows[i].rendered_N;
  return sum_N / static_cast<double>(count);
}

// `laparoscopy` is met by the penalty sum.
std::string any_scene() {
  return GENERATE("block_pinched", "cloth_held_by_two", "moving_sphere", "organ", "pendulum_chain",
                  "pillars", "sewn_ball", "threads", "tissue_and_blocks", "wall");
}

}  // namespace

TEST_CASE("A press on a shipped scene holds its load, within stiffness times depth",
          "[shipped_solids]") {
  constexpr double kNoise_m = 30e-6, kCreep_N = 5e-3;
  const std::string name = any_scene();
  const unsigned seed = GENERATE(range(1U, 4U));
  CAPTURE(name, seed);
  const std::optional<Met> here = met(name, seed, true);
  if (!here) return;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise_m(-0.5 * kNoise_m, 0.5 * kNoise_m);
  std::vector<PathPoint> points;
  for (int tick = 0; tick < 700; ++tick) {
    const Vector3d off_m(noise_m(random), noise_m(random), noise_m(random));
    const double down_m = kDepth_m * std::min(1.0, 0.01 * tick) - 2e-4;
    const double aside_m = 3e-4 * std::clamp(0.01 * (tick - 100), 0.0, 1.0);  // friction sticks
    points.push_back({tick * kTick_s, here->contact_m + Vector3d(aside_m, 0.0, -down_m) + off_m});
  }
  const LabRun run = run_along(here->scene, points);
  const double stiffness_N_per_m = stiffest_N_per_m(here->scene);
  for (const recording::TickRow& row : run.rows) {
    const double deep_m = std::max(0.0, here->contact_m.z() - row.position_m.z());
    REQUIRE(row.rendered_N.norm() < 1.05 * stiffness_N_per_m * (deep_m + 2.0 * kNoise_m));
  }
  const Vector3d first_N = mean_N(run, 250, 100);
  CHECK(first_N.norm() > 0.05 * stiffness_N_per_m * kDepth_m);
  CHECK((mean_N(run, 550, 100) - first_N).norm() < kCreep_N);
  for (std::size_t i = 250; i < run.rows.size(); ++i)
    REQUIRE((run.rows[i].rendered_N - first_N).norm() <
            kCreep_N + 2.0 * stiffness_N_per_m * kNoise_m);
}

TEST_CASE("A hand that stirs on a shipped scene without friction gains nothing",
          "[shipped_solids]") {
  constexpr int kTurn = 400;  // ticks
  const std::string name = any_scene();
  const unsigned seed = GENERATE(range(1U, 4U));
  CAPTURE(name, seed);
  const std::optional<Met> here = met(name, seed, false);
  if (!here) return;
  std::vector<PathPoint> points;
  for (int tick = 0; tick < 200 + 4 * kTurn + 10; ++tick) {
    const double turn_rad = 2.0 * std::numbers::pi * std::max(0, tick - 200) / kTurn;
    const Vector3d beside_m(0.002 * std::sin(turn_rad), 0.002 * (1.0 - std::cos(turn_rad)), 0.0);
    const double down_m = kDepth_m * std::min(1.0, 0.005 * tick) - 2e-4;
    points.push_back({tick * kTick_s, here->contact_m - down_m * Vector3d::UnitZ() + beside_m});
  }
  const LabRun run = run_along(here->scene, points);
  REQUIRE(run.rows.size() > 200 + 4 * kTurn - 5);
  double given_J = 0.0, moved_J = 0.0;
  for (std::size_t i = 195 + 3 * kTurn; i < 195 + 4 * kTurn; ++i) {
    const Vector3d mean_force_N = 0.5 * (run.rows[i].rendered_N + run.rows[i - 1].rendered_N);
    const double work_J = mean_force_N.dot(run.rows[i].position_m - run.rows[i - 1].position_m);
    given_J += work_J;
    moved_J += std::abs(work_J);
  }
  // The edges of a cover of spheres give some.
  CHECK(given_J <= 0.005 * moved_J);
}

}  // namespace stillgrid::laboratory::shipped_solids_test
