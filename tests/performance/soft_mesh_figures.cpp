// What a step of soft meshes and cloths costs by each method: prints docs/charts/soft_meshes.csv,
// of which --small only the smallest of each and few steps. The mesh is the real inputs' liver, or
// without them the shipped organ at four times its size; times are of the processor.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim_server/dynamics/choice/predicted_cost.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::performance {
namespace {

using scene::IntegratorKind;
using scene::SolverKind;

constexpr double kYoung_Pa =
    5000.0;                         // of liver; a lattice's springs have about this times its edge
constexpr double kSettle_s = 1.0;   // a mesh sags first
constexpr int kSteps = 40;          // measured
constexpr double kMax_s = 1.5;      // of processor time a series may take
constexpr int kLongSteps = 19'800;  // ten minutes: how often a step is late
constexpr double kLong_s = 600.0;   // of processor time they may take
constexpr std::size_t kMaxFactorised = 1100;  // nodes: beyond, factors take seconds a step

constexpr std::string_view kCloth = "cloth", kLong = "pressed for ten minutes";

double processor_s() {
  std::timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

scene::SceneDescription read_mesh() {
  const std::filesystem::path root = STILLGRID_SOURCE_DIR;
  const auto liver = root / "../shared/data/meshes/sofa_liver-smooth.obj";
  const auto organ = root / "sim_server/scene/scenes/organ.obj";
  const bool is_here = std::filesystem::exists(liver);
  const std::string text = R"(
format = 2
[simulation]
rate_hz = 33.0
[tool]
radius_m = 0.01
[[material]]
name = "organ"
contact_stiffness_N_per_m = 400.0
contact_damping_N_s_per_m = 1.0
friction = 0.3
[[body]]
name = "table"
kind = "plane"
point_m = [0.0, 0.0, -0.08]
normal = [0.0, 0.0, 1.0]
material = "organ"
[[body]]
name = "mesh"
kind = "mesh"
mass_kg = 1.0
spheres = { tolerance_m = 0.004 }
normalise = { tool_radius_m = 0.01, press_depth_m = 0.005 }
lattice_m = 0.03
spring_stiffness_N_per_m = { structural = 1.0, shear = 1.0, bend = 1.0 }
material = "organ"
)" + std::string("file = \"") +
                           (is_here ? liver : organ).string() +
                           "\"\nscale = " + (is_here ? "0.04\n" : "4.0\n");
  return scene::read_scene(text, root / "mesh.toml");
}

/// The mesh on the lattice that comes nearest to so many nodes.
scene::SceneDescription mesh_of(scene::SceneDescription scene, std::size_t nodes) {
  bodies::BodyDescription& body = scene.bodies.back();
  auto& mesh = std::get<bodies::SoftMeshBody>(body.shape);
  double fine_m = 0.006, coarse_m = 0.06;
  for (int i = 0; i < 30; ++i) {
    const double spacing_m = std::sqrt(fine_m * coarse_m);
    mesh.lattice = bodies::lattice_round(mesh.balls, spacing_m);
    if (mesh.lattice.nodes_m.size() == nodes) break;
    (mesh.lattice.nodes_m.size() > nodes ? fine_m : coarse_m) = spacing_m;
  }
  const double stiffness_N_per_m = kYoung_Pa * mesh.lattice.spacing_m.x();
  mesh.springs.structural_stiffness_N_per_m = stiffness_N_per_m;
  mesh.springs.shear_stiffness_N_per_m = 0.5 * stiffness_N_per_m;
  mesh.springs.bend_stiffness_N_per_m = 0.1 * stiffness_N_per_m;
  mesh.springs.spring_damping_N_s_per_m = stiffness_N_per_m / 1500.0;
  scene.sleeping = false;
  return scene;
}

/// 1 m x 1 m, 1 kg, held at two corners.
scene::SceneDescription cloth_of(int side) {
  bodies::BodyDescription body =
      sim_server::sheet({side, side}, 1.0 / (side - 1), 1.0 / (side * side), 1e4);
  sim_server::shear_stiffness_N_per_m(body) = 5e3;
  sim_server::springs(body).bend_stiffness_N_per_m = 1e3;
  sim_server::springs(body).pinned_nodes = {0, side - 1};
  scene::SceneDescription scene = sim_server::scene_of({body}, {}, {0.0, 0.0, -9.81});
  scene.period_s = 0.01;
  return scene;
}

/// The tool goes 15 mm into the top of what has sagged and comes back, once in two seconds.
class Press {
 public:
  explicit Press(const bodies::World& world) : top_m_(0.0, 0.0, -INFINITY) {
    for (const bodies::Node& node : world.nodes)
      if (node.position_m.z() > top_m_.z()) top_m_ = node.position_m;
  }
  [[nodiscard]] dynamics::ToolSample at(double time_s) const {
    constexpr double kDepth_m = 0.015, kPulse_rad_s = std::numbers::pi;
    dynamics::ToolSample sample;
    sample.time_ns = static_cast<std::uint64_t>(1e9 * time_s) + 1;
    const double share = 0.5 - 0.5 * std::cos(kPulse_rad_s * time_s);
    sample.position_m = top_m_ + Eigen::Vector3d(0.0, 0.0, 0.01 - kDepth_m * share);
    sample.velocity_m_s.z() = -kDepth_m * 0.5 * kPulse_rad_s * std::sin(kPulse_rad_s * time_s);
    return sample;
  }

 private:
  Eigen::Vector3d top_m_;
};

struct Series {
  std::string_view what;
  scene::SceneDescription scene;
  bool is_pressed = false;
  int steps = kSteps;
  double most_s = kMax_s;
};

/// The scene as velocity Verlet leaves it after so long.
dynamics::Simulation begun(const scene::SceneDescription& scene, double settle_s) {
  scene::SceneDescription settling = scene;
  settling.method = {.integrator = IntegratorKind::kVelocityVerlet};
  dynamics::Simulation simulation(settling);
  while (simulation.world().time_s < settle_s)
    (void)simulation.step(scene.period_s, [] { return std::nullopt; });
  return {scene, simulation.world()};
}

/// One line of the table: a series of steps by one method.
void print_series(const Series& series, const scene::Method& method) {
  scene::SceneDescription scene = series.scene;
  scene.method = method;
  const double period_s = scene.period_s;
  std::vector<double> step_ms;
  double iterations = 0.0, predicted_ms = 0.0;
  std::size_t nodes = 0;
  std::string ended = "all";
  try {
    dynamics::Simulation simulation = begun(scene, series.is_pressed ? kSettle_s : 0.0);
    nodes = simulation.world().nodes.size();
    if (scene::factorises(method) && nodes > kMaxFactorised) return;
    predicted_ms = dynamics::predicted_ms(dynamics::load_of(simulation.world()), method, period_s);
    const double began_s = processor_s();
    const Press press(simulation.world());
    const double start_s = simulation.world().time_s;
    for (int i = 0; i < series.steps; ++i) {
      const double time_s = simulation.world().time_s - start_s;
      const double step_began_s = processor_s();
      const dynamics::StepReport report =
          simulation.step(period_s, [&]() -> std::optional<dynamics::ToolSample> {
            if (!series.is_pressed) return std::nullopt;
            return press.at(time_s + period_s);
          });
      step_ms.push_back(1e3 * (processor_s() - step_began_s));
      iterations += report.solve.iterations;
      if (!report.solve.converged) ended = "not converged";
      if (processor_s() - began_s > series.most_s) break;
    }
  } catch (const std::domain_error&) {
    ended = "unstable";
  }
  if (step_ms.empty()) return;
  const auto late =
      std::count_if(step_ms.begin(), step_ms.end(), [&](double ms) { return ms > 1e3 * period_s; });
  const double count = static_cast<double>(step_ms.size());
  std::sort(step_ms.begin(), step_ms.end());
  std::printf("%s,%zu,\"%s\",%zu,%.4g,%.4g,%.4g,%.4g,%.3g,%.4g,%s\n", series.what.data(), nodes,
              scene::describe(method).c_str(), step_ms.size(), step_ms[step_ms.size() / 2],
              step_ms[step_ms.size() * 9 / 10], step_ms.back(), static_cast<double>(late) / count,
              iterations / count, predicted_ms, ended.c_str());
  std::fflush(stdout);
}

std::vector<scene::Method> methods_of(std::string_view what) {
  if (what == kLong) return {{.integrator = IntegratorKind::kVelocityVerlet}};
  std::vector<scene::Method> methods = {{.integrator = IntegratorKind::kVelocityVerlet},
                                        {.integrator = IntegratorKind::kSymplecticEuler}};
  for (const SolverKind& solver : scene::kSolvers) methods.push_back({.solver = solver});
  for (const IntegratorKind& integrator : {IntegratorKind::kBdf2, IntegratorKind::kTrapezoid})
    methods.push_back({.integrator = integrator, .solver = SolverKind::kNewtonCg});
  if (what != kCloth)
    methods.push_back({.integrator = IntegratorKind::kCvodeBdf, .tolerance_m_s = 1e-4});
  return methods;
}

int program_main(bool is_small, std::string_view only) {
  std::vector<Series> series;
  const scene::SceneDescription mesh = read_mesh();
  for (const std::size_t nodes : {441U, 1048U, 3000U}) {
    if (is_small && nodes > 441) break;
    series.push_back({"sagging", mesh_of(mesh, nodes)});
    series.push_back({"pressed", mesh_of(mesh, nodes), true});
    if (!is_small) series.push_back({kLong, mesh_of(mesh, nodes), true, kLongSteps, kLong_s});
  }
  for (const int side : {8, 32, 100})
    if (!is_small || side == 8) series.push_back({kCloth, cloth_of(side)});
  std::printf(
      "load,nodes,method,steps,median_ms,p90_ms,worst_ms,late_share,iterations,predicted_ms,"
      "steps_made\n");
  for (Series& own : series) {
    if (is_small) own.steps = 5;
    for (const scene::Method& method : methods_of(own.what))
      if (scene::describe(method).find(only) != std::string::npos) print_series(own, method);
  }
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  const std::string_view first = argc > 1 ? argv[1] : "";
  const bool is_small = first == "--small";
  return stillgrid::performance::program_main(is_small, is_small ? "" : first);
}
