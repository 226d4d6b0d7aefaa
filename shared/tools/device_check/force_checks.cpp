#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stop_token>
#include <string>
#include <thread>

#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"

namespace stillgrid::device_check {
namespace {

using Limits = std::numeric_limits<double>;

constexpr std::array kExtremes_N = {1e3,
                                    -1e3,
                                    1e300,
                                    Limits::max(),
                                    Limits::lowest(),
                                    Limits::denorm_min(),
                                    Limits::infinity(),
                                    -Limits::infinity(),
                                    Limits::quiet_NaN()};

/// Writes the force, and none at once after it. Refusing an extreme is as good as taking it.
void write_for_a_moment(CheckedDevice& device, std::uint64_t now_ns,
                        const std::array<double, 3>& force_N) {
  const std::int32_t code = device.write(now_ns, force_N);
  if (code != STILLGRID_DEVICE_E_ARGUMENT) device.require(code, "write() of an extreme force");
  device.require(device.write(now_ns, {}), "write() of no force after an extreme one");
}

Outcome check_extremes(const Subject& subject) {
  if (!subject.any_force)
    end_check(Verdict::kSkip,
              "hands off the device, then --any-force: it writes forces of any "
              "size, each for less than a millisecond");
  CheckedDevice device(subject);
  device.activate();
  std::size_t tick = 0;
  run_ticks(3 * kExtremes_N.size(), [&](std::uint64_t now_ns) {
    std::array<double, 3> force_N{};
    force_N.at(tick % 3) = kExtremes_N.at(tick / 3);
    ++tick;
    write_for_a_moment(device, now_ns, force_N);
    stillgrid_device_state state{};
    const std::int32_t code = device.read(now_ns, state);
    device.require(code, "read() after an extreme force");
    for (const double at_m : state.position_m)
      if (!std::isfinite(at_m))
        broken("the position is " + number_text(at_m) + " after a force of " +
               number_text(kExtremes_N.at((tick - 1) / 3)) + " N");
    return code != STILLGRID_DEVICE_END;
  });
  device.deactivate();
  return {};
}

/// Stops the device from this thread while the real-time thread is at work.
void stop_at_work(CheckedDevice& device) {
  std::atomic<bool> has_thrown = false;
  {
    const std::jthread stopper([&](const std::stop_token& is_over) {
      while (!is_over.stop_requested()) {
        try {
          device.api().emergency_stop(device.handle());
        } catch (...) {
          has_thrown = true;
        }
        std::this_thread::sleep_for(std::chrono::microseconds(300));
      }
    });
    run_ticks(100, [&](std::uint64_t now_ns) {
      stillgrid_device_state state{};
      // Any code will do: the device may have gone with its motors.
      (void)device.read(now_ns, state);
      (void)device.write(now_ns, {});
      return true;
    });
  }
  if (has_thrown) broken("an exception leaves emergency_stop()");
}

Outcome check_stop(const Subject& subject) {
  CheckedDevice device(subject);
  const auto stop = [&] {
    call_driver("emergency_stop()", [&] { device.api().emergency_stop(device.handle()); });
  };
  stop();
  device.activate();
  stop_at_work(device);
  device.deactivate();
  stop();
  stop();
  device.activate();
  read_ticks(device, 5);
  device.deactivate();
  return {};
}

constexpr std::array kChecks = {
    Check{"write.extremes", "survives forces that are huge or no numbers", "read.fields",
          check_extremes},
    Check{"stop.any_thread", "takes emergency_stop from any thread at any time; activate ends it",
          "life.again", check_stop},
};

}  // namespace

std::span<const Check> force_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
