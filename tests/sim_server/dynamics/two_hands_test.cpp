#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "sim_server/dynamics/step/energy_account.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::two_hands_test {
namespace {

constexpr double kStep_s = 0.01, kStiffness_N_per_m = 500.0;

/// A ball of 10 mm at the origin, and hands with a tool of 10 mm each.
scene::SceneDescription held_ball(std::size_t hands) {
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                           sim_server::material_of(kStiffness_N_per_m), Eigen::Vector3d::Zero());
  scene.method = {.integrator = scene::IntegratorKind::kImplicitEuler, .tolerance_m_s = 1e-12};
  for (std::size_t hand = 0; hand < hands; ++hand)
    scene.hands.push_back({std::string(1, static_cast<char>('a' + hand)),
                           {{Eigen::Vector3d::Zero(), 0.01}},
                           0.05,
                           {}});
  return scene;
}

TakeTool tool_at(const Simulation& simulation, double x_m, double speed_m_s = 0.0) {
  const auto now_ns = static_cast<std::uint64_t>((simulation.world().time_s + kStep_s) * 1e9);
  return [=]() -> std::optional<ToolSample> {
    return ToolSample{
        .time_ns = now_ns, .position_m = {x_m, 0, 0}, .velocity_m_s = {speed_m_s, 0, 0}};
  };
}

TakeTool nobody() {
  return []() -> std::optional<ToolSample> { return std::nullopt; };
}

StepReport step(Simulation& simulation, const std::vector<TakeTool>& take) {
  StepReport report = simulation.step(kStep_s, take);
  REQUIRE(report.solve.converged);
  return report;
}

double ball_x_m(const Simulation& simulation) {
  return simulation.world().rigid_bodies[0].position_m.x();
}

}  // namespace

TEST_CASE("What two hands press on a ball cancels, and each is booked its own work",
          "[two_hands]") {
  Simulation simulation(held_ball(2));
  simulation.account_energy();
  StepReport report;
  for (int i = 0; i <= 20; ++i) {
    const double x_m = 0.0199 - 1e-4 * i;
    report = step(simulation, {tool_at(simulation, -x_m), tool_at(simulation, x_m)});
    CHECK(std::abs(ball_x_m(simulation)) < 1e-12);
    CHECK(momentum_kg_m_per_s(simulation.world()).norm() < 1e-12);
  }
  CHECK(report.tools[0].work_J > 1e-4);
  CHECK(report.tools[0].work_J == Approx(report.tools[1].work_J));
  const EnergyAccount account = *simulation.energy_account();
  CHECK(report.tools[0].work_J + report.tools[1].work_J == Approx(account.flow.given_J));

  // One that goes takes along what its contact holds, and the other presses on alone.
  const double before_J = report.tools[0].work_J;
  report = step(simulation, {nobody(), tool_at(simulation, 0.0179)});
  CHECK(report.tools[0].work_J < before_J);
  CHECK(report.tools[0].time_ns == 0);
  CHECK(report.tools[1].time_ns > 0);
  CHECK(ball_x_m(simulation) < 0.0);
}

TEST_CASE("A hand that is the only one feels the same whether it has a name or not",
          "[two_hands]") {
  scene::SceneDescription named = held_ball(1), plain = held_ball(0);
  plain.tool = named.hands[0].tool;
  plain.tool_slip_speed_m_s = named.hands[0].tool_slip_speed_m_s;
  Simulation one(named), other(plain);
  for (int i = 0; i < 30; ++i) {
    const double x_m = -0.0195 + 2e-4 * i;
    step(one, {tool_at(one, x_m, 0.02)});
    step(other, {tool_at(other, x_m, 0.02)});
    CHECK(ball_x_m(one) == ball_x_m(other));
  }
}

}  // namespace stillgrid::dynamics::two_hands_test
