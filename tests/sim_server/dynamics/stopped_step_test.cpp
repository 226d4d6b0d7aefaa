#include <atomic>
#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>

#include "sim_server/dynamics/choice/predicted_cost.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid {
namespace {

/// A hanging sheet by a method; large enough that its factors are made on a thread of their own.
SceneDescription hanging_sheet(const Method& method, int side) {
  BodyDescription body = sheet({side, side}, 0.01, 1e-4, 20.0);
  shear_stiffness_N_per_m(body) = 10.0;
  springs(body).bend_stiffness_N_per_m = 2.0;
  springs(body).pinned_nodes = {0, side - 1};
  SceneDescription scene = scene_of({body}, material_of(100.0), {0, 0, -9.81});
  scene.method = method;
  return scene;
}

bool same_nodes(const World& a, const World& b) {
  for (std::size_t i = 0; i < a.nodes.size(); ++i)
    if (a.nodes[i].position_m != b.nodes[i].position_m ||
        a.nodes[i].velocity_m_s != b.nodes[i].velocity_m_s)
      return false;
  return a.time_s == b.time_s;
}

const Method kMethods[] = {{.integrator = IntegratorKind::kVelocityVerlet, .substeps = 1'000'000},
                           {},
                           {.solver = SolverKind::kNewtonLu},
                           {.solver = SolverKind::kNewtonCg},
                           {.solver = SolverKind::kBroyden},
                           {.solver = SolverKind::kKinsolNewtonKrylov},
                           {.integrator = IntegratorKind::kCvodeBdf},
                           {.integrator = IntegratorKind::kArkodeDirk}};

TEST_CASE("A step that is stopped leaves the world where it was, and takes it up again",
          "[stopped_step]") {
  const std::size_t index = GENERATE(range(std::size_t{0}, std::size(kMethods)));
  Method method = kMethods[index];
  INFO(describe(method));
  const SceneDescription scene = hanging_sheet(method, 50);
  Simulation simulation(scene);
  const World before = simulation.world();
  std::atomic<bool> stop = false;
  const StepReport report =
      simulation.step(0.01,
                      [&] {
                        stop = true;  // after the contacts were found, before anything is solved
                        return std::nullopt;
                      },
                      {.stop = &stop});
  CHECK(report.stopped);
  CHECK(report.solve.iterations <= 1);
  CHECK(same_nodes(simulation.world(), before));
  if (method.substeps > 1) return;  // its million substeps are of no interest

  stop = false;
  CHECK_FALSE(simulation.step(0.01, [] { return std::nullopt; }, {.stop = &stop}).stopped);
  Simulation fresh(scene);
  (void)fresh.step(0.01, [] { return std::nullopt; });
  CHECK(same_nodes(simulation.world(), fresh.world()));
}

TEST_CASE("As many substeps as are said to be stable are, half of them are not", "[stopped_step]") {
  const auto energy_gain = [](double share) {
    SceneDescription scene = hanging_sheet({.integrator = IntegratorKind::kSymplecticEuler}, 12);
    scene.gravity_m_s2.setZero();
    scene.bodies[0].angular_velocity_rad_s = {0, 3, 1};  // so that springs stretch
    const int stable = stable_substeps(load_of(build_world(scene)), 0.05);
    REQUIRE(stable > 4);
    scene.method.substeps = std::max(1, static_cast<int>(share * stable));
    Simulation simulation(scene);
    const double start_J = mechanical_energy_J(simulation.world());
    double most_J = start_J;
    try {
      for (int step = 0; step < 40; ++step) {
        (void)simulation.step(0.05, [] { return std::nullopt; });
        most_J = std::max(most_J, mechanical_energy_J(simulation.world()));
      }
    } catch (const std::domain_error&) {  // beyond a float's range
      return std::numeric_limits<double>::infinity();
    }
    return most_J / start_J;
  };
  CHECK(energy_gain(1.0) < 1.2);
  CHECK(energy_gain(0.5) > 10.0);
}

}  // namespace
}  // namespace stillgrid
