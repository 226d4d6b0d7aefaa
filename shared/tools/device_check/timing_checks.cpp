#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "shared/realtime/histogram.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/rights/realtime_rights.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"

namespace stillgrid::device_check {
namespace {

/// How long the calls of one function took.
struct Durations {
  realtime::Histogram ns;
  std::uint64_t late = 0;                  // above max_read_ns
  std::array<std::uint64_t, 6> decades{};  // below 1, 10, 100 us, 1, 10 ms; the rest
};

void record(Durations& durations, std::uint64_t duration_ns, std::uint64_t max_ns) {
  durations.ns.record(duration_ns);
  durations.late += duration_ns > max_ns ? 1 : 0;
  std::size_t decade = 0;
  for (std::uint64_t limit_ns = 1000; decade < 5 && duration_ns >= limit_ns; limit_ns *= 10)
    ++decade;
  ++durations.decades.at(decade);
}

struct Timing {
  Durations read, write;
  std::string missing;  // what the real-time thread could not have
};

/// Reads and writes at 1 kHz for that time. A recording that ends begins again.
Timing time_calls(CheckedDevice& device, double seconds, std::uint64_t max_ns) {
  Timing timing;
  auto left = static_cast<std::size_t>(std::ceil(seconds * 1000.0));
  while (left > 0) {
    const std::size_t before = left;
    device.activate();
    bool is_ready = false;
    run_ticks(left, [&](std::uint64_t now_ns) {
      if (!is_ready) timing.missing = realtime::missing_line(realtime::take_rights({}));
      is_ready = true;
      stillgrid_device_state state{};
      const std::uint64_t start_ns = realtime::monotonic_ns();
      const std::int32_t code = device.read(now_ns, state);
      const std::uint64_t middle_ns = realtime::monotonic_ns();
      device.require(code, "read()");
      if (code == STILLGRID_DEVICE_END) return false;
      const std::uint64_t write_ns = realtime::monotonic_ns();
      device.require(device.write(now_ns, {}), "write()");
      record(timing.write, realtime::monotonic_ns() - write_ns, max_ns);
      record(timing.read, middle_ns - start_ns, max_ns);
      --left;
      return true;
    });
    device.deactivate();
    if (left == before) broken("read() answers END from the first tick on");
  }
  return timing;
}

std::string row(const char* function, const Durations& durations) {
  const auto us = [&](double share) {
    return static_cast<double>(durations.ns.percentile(share)) * 1e-3;
  };
  const double late_percent =
      100.0 * static_cast<double>(durations.late) / static_cast<double>(durations.ns.count());
  std::array<char, 512> text{};
  const auto& n = durations.decades;
  std::snprintf(text.data(), text.size(),
                "%-6s p50 %.1f, p99 %.1f, p99.9 %.1f, max %.1f us; %.2f %% over max_read_ns\n"
                "       <1 us %lu, <10 us %lu, <100 us %lu, <1 ms %lu, <10 ms %lu, more %lu\n",
                function, us(0.5), us(0.99), us(0.999),
                static_cast<double>(durations.ns.max()) * 1e-3, late_percent, n[0], n[1], n[2],
                n[3], n[4], n[5]);
  return text.data();
}

Outcome check_timing(const Subject& subject) {
  CheckedDevice device(subject);
  const std::uint64_t max_ns = device.describe().max_read_ns;
  const Timing timing = time_calls(device, subject.seconds, max_ns);
  Outcome outcome;
  outcome.details = row("read", timing.read) + row("write", timing.write);
  if (!timing.missing.empty()) outcome.details += "measured without " + timing.missing + "\n";
  const std::string declared = " took longer than the declared " + std::to_string(max_ns) + " ns";
  // A share, not the longest: a machine that stalls is none of the driver's.
  const auto worst = [&](double share) {
    return std::max(timing.read.ns.percentile(share), timing.write.ns.percentile(share));
  };
  if (worst(0.99) > max_ns) {
    outcome.verdict = Verdict::kFail;
    outcome.line = "one call of a hundred" + declared;
  } else if (worst(0.999) > max_ns) {
    outcome.verdict = Verdict::kWarn;
    outcome.line = "one call of a thousand" + declared;
  }
  return outcome;
}

constexpr std::array kChecks = {
    Check{"timing.calls", "returns from read and write within max_read_ns, at 1 kHz",
          "descriptor.max_read", check_timing},
};

}  // namespace

std::span<const Check> timing_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
