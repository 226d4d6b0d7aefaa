#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::late_samples_test {
namespace {

constexpr double kStep_s = 0.01;

ToolSample sample_at(std::uint64_t time_ns, double x_m, double velocity_m_s = 0.0) {
  return {.time_ns = time_ns, .position_m = {x_m, 0, 0}, .velocity_m_s = {velocity_m_s, 0, 0}};
}

/// Offers one sample after the other, then the last one again and again.
class Offers {
 public:
  explicit Offers(std::vector<ToolSample> samples) : samples_(std::move(samples)) {}
  std::optional<ToolSample> operator()() {
    return samples_[std::min<std::size_t>(static_cast<std::size_t>(asked_++), samples_.size() - 1)];
  }
  [[nodiscard]] int asked() const { return asked_; }

 private:
  std::vector<ToolSample> samples_;
  int asked_ = 0;
};

StepReport step_with(Simulation& simulation, std::vector<ToolSample> samples) {
  return simulation.step(kStep_s, Offers(std::move(samples)));
}

/// A free ball before the tool, on the x axis, with damper and friction.
scene::SceneDescription pushed_ball(const scene::Method& method) {
  scene::SceneDescription scene = sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                                                       sim_server::material_of(200.0, 0.5, 0.3));
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  scene.method = method;
  return scene;
}

const scene::Method kVerlet{.integrator = scene::IntegratorKind::kVelocityVerlet};

double speed_m_s(const Simulation& simulation) {
  return simulation.world().rigid_bodies[0].velocity_m_s.x();
}

TEST_CASE("Every tick of an explicit step goes on to the newest sample", "[late_samples]") {
  Simulation late(pushed_ball(kVerlet)), in_steps(pushed_ball(kVerlet));
  for (Simulation* simulation : {&late, &in_steps})
    (void)step_with(*simulation, {sample_at(1, -0.021)});
  Offers offers({sample_at(5, -0.018), sample_at(7, -0.017), sample_at(8, -0.016)});

  const StepReport report = late.step(kStep_s, [&] { return offers(); });

  // Ten ticks, the first of them towards the first sample.
  double x_m = -0.021;
  const double newest_m[] = {-0.018, -0.017, -0.016};
  for (int tick = 0; tick < 10; ++tick) {
    x_m += (newest_m[std::min(tick, 2)] - x_m) / (10 - tick);
    const auto time_ns = static_cast<std::uint64_t>(10 + tick);
    (void)in_steps.step(0.1 * kStep_s, [&] { return sample_at(time_ns, x_m); });
  }
  CHECK(offers.asked() == 10);
  CHECK(report.tools[0].time_ns == 8);
  REQUIRE(speed_m_s(late) > 1e-3);
  CHECK(speed_m_s(late) == Approx(speed_m_s(in_steps)).epsilon(1e-6));
}

TEST_CASE("A sample that is no later changes nothing, to the bit", "[late_samples]") {
  scene::SceneDescription scene = pushed_ball(kVerlet);
  bodies::BodyDescription cloth = sim_server::sheet({4, 4}, 0.02, 0.002, 500.0);
  cloth.position_m = {0.03, 0, 0};
  scene.bodies.push_back(cloth);
  Simulation again(scene), once(scene);
  for (int i = 0; i < 100; ++i) {
    const ToolSample sample =
        sample_at(static_cast<std::uint64_t>(10 * i + 9), -0.02 + 4e-4 * i, 0.04);
    const ToolSample stale = sample_at(sample.time_ns - 9, 1.0);
    Offers same({sample, sample, stale});
    int asked = 0;
    (void)again.step(kStep_s, [&] { return same(); });
    (void)once.step(kStep_s, [&] { return asked++ == 0 ? std::optional(sample) : std::nullopt; });
    REQUIRE(same.asked() > 1);
  }

  REQUIRE(again.world().rigid_bodies[0].position_m.x() > 0.01);
  CHECK(again.world().rigid_bodies[0].position_m == once.world().rigid_bodies[0].position_m);
  CHECK(again.world().rigid_bodies[0].velocity_m_s == once.world().rigid_bodies[0].velocity_m_s);
  for (std::size_t i = 0; i < again.world().nodes.size(); ++i)
    CHECK(again.world().nodes[i].position_m == once.world().nodes[i].position_m);
}

TEST_CASE("A later sample beyond a body does not take the tool through it", "[late_samples]") {
  Simulation simulation(pushed_ball(kVerlet));
  (void)step_with(simulation, {sample_at(1, -0.1)});

  const StepReport report = step_with(simulation, {sample_at(2, -0.09), sample_at(3, 0.1)});

  CHECK(report.tools[0].time_ns == 3);
  CHECK(report.crossings_left == 0);
  CHECK(report.substeps > 1);
  CHECK(speed_m_s(simulation) > 0.05);
}

TEST_CASE("A later sample wakes what it touches", "[late_samples]") {
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::box({0, 0, 0.0145}, Eigen::Vector3d::Constant(0.03), 0.1, {0.02, 0.005}),
       sim_server::floor_at(0.0)},
      sim_server::material_of(1250.0, 2.0, 0.5), {0, 0, -9.81});
  scene.method = kVerlet;
  scene.sleeping = true;
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  Simulation simulation(scene);
  std::uint64_t time_ns = 0;
  while (!simulation.world().bodies[0].is_sleeping && time_ns < 1000)
    (void)step_with(simulation, {sample_at(++time_ns, -0.04)});
  REQUIRE(simulation.world().bodies[0].is_sleeping);

  // Below its upper edge, from the side.
  ToolSample pressing = sample_at(time_ns + 2, -0.018);
  pressing.position_m.z() = 0.025;
  ToolSample waiting = pressing;
  waiting.time_ns = time_ns + 1;
  waiting.position_m.x() = -0.04;
  const StepReport report = step_with(simulation, {waiting, pressing});

  CHECK(report.tools[0].time_ns == time_ns + 2);
  CHECK_FALSE(simulation.world().bodies[0].is_sleeping);
  CHECK(speed_m_s(simulation) > 0.0);
}

TEST_CASE("With late samples too the tool gives its force times its way", "[late_samples]") {
  constexpr double kFine_s = 1e-4, kSpeed_m_s = 0.2;
  scene::SceneDescription scene = pushed_ball(kVerlet);
  Simulation simulation(scene);
  simulation.account_energy();
  double work_J = 0.0;
  for (int i = 1; i <= 2000; ++i) {
    const double x_m = -0.0205 + kSpeed_m_s * kFine_s * i, before_m_s = speed_m_s(simulation);
    const auto time_ns = static_cast<std::uint64_t>(100 * i);
    (void)simulation.step(kFine_s,
                          Offers({sample_at(time_ns, x_m - 0.3 * kSpeed_m_s * kFine_s, kSpeed_m_s),
                                  sample_at(time_ns + 30, x_m, kSpeed_m_s)}));
    work_J += 0.1 * (speed_m_s(simulation) - before_m_s) * kSpeed_m_s;
  }

  const EnergyAccount account = *simulation.energy_account();
  REQUIRE(speed_m_s(simulation) > 0.1);
  CHECK(account.flow.given_J == Approx(work_J).epsilon(1e-3));
  CHECK(account.flow.contact_damping_J > 0.0);
  CHECK(std::abs(account.numerical_J()) < 0.02 * work_J);
}

}  // namespace
}  // namespace stillgrid::dynamics::late_samples_test
