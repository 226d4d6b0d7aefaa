#include "tests/performance/work_precision_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <numbers>

#include "sim_server/scene/scene_file.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::performance {
namespace {

const Eigen::Vector3d kGravity_m_s2(0.0, 0.0, -9.81);
constexpr int kMasses = 10;
constexpr double kMass_kg = 0.01;

scene::SceneDescription shipped(const char* name) {
  return scene::load_scene(std::filesystem::path(STILLGRID_SOURCE_DIR) / "sim_server/scene/scenes" /
                           name);
}

}  // namespace

ChartScene cloth_scene(int nodes, double stiffness_N_per_m) {
  bodies::BodyDescription cloth = sim_server::sheet({nodes, nodes}, 1.0 / (nodes - 1),
                                                    1.0 / (nodes * nodes), stiffness_N_per_m);
  sim_server::shear_stiffness_N_per_m(cloth) = 0.5 * stiffness_N_per_m;
  sim_server::springs(cloth).bend_stiffness_N_per_m = 0.1 * stiffness_N_per_m;
  sim_server::springs(cloth).pinned_nodes = {0, nodes - 1};
  sim_server::packing(cloth) = {.spacing_m = 1.0, .radius_m = 1e-4};
  std::array<char, 64> name{};
  std::snprintf(name.data(), name.size(), "cloth_%dx%d_1e%.0f", nodes, nodes,
                std::log10(stiffness_N_per_m));
  return {.name = name.data(),
          .scene = sim_server::scene_of({cloth}, sim_server::material_of(1.0), kGravity_m_s2),
          .limit_s = nodes > 8 ? 2.0 : 0.25};
}

ChartScene hanging_chain_scene() {
  const double angle_rad = std::numbers::pi / 6.0;
  const Eigen::Vector3d end_m = kMasses * 0.1 * Eigen::Vector3d(0.5, 0.0, -std::cos(angle_rad));
  return {.name = "hanging_chain",
          .scene = sim_server::scene_of(
              {sim_server::thread(kMasses + 1, {0, 0, 0}, end_m, kMass_kg, 1000.0, {0})},
              sim_server::material_of(1.0), kGravity_m_s2)};
}

ChartScene chain_modes_scene() {
  return {.name = "chain_modes",
          .scene = sim_server::scene_of(
              {sim_server::thread(kMasses + 1, {0, 0, 0}, {0, 0, -1.0}, kMass_kg, 100.0, {0})},
              sim_server::material_of(1.0), kGravity_m_s2),
          .end_s = 0.5};
}

Eigen::Matrix3Xd chain_modes_positions_m(double time_s) {
  // Mode j of a chain fixed above and free below: sin(2 i x_j), w_j = 2 sqrt(k/m) sin(x_j).
  Eigen::Matrix3Xd places_m = Eigen::Matrix3Xd::Zero(3, kMasses + 1);
  for (int i = 0; i <= kMasses; ++i) places_m(2, i) = -i / double(kMasses);
  for (int j = 1; j <= kMasses; ++j) {
    const double x = (2 * j - 1) * std::numbers::pi / (2.0 * (2 * kMasses + 1));
    const double w_rad_s = 2.0 * std::sqrt(100.0 / kMass_kg) * std::sin(x);
    double load = 0.0, norm = 0.0;
    for (int i = 1; i <= kMasses; ++i) {
      load += std::sin(2 * i * x);
      norm += std::sin(2 * i * x) * std::sin(2 * i * x);
    }
    const double depth_m =
        9.81 * load / norm / (w_rad_s * w_rad_s) * (1.0 - std::cos(w_rad_s * time_s));
    for (int i = 1; i <= kMasses; ++i) places_m(2, i) -= depth_m * std::sin(2 * i * x);
  }
  return places_m;
}

ChartScene threads_scene() {
  ChartScene threads{.name = "threads", .scene = shipped("threads.toml")};
  for (bodies::BodyDescription& body : threads.scene.bodies) body.velocity_m_s = {0.3, 0.0, 0.0};
  return threads;
}

ChartScene tissue_scene() {
  return {.name = "tissue_and_blocks",
          .scene = shipped("tissue_and_blocks.toml"),
          .early_s = 0.1,
          .end_s = 0.3,
          .rest_s = 2.0,
          .smooth = false,
          .limit_s = 1.0};
}

std::vector<ChartScene> chart_scenes() {
  std::vector<ChartScene> scenes;
  for (const int nodes : {8, 32})
    for (const double stiffness_N_per_m : {1e3, 1e4, 1e5})
      scenes.push_back(cloth_scene(nodes, stiffness_N_per_m));
  scenes.push_back(hanging_chain_scene());
  scenes.push_back(threads_scene());
  scenes.push_back(tissue_scene());
  scenes.push_back(cloth_scene(100, 1e4));
  scenes.back().early_s = 0.1;
  scenes.back().end_s = 0.25;
  scenes.back().limit_s = 2.0;
  scenes.push_back(chain_modes_scene());
  for (ChartScene& scene : scenes)
    scene.scene.sleeping = false;  // methods differ at work, not at rest
  return scenes;
}

bool is_conservative(const ChartScene& scene) {
  const auto& bodies = scene.scene.bodies;
  return scene.smooth &&
         std::none_of(bodies.begin(), bodies.end(), [](const bodies::BodyDescription& body) {
           const bodies::SpringDescription* springs = bodies::springs_of(body);
           return springs != nullptr && springs->spring_damping_N_s_per_m > 0.0;
         });
}

Eigen::Matrix3Xd positions_m(const bodies::World& world) {
  std::vector<Eigen::Vector3d> places_m;
  for (const bodies::Node& node : world.nodes) places_m.push_back(node.position_m);
  for (const bodies::RigidBody& body : world.rigid_bodies)
    if (body.free) places_m.push_back(body.position_m);
  Eigen::Matrix3Xd columns_m(3, static_cast<Eigen::Index>(places_m.size()));
  for (Eigen::Index i = 0; i < columns_m.cols(); ++i)
    columns_m.col(i) = places_m[static_cast<std::size_t>(i)];
  return columns_m;
}

double rms_distance_m(const Eigen::Matrix3Xd& places_m, const Eigen::Matrix3Xd& reference_m) {
  if (places_m.cols() != reference_m.cols() || !places_m.allFinite())
    return std::numeric_limits<double>::infinity();
  return std::sqrt((places_m - reference_m).squaredNorm() / double(reference_m.cols()));
}

}  // namespace stillgrid::performance
