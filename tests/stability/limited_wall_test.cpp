// A device with the limits that it declares, at a wall that it is advised for: what the limits of
// the safety chain do to the energy of the closed loop.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "haptic_server/safety/device_limits.hpp"
#include "tests/stability/held_loop.hpp"

namespace stillgrid::laboratory::limited_wall_test {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kWall_N_per_m = 1000.0;  // touch: 1020 advised

devices::PhantomSettings touch(double mass_kg) {
  devices::PhantomSettings settings;
  settings.device = *devices::phantom_profile("touch");
  settings.hand.mass_kg = mass_kg;
  settings.path.kind = devices::PathKind::kStill;
  settings.tick_s = kTick_s;
  return settings;
}

/// What the driver declares of it, but for the workspace: the wall is no matter of that.
safety::SafetyLimits declared(const devices::PhantomProfile& device) {
  stillgrid_device_descriptor descriptor{};
  descriptor.max_force_N = device.max_force_N;
  descriptor.continuous_force_N = device.continuous_force_N;
  descriptor.motor_time_constant_s = device.motor_time_constant_s;
  descriptor.nominal_stiffness_N_per_m = device.nominal_stiffness_N_per_m;
  descriptor.max_speed_m_s = device.max_speed_m_s;
  return safety::safety_limits({}, descriptor);
}

struct LimitedRun {
  double rebound_m_s = 0.0;  // fastest upwards
  double most_given_J = 0.0;
  std::uint32_t flags = 0;
};

LimitedRun run_on_wall(const devices::PhantomSettings& settings, const safety::SafetyLimits& limits,
                       double time_s) {
  devices::PhantomModel device = devices::make_phantom(settings);
  safety::SafetyChain chain(limits);
  LimitedRun run;
  safety::SafetyInput input{.snapshot = {true, 0.0, 0.033, true}};
  std::uint32_t ignored = 0;
  for (int tick = 0; tick < 101; ++tick) (void)chain.apply(input, ignored);

  const proto::SceneHeader scene = wall(kWall_N_per_m);
  Eigen::Vector3d before_m = devices::read_encoders(device);
  for (int tick = 0; tick < static_cast<int>(time_s / kTick_s); ++tick) {
    const Eigen::Vector3d now_m = devices::read_encoders(device);
    input.motion = {.moved_m = now_m - before_m};
    before_m = now_m;
    input.velocity_m_s = device.velocity_m_s;
    input.rendered.force_N = {0.0, 0.0, force_N(scene, now_m.z())};
    input.stiffness_N_per_m.setZero();
    if (now_m.z() < 0.0) input.stiffness_N_per_m(2, 2) = kWall_N_per_m;
    devices::command_force(device, chain.apply(input, run.flags).force_N);
    devices::advance_phantom(device, devices::kSubstepsPerTick);
    run.rebound_m_s = std::max(run.rebound_m_s, device.velocity_m_s.z());
  }
  run.most_given_J = chain.energy().most_given_J;
  return run;
}

TEST_CASE("A wall that a device is advised for does not throw back what taps it",
          "[limited_wall]") {
  const double speed_m_s = GENERATE(0.1, 0.3, 0.5, 0.8, 1.2);
  const double hand_kg = GENERATE(0.0, 0.1);
  devices::PhantomSettings settings = touch(hand_kg);
  settings.device.friction_N = 0.0;  // which would hide it
  settings.start_m = {0.0, 0.0, 1e-4};
  settings.start_velocity_m_s = {0.0, 0.0, -speed_m_s};
  const safety::SafetyLimits limits = declared(settings.device);
  safety::SafetyLimits unslewed = limits;
  unslewed.max_slew_N_per_ms = std::numeric_limits<double>::infinity();
  const LimitedRun with = run_on_wall(settings, limits, 0.2);
  const LimitedRun without = run_on_wall(settings, unslewed, 0.2);
  INFO(speed_m_s << " m/s, with a hand of " << hand_kg << " kg");
  CHECK(with.rebound_m_s <= 1.01 * without.rebound_m_s);
  CHECK(with.rebound_m_s <= 1.15 * speed_m_s);  // a held force leaks
  CHECK(with.rebound_m_s > 0.1 * speed_m_s);    // it is a wall
  if (speed_m_s >= 0.5) CHECK((with.flags & safety::kFlagSlewed) != 0);
}

TEST_CASE("A device pushed onto a wall is given no more energy than without a slew limit",
          "[limited_wall]") {
  devices::PhantomSettings settings = touch(0.0);
  settings.push_N = {0.0, 0.0, -1.0};
  settings.start_m = {0.0, 0.0, 0.03};
  const safety::SafetyLimits limits = declared(settings.device);
  safety::SafetyLimits unslewed = limits;
  unslewed.max_slew_N_per_ms = std::numeric_limits<double>::infinity();
  const LimitedRun with = run_on_wall(settings, limits, 6.0);
  const LimitedRun without = run_on_wall(settings, unslewed, 6.0);
  CHECK(with.most_given_J <= without.most_given_J);
  CHECK((with.flags & safety::kFlagSlewed) != 0);
}

}  // namespace
}  // namespace stillgrid::laboratory::limited_wall_test
