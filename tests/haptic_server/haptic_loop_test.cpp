#include "haptic_server/haptic_loop.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "haptic_server/safety/device_limits.hpp"
#include "tests/haptic_server/devices/recording_file.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::haptic_server::haptic_loop_test {
namespace {

struct LoopRun {
  std::vector<recording::TickRow> rows;
  HapticReport report;
};

/// The whole loop against a scene that stands still.
LoopRun run_loop(const publication::StaticScene& fixed, const std::string& device_spec, int ticks,
                 const safety::SafetyOptions& limits = {},
                 const std::function<void(int, ToolOrders&)>& orders_at = {}) {
  rendering::PublishedScene scene(fixed, {}, rendering::kMillisecond_ns);
  device::Device device(device::parse_device_spec(STILLGRID_PLUGIN_DIR "/" + device_spec),
                        {.period_ns = rendering::kMillisecond_ns, .is_virtual = true});
  device.activate();
  const std::string session = "loop-" + std::to_string(::getpid());
  publication::ToolWriter tool(session, rendering::kMillisecond_ns, proto::Clock::kVirtual, 0);
  HapticLoop loop(device, tool, rendering::make_renderer(display::Transition::kHold),
                  safety::safety_limits(limits, device.descriptor()), rendering::kMillisecond_ns);
  LoopRun run;
  ToolOrders orders;
  loop.obey(orders);
  for (int tick = 0; tick < ticks; ++tick) {
    if (orders_at) orders_at(tick, orders);
    const std::uint64_t now_ns = static_cast<std::uint64_t>(tick) * rendering::kMillisecond_ns;
    scene.show({}, now_ns);
    REQUIRE(loop.sense(scene.view(), now_ns) == TickEnd::kGoOn);
    REQUIRE(loop.act(scene.view(), true, now_ns, run.rows.emplace_back()) == TickEnd::kGoOn);
    loop.count(run.rows.back(), run.report);
  }
  ::unlink((publication::own_segment_path(session, proto::SegmentKind::kTool) + ".lock").c_str());
  return run;
}

TEST_CASE("The tool tells what the tick before displayed, felt and took", "[haptic_loop]") {
  const auto transition = GENERATE(display::Transition::kLinear, display::Transition::kLocal,
                                   display::Transition::kHold);
  rendering::PublishedScene scene(rendering::plain_scene(500.0F, 0.01F), {0.02F},
                                  5 * rendering::kMillisecond_ns);
  const devices::RecordingFile still("t_s,x_m,y_m,z_m\n0,0,0,0.025\n10,0,0,0.025\n");
  device::Device device(
      device::parse_device_spec(STILLGRID_PLUGIN_DIR "/replay.so:file=" + still.path()),
      {.period_ns = rendering::kMillisecond_ns, .is_virtual = true});
  device.activate();
  const std::string session = "commanded-" + std::to_string(::getpid());
  publication::ToolWriter tool(session, rendering::kMillisecond_ns, proto::Clock::kVirtual, 0);
  const publication::ToolView commanded(*publication::SegmentReader::open(
      session, proto::SegmentKind::kTool, proto::kToolLayoutHash));
  ::unlink((publication::own_segment_path(session, proto::SegmentKind::kTool) + ".lock").c_str());
  HapticLoop loop(device, tool, rendering::make_renderer(transition),
                  safety::safety_limits({}, device.descriptor()), rendering::kMillisecond_ns);
  recording::TickRow row;
  bool is_touched = false;
  for (std::uint64_t tick = 0; tick < 300; ++tick) {
    const std::uint64_t now_ns = tick * rendering::kMillisecond_ns;
    if (tick % 5 == 0) {
      const double x_m = 1e-5 * static_cast<double>(tick);
      scene.show({{x_m, 0.0, 0.0}}, {{0.002, 0.0, 0.0}}, now_ns);
    }
    REQUIRE(loop.sense(scene.view(), now_ns) == TickEnd::kGoOn);
    const auto state = commanded.read();
    REQUIRE(state);
    CHECK(state->tick == tick + 1);
    CHECK(state->path_number == tick);
    CHECK(commanded.path().newest() == tick);
    CHECK(publication::has_sound_figures(*state));
    const proto::TickFigures& figures = state->before;
    CHECK(figures.contacts == static_cast<std::uint32_t>(tick == 0 ? 0 : row.contacts));
    CHECK(figures.flags == (tick == 0 ? 0U : row.flags));
    CHECK(figures.displayed.snapshot_id == row.snapshot_id);
    CHECK(figures.displayed.age_s == row.age_s);
    CHECK(figures.missed_ticks == tick / 2);
    if (tick > 0) {
      CHECK(figures.displayed.scene_epoch == scene.view().header().epoch);
      CHECK(figures.displayed.alpha == row.alpha);
      CHECK(figures.torque_N_m[1] == row.torque_N_m.y());
      CHECK(figures.work_ns == 100 + tick - 1);
      CHECK(figures.wake_up_latency_ns == 7);
    }
    REQUIRE(loop.act(scene.view(), true, now_ns, row) == TickEnd::kGoOn);
    loop.note_times(100 + tick, 7, (tick + 1) / 2);
    const rendering::RenderedTick& rendered = loop.rendered();
    is_touched = is_touched || rendered.force.contacts > 0;
  }
  CHECK(is_touched);
}

/// Touched by the tool's origin at z = 0.
publication::StaticScene wall_scene(float stiffness_N_per_m) {
  publication::StaticScene scene = rendering::plain_scene(stiffness_N_per_m, 0.005F);
  scene.planes = {{{0.0F, 0.0F, 1.0F}, -0.005F, 0, 0}};
  return scene;
}

/// The device of 0.1 kg and 1 N s/m, pushed against the wall for ever.
std::string pushed_phantom() {
  return "phantom.so:hand=none,path=still,mass_kg=0.1,damping_N_s_per_m=1,friction_N=0,max_force_N="
         "0,"
         "centre_z_m=0,velocity_z_m_s=-0.05,push_z_N=-1,resolution_m=0,limits=0";
}

double last_second_m(const LoopRun& run) {
  double low_m = 1e9, high_m = -1e9;
  for (std::size_t i = run.rows.size() - 1000; i < run.rows.size(); ++i) {
    low_m = std::min(low_m, run.rows[i].position_m.z());
    high_m = std::max(high_m, run.rows[i].position_m.z());
  }
  return high_m - low_m;
}

std::uint64_t damped_ticks(const LoopRun& run) {
  return static_cast<std::uint64_t>(std::count_if(
      run.rows.begin(), run.rows.end(),
      [](const recording::TickRow& row) { return (row.flags & safety::kFlagPassivity) != 0; }));
}

TEST_CASE("The report tells the energy of a wall that buzzes, and what the control took of it",
          "[haptic_loop]") {
  const LoopRun off = run_loop(wall_scene(5000.0F), pushed_phantom(), 10'000);
  CHECK(last_second_m(off) > 3e-3);
  CHECK(off.report.energy.given_J > 5e-3);
  CHECK(off.report.energy.most_given_J >= off.report.energy.given_J);
  CHECK(off.report.energy.dissipated_by_control_J == 0.0);
  CHECK(damped_ticks(off) == 0);

  const LoopRun on =
      run_loop(wall_scene(5000.0F), pushed_phantom(), 10'000, {.passivity_mass_kg = 0.1});
  CHECK(last_second_m(on) < 1e-5);
  CHECK(on.report.energy.most_given_J < 0.05 * off.report.energy.most_given_J);
  CHECK(on.report.energy.dissipated_by_control_J > 0.0);
  CHECK(damped_ticks(on) > 0);
  CHECK(on.report.flags[8] == damped_ticks(on));
  CHECK(safety::kSafetyFlagNames[8] == "passivity");
}

TEST_CASE("Passivity control leaves a wall alone whose damper takes more than its hold gives",
          "[haptic_loop]") {
  publication::StaticScene damped = wall_scene(500.0F);
  damped.materials[0].damping_N_s_per_m = 2.0F;
  const std::string device = pushed_phantom() + ",start_z_m=0.1";  // arrives after the fade
  const LoopRun off = run_loop(damped, device, 2000);
  REQUIRE(off.report.contact_ticks > 1000);
  REQUIRE(off.report.energy.most_given_J == 0.0);
  const LoopRun on = run_loop(damped, device, 2000, {.passivity_mass_kg = 0.1});
  const auto same = [](const recording::TickRow& a, const recording::TickRow& b) {
    return a.force_N == b.force_N;
  };
  CHECK(std::equal(off.rows.begin(), off.rows.end(), on.rows.begin(), same));
  CHECK(damped_ticks(on) == 0);
}

TEST_CASE("The limits of force hold for the control's damping too", "[haptic_loop]") {
  const LoopRun run =
      run_loop(wall_scene(5000.0F), pushed_phantom(), 2000, {.passivity_mass_kg = 1e6});
  REQUIRE(damped_ticks(run) > 0);
  CHECK(run.report.force_max_N <= 40.0 * (1.0 + 1e-12));
  CHECK(run.report.flags[9] > 0);  // clamped
}

/// A device at 5 mm in the wall, from 0.4 to 0.6 s on its way to 20 mm outside, then 2 mm farther.
devices::RecordingFile in_and_out() {
  return devices::RecordingFile(
      "t_s,x_m,y_m,z_m\n0,0,0,0.01\n0.1,0,0,-0.005\n0.4,0,0,-0.005\n0.6,0,0,0.02\n"
      "0.8,0,0,0.02\n0.9,0,0,0.022\n2,0,0,0.022\n");
}

/// After the first touch, where the damper sets in.
double largest_step_N(const LoopRun& run) {
  double largest = 0.0;
  for (std::size_t i = 200; i < run.rows.size(); ++i)
    largest = std::max(largest, (run.rows[i].force_N - run.rows[i - 1].force_N).norm());
  return largest;
}

TEST_CASE("A clutch holds the tool without a force, and the tool goes on from there",
          "[haptic_loop]") {
  const devices::RecordingFile file = in_and_out();
  const LoopRun run = run_loop(wall_scene(500.0F), "replay.so:file=" + file.path(), 1500, {},
                               [](int tick, ToolOrders& orders) {
                                 if (tick == 300) CHECK(orders.obey("tool.clutch", "on").empty());
                                 if (tick == 700) CHECK(orders.obey("tool.clutch", "off").empty());
                               });
  CHECK(run.rows[299].force_N.z() == Approx(2.5).epsilon(0.01));
  for (std::size_t i = 300; i < 700; ++i) CHECK(run.rows[i].position_m == run.rows[299].position_m);
  for (std::size_t i = 400; i < 700; ++i) CHECK(run.rows[i].force_N.isZero(0.0));
  CHECK(run.rows.back().position_m.z() == Approx(-0.003).margin(1e-5));  // 2 mm, not 27
  CHECK(run.rows.back().force_N.z() == Approx(1.5).epsilon(0.01));
  CHECK(largest_step_N(run) < 0.1);
  CHECK(run.report.energy.given_J <= 1e-3);
}

TEST_CASE("A new scale waits until no force is felt, and moves nothing", "[haptic_loop]") {
  const devices::RecordingFile file = in_and_out();
  const auto run_with = [&](const char* scale) {
    return run_loop(wall_scene(500.0F), "replay.so:file=" + file.path(), 1500, {},
                    [scale](int tick, ToolOrders& orders) {
                      if (tick == 300) CHECK(orders.obey("tool.scale", scale).empty());
                    });
  };
  const LoopRun as_before = run_with("1"), run = run_with("0.1");
  for (std::size_t i = 0; i < 440; ++i) {  // the device is out of the wall at 0.44 s
    CHECK(run.rows[i].position_m == as_before.rows[i].position_m);
    CHECK(run.rows[i].force_N == as_before.rows[i].force_N);
  }
  for (std::size_t i = 1; i < run.rows.size(); ++i)
    CHECK((run.rows[i].position_m - run.rows[i - 1].position_m).norm() <= 1.6e-4);  // the device's
  CHECK(run.rows.back().position_m.z() > 0.1 * 0.022);
  CHECK(run.rows.back().position_m.z() < 0.1 * 0.022 + 0.002);
  CHECK(largest_step_N(run) < 0.1);
}

TEST_CASE("A button is a clutch, and orders that make no sense are refused", "[haptic_loop]") {
  ToolOrders orders{.clutch_button = 1};
  CHECK(orders.holds_tool(2));
  CHECK_FALSE(orders.holds_tool(1));
  CHECK_FALSE(ToolOrders().holds_tool(~0U));
  CHECK(orders.obey("tool.clutch", "yes") == "value 'yes': expected on or off");
  CHECK(orders.obey("tool.scale", "0") == "value '0': expected a number from 0.01 to 100");
  CHECK(orders.obey("tool.scale", "nan") == "value 'nan': expected a number from 0.01 to 100");
  CHECK(orders.obey("tool.colour", "red") == "expected a known key: tool.clutch, tool.scale");
  CHECK(orders.scale == 1.0);
  CHECK_FALSE(orders.clutch);
}

TEST_CASE("Energy is of the device's own motion where the scene is shown larger", "[haptic_loop]") {
  publication::StaticScene doubled = wall_scene(1000.0F);
  doubled.device.scale = 2.0;
  const LoopRun run = run_loop(doubled, pushed_phantom(), 1000);
  double given_J = 0.0;
  for (std::size_t i = 1; i < run.rows.size(); ++i)
    given_J += run.rows[i - 1].force_N.dot(run.rows[i].position_m - run.rows[i - 1].position_m) / 2;
  CHECK(run.report.energy.given_J == Approx(given_J).epsilon(1e-9));
  CHECK(run.report.energy_J == Approx(given_J).epsilon(1e-9));
}

/// A wall pressed with the end of a lever of 0.1 m of the scene.
publication::StaticScene lever_scene(double scale) {
  publication::StaticScene scene = wall_scene(1000.0F);
  scene.tool[0].position_m = {0.1F, 0.0F, 0.0F};
  scene.device.scale = scale;
  return scene;
}

TEST_CASE("A lever is as long to the device as its own metres make it", "[haptic_loop]") {
  const devices::RecordingFile still(
      "t_s,x_m,y_m,z_m,qx,qy,qz,qw\n0,0,0,-0.001,0,0,0,1\n10,0,0,-0.001,0,0,0,1\n");
  const double scale = GENERATE(0.5, 1.0, 4.0);
  const LoopRun run = run_loop(lever_scene(scale), "replay.so:file=" + still.path(), 500);
  const recording::TickRow& last = run.rows.back();
  REQUIRE(last.force_N.z() > 0.1);
  CHECK(last.torque_N_m.y() == Approx(-0.1 / scale * last.force_N.z()).epsilon(1e-6));
}

TEST_CASE("Stiffness and speed are limited in the device's lengths", "[haptic_loop]") {
  const double scale = GENERATE(0.5, 1.0, 4.0);
  publication::StaticScene scene = wall_scene(1000.0F);
  scene.device.scale = scale;
  const devices::RecordingFile still("t_s,x_m,y_m,z_m\n0,0,0,-0.001\n10,0,0,-0.001\n");
  const LoopRun governed = run_loop(scene, "replay.so:file=" + still.path(), 500,
                                    {.max_stiffness_N_per_m = 500.0 * scale});
  CHECK(governed.rows.back().force_N.z() == Approx(0.5 * 1000.0 * 0.001 * scale));

  // Deep in the wall, then out of it at 0.5 m/s of the device.
  const devices::RecordingFile out(
      "t_s,x_m,y_m,z_m\n0,0,0,-0.01\n0.3,0,0,-0.01\n0.318,0,0,-0.001\n10,0,0,-0.001\n");
  const auto speed_ticks = [&](double limit_m_s) {
    const LoopRun run =
        run_loop(scene, "replay.so:file=" + out.path(), 320, {.max_speed_m_s = limit_m_s});
    return std::count_if(run.rows.begin(), run.rows.end(), [](const recording::TickRow& row) {
      return (row.flags & safety::kFlagSpeed) != 0;
    });
  };
  CHECK(speed_ticks(0.7) == 0);
  CHECK(speed_ticks(0.4) > 0);
}

TEST_CASE("The work of the torque is counted where the device tells its orientation",
          "[haptic_loop]") {
  const publication::StaticScene scene = lever_scene(1.0);
  constexpr int kTicks = 500;
  std::ostringstream file;
  std::vector<double> turn_rad;  // about y, which takes the tool's end down
  file.precision(17);
  file << "t_s,x_m,y_m,z_m,qx,qy,qz,qw\n";
  for (int tick = 0; tick <= kTicks; ++tick) {
    const double t_s = tick * 1e-3;
    turn_rad.push_back(0.1 * std::sin(20.0 * t_s));
    file << t_s << ",0,0," << 1e-3 * std::sin(37.0 * t_s) << ",0,"
         << std::sin(0.5 * turn_rad.back()) << ",0," << std::cos(0.5 * turn_rad.back()) << "\n";
  }
  const devices::RecordingFile recording(file.str());
  const LoopRun run = run_loop(scene, "replay.so:file=" + recording.path(), kTicks);
  double force_J = 0.0, torque_J = 0.0;
  for (std::size_t i = 1; i < run.rows.size(); ++i) {
    force_J += run.rows[i - 1].force_N.dot(run.rows[i].position_m - run.rows[i - 1].position_m);
    torque_J += run.rows[i - 1].torque_N_m.y() * (turn_rad[i] - turn_rad[i - 1]);
  }
  REQUIRE(std::abs(torque_J) > 1e-6);
  CHECK(run.report.energy_J == Approx(force_J).epsilon(1e-9));
  CHECK(run.report.energy.given_J == Approx(force_J + torque_J).epsilon(1e-6));
}

}  // namespace
}  // namespace stillgrid::haptic_server::haptic_loop_test
