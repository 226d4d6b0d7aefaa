// The default beside the paper's transition and its snapshots held, on one path.

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "shared/display/transition.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/haptic_server/devices/recording_file.hpp"
#include "tests/laboratory/metrics.hpp"
#include "tests/laboratory/model_comparison.hpp"

namespace stillgrid::laboratory::comparison_test {
namespace {

constexpr double kDuration_s = 4.0;

/// A tool that goes with the sphere of moving_sphere, which comes at 0.1 m/s, pressed by 5.5 to 8.5
/// mm at 1 Hz.
std::string ride() {
  std::string text = "time_s,x_m,y_m,z_m\n";
  for (int i = 0; i <= static_cast<int>(1e3 * kDuration_s) + 1; ++i) {
    const double t = 1e-3 * i;
    const double come = t < 0.3 ? t / 0.3 : 1.0;
    const double depth_m = come * (0.007 + 0.0015 * std::sin(2.0 * std::numbers::pi * t)) - 1e-3;
    text += std::to_string(t) + ',' + std::to_string(-0.035 + 0.1 * t - depth_m) + ",0,0\n";
  }
  return text;
}

Contender contender_named(const std::string& name) {
  for (const Contender& contender : contenders())
    if (contender.name == name) return contender;
  throw std::logic_error(name);
}

TEST_CASE(
    "On a moving rigid body, snapshots 30 % early or late, local does not jump, and neither errs "
    "nor "
    "lags",
    "[comparison]") {
  const devices::RecordingFile path(ride());
  scene::SceneDescription scene =
      scene::load_scene(STILLGRID_SOURCE_DIR "/sim_server/scene/scenes/moving_sphere.toml");
  scene.tool_slip_speed_m_s = scene::kPenaltySlip_m_s;  // the paper's sum
  LabOptions options;
  options.device = "replay:file=" + path.path();
  options.latency_s = 0.1 * scene.period_s;
  options.jitter = 0.3;
  options.seed = GENERATE(1U, 2U);
  options.duration_s = kDuration_s;
  const LabRun reference = path_reference(scene, options);
  const auto measured = [&](const std::string& name) {
    return compare(scene, options, contender_named(name), reference, 0.5);
  };
  const ComparedRun hold = measured("hold"), linear = measured("linear"), local = measured("local");

  CHECK(hold.metrics.switches.jump_N.max > 1.0);  // 500 * 0.1 * 0.033 and more
  CHECK(local.metrics.error.rms_N < 1e-9);
  CHECK(hold.metrics.error.rms_N > 0.1);
  CHECK(linear.metrics.error.rms_N > 0.1);
  CHECK(linear.metrics.error.lag_s > local.metrics.error.lag_s + 2e-3);
  CHECK(local.stages.jnd.max < 1.0);
  CHECK(hold.stages.jnd.max > 1.0);
  CHECK(linear.stages.jnd.max > 1.0);
}

std::vector<Eigen::Vector3d> forces_of(const std::function<double(double t_s)>& force_N) {
  std::vector<Eigen::Vector3d> forces_N;
  for (int i = 0; i < 1000; ++i) forces_N.emplace_back(force_N(1e-3 * i), 0.0, 0.0);
  return forces_N;
}

TEST_CASE("A stage is a jump whole, a change of slew by half, and nothing that changes evenly",
          "[comparison]") {
  const auto even = forces_of([](double t_s) { return 1.0 + 3.0 * t_s; });
  CHECK(stages(even, 1000.0).jnd.max == Approx(0.0).margin(1e-9));
  const auto jump = forces_of([](double t_s) { return t_s < 0.5 ? 1.0 : 1.14; });
  CHECK(stages(jump, 1000.0).jnd.max == Approx(0.14 / (0.07 * 1.14)));
  CHECK(stages(jump, 1000.0).felt_share == Approx(0.01).epsilon(0.1));
  // Slew from 0 to 10 N/s: at most 0.1 N in 10 ms where there was nothing before, halved.
  const auto kink = forces_of([](double t_s) { return 5.0 + 10.0 * std::max(0.0, t_s - 0.5); });
  CHECK(stages(kink, 1000.0).jnd.max == Approx(0.05 / (0.07 * 5.1)).epsilon(0.02));
  const auto free = forces_of([](double t_s) { return t_s < 0.5 ? 0.0 : 1.0; });
  CHECK(stages(free, 1000.0).jnd.max == 0.0);  // contact that begins is none
}

TEST_CASE("From a time on, a run has its rows, jumps and energy since", "[comparison]") {
  LabRun run;
  for (int i = 0; i < 10; ++i) {
    recording::TickRow row;
    row.time_s = 0.1 * i;
    row.position_m.x() = 0.01 * i;
    row.force_N.x() = i;  // held over the next 0.01 m
    run.rows.push_back(row);
  }
  run.jumps = {{2, 1.0}, {7, 2.0}};
  const LabRun rest = from_time(run, 0.45);
  REQUIRE(rest.rows.size() == 5);
  CHECK(rest.rows.front().time_s == Approx(0.5));
  REQUIRE(rest.jumps.size() == 1);
  CHECK(rest.jumps[0].tick == 2);
  CHECK(rest.report.energy.given_J == Approx(0.01 * (5 + 6 + 7 + 8)));
}

}  // namespace
}  // namespace stillgrid::laboratory::comparison_test
