// The loop that the plugin haply runs in its own thread: as often as it may, against whatever
// service answers. tests/performance/haply_figures.py runs it beside a fake service.
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "proto/device_plugin.h"

namespace {

constexpr double kWall_N_per_m = 200.0;

struct Loop {
  const stillgrid_device_api& api;
  stillgrid_device* device;
  std::int32_t code = STILLGRID_DEVICE_OK;
  std::atomic<bool> has_ended = false;
  std::vector<double> ticks_us{};
  std::vector<double> ages_us{};
  double greatest_N = 0.0;
};

std::uint64_t now_ns() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::nanoseconds(now).count());
}

std::int32_t tick(void* context) {
  Loop& loop = *static_cast<Loop*>(context);
  const std::uint64_t time_ns = now_ns();
  stillgrid_device_state state{};
  state.struct_size = sizeof state;
  loop.code = loop.api.read(loop.device, time_ns, &state);
  if (loop.ticks_us.size() < loop.ticks_us.capacity()) {
    loop.ticks_us.push_back(1e-3 * static_cast<double>(time_ns));
    loop.ages_us.push_back(1e-3 * static_cast<double>(time_ns - state.time_ns));
  }
  const std::array<double, 3> force_N = {0.0, 0.0,
                                         std::max(0.0, -kWall_N_per_m * state.position_m[2])};
  loop.greatest_N = std::max(loop.greatest_N, force_N[2]);
  if (loop.code == STILLGRID_DEVICE_OK)
    loop.code = loop.api.write(loop.device, time_ns, force_N.data(), nullptr);
  if (loop.code == STILLGRID_DEVICE_OK) return 0;
  loop.has_ended = true;
  return 1;
}

double share_of(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  const auto place = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(place),
                   values.end());
  return values[place];
}

void print(Loop& loop) {
  std::vector<double> steps_us;
  for (std::size_t n = 1; n < loop.ticks_us.size(); ++n)
    steps_us.push_back(loop.ticks_us[n] - loop.ticks_us[n - 1]);
  const double span_us = loop.ticks_us.empty() ? 0.0 : loop.ticks_us.back() - loop.ticks_us[0];
  std::printf("{\"ticks\": %zu, \"span_s\": %.3f, \"greatest_N\": %.3f", loop.ticks_us.size(),
              1e-6 * span_us, loop.greatest_N);
  std::printf(", \"step_p50_us\": %.1f, \"step_p99_us\": %.1f", share_of(steps_us, 0.5),
              share_of(steps_us, 0.99));
  std::printf(", \"age_p50_us\": %.1f, \"age_p99_us\": %.1f, \"code\": %d, \"line\": \"%s\"}\n",
              share_of(loop.ages_us, 0.5), share_of(loop.ages_us, 0.99), loop.code,
              loop.code == 0 ? "" : loop.api.strerror(loop.device, loop.code));
}

}  // namespace

/// haply_pace PLUGIN PORT SECONDS PERIOD_NS: prints one line of JSON. Status 1 where it cannot
/// begin.
int main(int count, char** words) {
  if (count != 5) return 1;
  void* const library = dlopen(words[1], RTLD_NOW);
  if (library == nullptr) return 1;
  const auto negotiate =
      reinterpret_cast<stillgrid_device_negotiate_fn>(dlsym(library, "stillgrid_device_negotiate"));
  const stillgrid_host_info host{sizeof host,
                                 STILLGRID_DEVICE_ABI,
                                 STILLGRID_CLOCK_MONOTONIC,
                                 0,
                                 std::strtoull(words[4], nullptr, 10),
                                 nullptr};
  stillgrid_device_api api{};
  api.struct_size = sizeof api;
  stillgrid_device* device = nullptr;
  if (negotiate == nullptr || negotiate(&host, &api) != 0 || api.set_tick == nullptr ||
      api.open(0, &device) != 0 || api.configure(device, "port", words[2]) != 0)
    return 1;
  Loop loop{api, device};
  loop.ticks_us.reserve(1'000'000);
  loop.ages_us.reserve(1'000'000);
  api.set_tick(device, tick, &loop);
  if (const std::int32_t code = api.activate(device); code != 0) {
    std::printf("%s\n", api.strerror(device, code));
    return 1;
  }
  const auto end = std::chrono::steady_clock::now() +
                   std::chrono::duration<double>(std::strtod(words[3], nullptr));
  while (std::chrono::steady_clock::now() < end && !loop.has_ended)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const std::int32_t code = api.deactivate(device);
  if (loop.code == 0) loop.code = code;
  print(loop);
  api.close(device);
  return 0;
}
