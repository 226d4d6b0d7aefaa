#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/level_of_detail.hpp"
#include "tests/performance/blob_fit.hpp"
#include "tests/sim_server/spheres/recorded_contact.hpp"

// Blobs beside plain spheres: the time of one force on a tool pressed somewhere on the body, and
// beside it, as counters, how even the force is and how far the surface is off. Meshes are scaled
// to a box with a diagonal of 0.2 m; the folder of real inputs adds three to the one made here, or
// those of them that are named after the options.
namespace stillgrid::performance {
namespace {

constexpr double kDiagonal_m = 0.2;
constexpr double kTool_m = 0.02 * kDiagonal_m;
constexpr double kDepth_m = 0.25 * kTool_m;
constexpr double kFinest_m = 0.005 * kDiagonal_m;
constexpr int kLevels = 4;
constexpr std::size_t kSamples = 6000;

/// A body under test, made before anything is timed.
struct Level {
  std::string name;
  spheres::SurfaceSamples surface;
  spheres::BallBody balls;
  BlobBody blobs;
  spheres::ForceMap ball_map, blob_map;
  double ball_error_m, blob_error_m;
};

/// An octahedron split three times, on a sphere.
mesh::TriangleMesh sphere_mesh() {
  mesh::TriangleMesh mesh{
      {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}}};
  for (int split = 0; split < 3; ++split) {
    std::vector<Eigen::Vector3i> finer;
    for (const Eigen::Vector3i& triangle : mesh.triangles) {
      Eigen::Vector3i middle;
      for (int i = 0; i < 3; ++i) {
        middle[i] = static_cast<int>(mesh.vertices_m.size());
        mesh.vertices_m.push_back((mesh.vertices_m[static_cast<std::size_t>(triangle[i])] +
                                   mesh.vertices_m[static_cast<std::size_t>(triangle[(i + 1) % 3])])
                                      .normalized());
      }
      finer.push_back({triangle[0], middle[0], middle[2]});
      finer.push_back({triangle[1], middle[1], middle[0]});
      finer.push_back({triangle[2], middle[2], middle[1]});
      finer.push_back(middle);
    }
    mesh.triangles = finer;
  }
  return mesh;
}

void scale_to_diagonal(mesh::TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex_m : mesh.vertices_m) box.extend(vertex_m);
  for (Eigen::Vector3d& vertex_m : mesh.vertices_m) vertex_m *= kDiagonal_m / box.diagonal().norm();
}

/// All levels of one mesh.
std::vector<std::shared_ptr<const Level>> make_levels(const std::string& name,
                                                      mesh::TriangleMesh raw) {
  mesh::TriangleMesh mesh = mesh::make_closed(std::move(raw), name).mesh;
  scale_to_diagonal(mesh);
  const mesh::MeshDistance distance(mesh);
  const spheres::SurfaceSamples surface = spheres::reachable_samples(
      spheres::sample_surface(mesh, kSamples), distance, kTool_m, kDepth_m);
  const auto targets = distance_targets(surface, distance, kTool_m);
  std::vector<std::shared_ptr<const Level>> levels;
  for (const spheres::Decomposition& made : spheres::levels_of_detail(mesh, kFinest_m, kLevels)) {
    Level level{.name = name + "/" + std::to_string(made.balls.size()),
                .surface = surface,
                .balls = spheres::make_ball_body(made.balls, kTool_m),
                .blobs = fit_blobs(made.balls, targets, kTool_m),
                .ball_map = {},
                .blob_map = {},
                .ball_error_m = made.hausdorff_m,
                .blob_error_m = 0.0};
    level.ball_map = spheres::map_force(
        surface, kTool_m, kDepth_m,
        [&](const Eigen::Vector3d& tool_m) { return spheres::unit_force_m(level.balls, tool_m); });
    level.blob_map =
        spheres::map_force(surface, kTool_m, kDepth_m, [&](const Eigen::Vector3d& tool_m) {
          return unit_blob_force_m(level.blobs, kTool_m, tool_m);
        });
    level.blob_error_m = blob_surface_error_m(level.blobs, surface, distance);
    levels.push_back(std::make_shared<const Level>(std::move(level)));
  }
  return levels;
}

/// The time of one force, at the next of the pressed places.
template <class Force>
void time_force(benchmark::State& state, const Level& level, const spheres::ForceMap& map,
                double error_m, const Force& force) {
  const spheres::SurfaceSamples& surface = level.surface;
  constexpr std::size_t kStride = 7919;  // prime: from place to place, none near the last
  std::size_t i = 0;
  for (auto _ : state) {
    i = (i + kStride) % surface.points_m.size();
    benchmark::DoNotOptimize(
        force(surface.points_m[i] + (kTool_m - kDepth_m) * surface.normals[i]));
  }
  state.counters["spheres"] = static_cast<double>(level.balls.balls.size());
  state.counters["error_mm"] = 1e3 * error_m;
  state.counters["ripple"] = map.ripple;
  state.counters["least_over_most"] = map.min_over_max;
  state.counters["holes"] = map.hole_share;
  state.counters["tangential"] = map.tangential;
  state.counters["stiffness"] = map.effective_stiffness;
  state.counters["mean_over_depth"] = map.mean_m / kDepth_m;
}

void register_level(const std::shared_ptr<const Level>& level) {
  benchmark::RegisterBenchmark(("force/spheres/" + level->name).c_str(),
                               [level](benchmark::State& state) {
                                 time_force(state, *level, level->ball_map, level->ball_error_m,
                                            [&](const Eigen::Vector3d& tool_m) {
                                              return spheres::unit_force_m(level->balls, tool_m);
                                            });
                               });
  benchmark::RegisterBenchmark(
      ("force/blobs/" + level->name).c_str(), [level](benchmark::State& state) {
        time_force(state, *level, level->blob_map, level->blob_error_m,
                   [&](const Eigen::Vector3d& tool_m) {
                     return unit_blob_force_m(level->blobs, kTool_m, tool_m);
                   });
      });
}

void register_mesh(const std::string& name, mesh::TriangleMesh mesh) {
  for (const auto& level : make_levels(name, std::move(mesh))) register_level(level);
}

int program_main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const std::vector<std::string> asked(argv + 1, argv + argc);
  register_mesh("sphere", sphere_mesh());
  if (const auto data = spheres::real_data())
    for (const std::string file : {"sofa_torus.obj", "npm_bunny.off", "sofa_liver-smooth.obj"})
      if (asked.empty() || std::find(asked.begin(), asked.end(), file) != asked.end())
        register_mesh(file, mesh::load_mesh(*data / "meshes" / file, 0.01));
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  return stillgrid::performance::program_main(argc, argv);
}
