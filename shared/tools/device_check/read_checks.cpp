#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "haptic_server/safety/device_reading.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"

namespace stillgrid::device_check {
namespace {

struct Sample {
  stillgrid_device_state state;
  std::uint64_t tick_ns;
  std::uint64_t after_ns;  // when read() had returned
};

/// What read() gives in 100 ticks, or to the end of a recording.
std::vector<Sample> samples_of(CheckedDevice& device) {
  constexpr std::size_t kTicks = 100;
  std::vector<Sample> samples;
  samples.reserve(kTicks);
  device.activate();
  run_ticks(kTicks, [&](std::uint64_t now_ns) {
    Sample sample{};
    sample.tick_ns = now_ns;
    const std::int32_t code = device.read(now_ns, sample.state);
    sample.after_ns = realtime::monotonic_ns();
    device.require(code, "read()");
    if (code == STILLGRID_DEVICE_END) return false;
    samples.push_back(sample);
    device.require(device.write(now_ns, {}), "write()");
    return true;
  });
  device.deactivate();
  return samples;
}

std::vector<Sample> samples_of(const Subject& subject) {
  CheckedDevice device(subject);
  return samples_of(device);
}

[[noreturn]] void broken_at(std::size_t read, const std::string& what) {
  broken("read " + std::to_string(read + 1) + ": " + what);
}

void require_finite(std::size_t read, const char* what, std::span<const double> values) {
  for (const double value : values)
    if (!std::isfinite(value))
      broken_at(read, std::string(what) + " is marked valid and holds " + number_text(value));
}

Outcome check_fields(const Subject& subject) {
  const std::vector<Sample> samples = samples_of(subject);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const stillgrid_device_state& state = samples[n].state;
    if ((state.valid & STILLGRID_STATE_POSITION) == 0) broken_at(n, "no position is marked valid");
    require_finite(n, "the position", state.position_m);
    if ((state.valid & STILLGRID_STATE_VELOCITY) != 0)
      require_finite(n, "the velocity", state.velocity_m_s);
    if ((state.valid & STILLGRID_STATE_TEMPERATURE) != 0)
      require_finite(n, "the temperature", {&state.temperature_C, 1});
    if ((state.valid & STILLGRID_STATE_GRIPPER) != 0)
      require_finite(n, "the gripper's opening", {&state.gripper_m, 1});
    if ((state.valid & STILLGRID_STATE_AXES) != 0)
      for (const double axis : state.axes)
        if (!(std::abs(axis) <= 1.0))
          broken_at(n, "an axis is " + number_text(axis) + ", expected from -1 to 1");
    if ((state.valid & STILLGRID_STATE_ORIENTATION) == 0) continue;
    require_finite(n, "the orientation", state.orientation_xyzw);
    double norm2 = 0.0;
    for (const double part : state.orientation_xyzw) norm2 += part * part;
    constexpr double kFloatUnit = 1e-4;  // of drivers that compute in float
    if (std::abs(std::sqrt(norm2) - 1.0) > kFloatUnit)
      broken_at(n, "the orientation's norm is " + number_text(std::sqrt(norm2)));
  }
  return {};
}

Outcome check_time(const Subject& subject) {
  const std::vector<Sample> samples = samples_of(subject);
  std::vector<std::uint64_t> ages_ns;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const std::uint64_t time_ns = samples[n].state.time_ns;
    const std::uint64_t previous_ns = n == 0 ? 0 : samples[n - 1].state.time_ns;
    if (time_ns < previous_ns)
      broken_at(n, "time_ns goes back by " + std::to_string(previous_ns - time_ns) + " ns");
    constexpr std::uint64_t kSlack_ns = 1'000'000;  // of a device's own clock
    if (time_ns > samples[n].after_ns + kSlack_ns)
      broken_at(n, "time_ns lies " + std::to_string(time_ns - samples[n].after_ns) +
                       " ns in the future of CLOCK_MONOTONIC");
    ages_ns.push_back(samples[n].after_ns - std::min(time_ns, samples[n].after_ns));
  }
  if (ages_ns.empty()) return {};
  const auto median = ages_ns.begin() + std::ssize(ages_ns) / 2;  // the machine may stall
  std::nth_element(ages_ns.begin(), median, ages_ns.end());
  constexpr std::uint64_t kOld_ns = 100'000'000;
  if (*median > kOld_ns)
    broken("half of the states are more than " + std::to_string(*median / 1'000'000) +
           " ms old by their time_ns");
  return {};
}

Outcome check_sequence(const Subject& subject) {
  const std::vector<Sample> samples = samples_of(subject);
  for (std::size_t n = 1; n < samples.size(); ++n) {
    const stillgrid_device_state& before = samples[n - 1].state;
    const stillgrid_device_state& now = samples[n].state;
    if (now.sequence < before.sequence)
      broken_at(n, "sequence goes back from " + std::to_string(before.sequence) + " to " +
                       std::to_string(now.sequence));
    const bool is_same = std::equal(std::begin(now.position_m), std::end(now.position_m),
                                    std::begin(before.position_m));
    if (now.sequence == before.sequence && !is_same)
      broken_at(n, "another position with the same sequence, " + std::to_string(now.sequence));
  }
  if (samples.size() > 50 && samples.back().state.sequence == samples.front().state.sequence)
    broken("sequence stays " + std::to_string(samples.back().state.sequence) + " for " +
           std::to_string(samples.size()) + " reads");
  return {};
}

Outcome check_believed(const Subject& subject) {
  CheckedDevice device(subject);
  safety::DeviceReadingCheck reading(safety::reading_bounds(device.describe()));
  const std::vector<Sample> samples = samples_of(device);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const stillgrid_device_state& state = samples[n].state;
    if (reading.check(state, samples[n].tick_ns)) continue;
    const int flag = std::countr_zero(reading.reason());
    const auto& at_m = state.position_m;
    broken_at(n, "haptic_server would not believe it: " +
                     std::string(safety::kSafetyFlagNames.at(static_cast<std::size_t>(flag))) +
                     ", at " + number_text(at_m[0]) + " " + number_text(at_m[1]) + " " +
                     number_text(at_m[2]) + " m; are these metres?");
  }
  return {};
}

Outcome check_workspace(const Subject& subject) {
  CheckedDevice device(subject);
  const stillgrid_device_descriptor declared = device.describe();
  const std::vector<Sample> samples = samples_of(device);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double min_m = declared.workspace_min_m[axis];
    const double max_m = declared.workspace_max_m[axis];
    if (min_m == max_m) continue;  // no edge along this axis
    for (const Sample& sample : samples) {
      const double at_m = sample.state.position_m[axis];
      if (at_m < min_m || at_m > max_m)
        return {Verdict::kWarn,
                "position " + number_text(at_m) + " m along axis " + std::to_string(axis) +
                    ", workspace from " + number_text(min_m) + " to " + number_text(max_m) +
                    " m: there is no force there",
                {}};
    }
  }
  return {};
}

constexpr std::array kChecks = {
    Check{"read.fields",
          "gives a position, and what is marked valid is finite and a unit "
          "quaternion",
          "life.order", check_fields},
    Check{"read.time", "stamps states with CLOCK_MONOTONIC, never back in time", "life.order",
          check_time},
    Check{"read.sequence", "counts fresh states, never back", "life.order", check_sequence},
    Check{"read.believed", "gives what haptic_server believes: metres, in reach, without leaps",
          "read.fields read.time read.sequence descriptor.figures", check_believed},
    Check{"read.workspace", "stays in the workspace that it declares", "read.believed",
          check_workspace},
};

}  // namespace

std::span<const Check> read_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
