// What a snapshot of an explicit scene tells of its next steps: docs/algorithms/predict.md.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "shared/display/response.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::explicit_prediction_test {
namespace {

constexpr double kStep_s = 0.02, kStiffness_N_per_m = 200.0, kRadius_m = 0.01;

Simulation explicit_simulation(std::vector<bodies::BodyDescription> bodies) {
  scene::SceneDescription scene = sim_server::scene_of(
      std::move(bodies), sim_server::material_of(kStiffness_N_per_m), Eigen::Vector3d::Zero());
  scene.tool = {{Eigen::Vector3d::Zero(), kRadius_m}};
  scene.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  return Simulation(scene);
}

void step_with_tool(Simulation& simulation, double x_m) {
  const auto now_ns = static_cast<std::uint64_t>((simulation.world().time_s + kStep_s) * 1e9);
  (void)simulation.step(kStep_s, [&]() -> std::optional<ToolSample> {
    return ToolSample{.time_ns = now_ns, .position_m = {x_m, 0, 0}};
  });
}

Eigen::Vector3d vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data()).cast<double>();
}
Eigen::Vector3d position_m(const Simulation& simulation) {
  return bodies::sphere_motion(simulation.world(), simulation.world().spheres[0]).position_m;
}

/// The first sphere as a haptic loop of many ticks leads it on, the tool moving evenly.
Eigen::Vector3d led_m(const Simulation& simulation,
                      const publication::SnapshotPrediction& prediction, double from_x_m,
                      double to_x_m) {
  constexpr int kTicks = 1000;
  const proto::SphereRecord& record = simulation.snapshot().records()[0];
  REQUIRE(record.response != 0);
  const Eigen::Vector3d start_m = position_m(simulation),
                        velocity_m_s = vector(record.predicted_velocity_m_s);
  const auto& parts = prediction.responses[record.response - 1].modes;
  std::vector<display::ModeState> states;
  for (const proto::ResponseMode& mode : prediction.modes)
    states.push_back({0.0, mode.at_velocity});
  Eigen::Vector3d at_m = start_m;
  for (int tick = 1; tick <= kTicks; ++tick) {
    const double from = (tick - 1.0) / kTicks, to = static_cast<double>(tick) / kTicks;
    const Eigen::Vector3d line_m =
        at_m - Eigen::Vector3d(from_x_m + to * (to_x_m - from_x_m), 0.0, 0.0);
    const Eigen::Vector3d force_N =
        kStiffness_N_per_m *
        std::max(0.0, kRadius_m + simulation.world().spheres[0].radius_m - line_m.norm()) *
        line_m.normalized();
    at_m = start_m + to * kStep_s * velocity_m_s;
    for (std::size_t i = 0; i < states.size(); ++i) {
      const proto::ResponseMode& mode = prediction.modes[i];
      const display::ModeLaw law = display::step_law(mode, states[i], from, to);
      const double displaced =
          law.offset + law.compliance * (vector(parts[i]).dot(force_N) - law.push);
      at_m += displaced * vector(parts[i]);
      states[i] = display::state_after(mode, states[i], from, to, displaced);
    }
  }
  return at_m;
}

/// How far the next steps lead from there, of how far the tool goes.
double prediction_error(Simulation& simulation, double from_x_m, double to_x_m) {
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  for (const proto::ResponseMode& mode : prediction.modes)
    REQUIRE(display::gives_way_by_steps(mode));
  const Eigen::Vector3d expected_m = led_m(simulation, prediction, from_x_m, to_x_m);
  step_with_tool(simulation, to_x_m);
  return (position_m(simulation) - expected_m).norm() / std::abs(to_x_m - from_x_m);
}

/// The largest over a way of the tool.
double largest_error(Simulation& simulation, std::initializer_list<double> tool_x_m) {
  double tool_m = 0.0, largest = 0.0;
  step_with_tool(simulation, tool_m);
  for (const double x_m : tool_x_m) {
    largest = std::max(largest, prediction_error(simulation, tool_m, x_m));
    tool_m = x_m;
  }
  return largest;
}

TEST_CASE("The next explicit steps lead where the modes' own steps do, whatever the tool does",
          "[prediction]") {
  SECTION("of a free body") {
    Simulation simulation = explicit_simulation({sim_server::sphere({0.0195, 0, 0}, 0.01, 0.1)});
    CHECK(largest_error(simulation, {0.0005, 0.001, 0.003, 0.002}) < 0.01);
  }
  SECTION("of a light one on a spring, that swings within a period") {
    Simulation simulation = explicit_simulation(
        {sim_server::thread(2, {0.0185, 0, 0}, {0.1, 0, 0}, 0.005, 100.0, {1})});
    CHECK(largest_error(simulation, {0.0005, 0.001, 0.003, 0.002}) < 0.06);
  }
}

TEST_CASE("What the tool touches gives way in every snapshot, though no large step leads there",
          "[prediction]") {
  // A thread of 5 g is struck to and fro: from where it flies an implicit step of 20 ms stalls.
  Simulation simulation = explicit_simulation(
      {sim_server::thread(10, {0.0, 0.0, 0.045}, {0.0, 0.0, -0.045}, 0.0005, 200.0, {0})});
  int touched = 0;
  for (int i = 0; i < 200; ++i) {
    const double x_m = 0.03 * std::cos(0.4 * i);
    step_with_tool(simulation, x_m);
    double depth_m = 0.0;
    for (const bodies::SphereBinding& sphere : simulation.world().spheres)
      depth_m =
          std::max(depth_m, kRadius_m + sphere.radius_m -
                                (bodies::sphere_motion(simulation.world(), sphere).position_m -
                                 Eigen::Vector3d(x_m, 0.0, 0.0))
                                    .norm());
    const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
    if (depth_m == 0.0) continue;
    ++touched;
    CHECK_FALSE(prediction.modes.empty());
  }
  CHECK(touched > 5);
}

TEST_CASE("A mode's inertia, damping and stiffness are those of what the tool pushes",
          "[prediction]") {
  // On a spring with a damper to what is pinned, 10 g: along it P c and P^2 k beside m.
  constexpr double kMass_kg = 0.01, kSpring_N_per_m = 30.0, kDamping_N_s_per_m = 0.4;
  bodies::ThreadBody thread{.nodes = 2, .from_m = {0.0185, 0, 0}, .to_m = {0.1, 0, 0}};
  thread.springs.structural_stiffness_N_per_m = kSpring_N_per_m;
  thread.springs.spring_damping_N_s_per_m = kDamping_N_s_per_m;
  thread.springs.pinned_nodes = {1};
  thread.spheres.radius_m = 0.01;
  Simulation simulation =
      explicit_simulation({sim_server::body_of(thread, 2.0 * kMass_kg, {0.05925, 0, 0})});
  step_with_tool(simulation, 0.0);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  const proto::SphereRecord& record = simulation.snapshot().records()[0];
  REQUIRE(record.response != 0);
  const double whole_kg =
      kMass_kg + kStep_s * kDamping_N_s_per_m + kStep_s * kStep_s * kSpring_N_per_m;
  bool is_found = false;
  for (std::size_t i = 0; i < prediction.modes.size(); ++i) {
    if (std::abs(prediction.responses[record.response - 1].modes[i][0]) < 1e-3F) continue;
    is_found = true;
    CHECK(prediction.modes[i].inertia_share == Approx(kMass_kg / whole_kg).epsilon(0.02));
    CHECK(prediction.modes[i].damping_share ==
          Approx(kStep_s * kDamping_N_s_per_m / whole_kg).epsilon(0.02));
  }
  CHECK(is_found);
}

}  // namespace
}  // namespace stillgrid::dynamics::explicit_prediction_test
