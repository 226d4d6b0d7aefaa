#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"

namespace stillgrid::device_check {
namespace {

/// The host's side of a device that sets the pace.
struct Ticks {
  CheckedDevice& device;
  std::uint64_t end_at = 0;  // the tick that says that they are over; 0: none does
  std::atomic<std::uint64_t> count = 0, at_once = 0, in_other_threads = 0, after_end = 0;
  std::atomic<std::int32_t> first_fault = STILLGRID_DEVICE_OK;
  std::atomic<bool> is_under_way = false, is_over = false;
  std::atomic<std::thread::id> thread = std::thread::id();

  static std::int32_t tick(void* context) noexcept {
    auto& self = *static_cast<Ticks*>(context);
    if (self.is_over) ++self.after_end;
    if (self.is_under_way.exchange(true)) ++self.at_once;
    std::thread::id nobody;
    const auto own = std::this_thread::get_id();
    if (!self.thread.compare_exchange_strong(nobody, own) && self.thread != own)
      ++self.in_other_threads;
    const std::uint64_t now_ns = realtime::monotonic_ns();
    stillgrid_device_state state{};
    std::int32_t code = self.device.read(now_ns, state);
    if (code == STILLGRID_DEVICE_OK) code = self.device.write(now_ns, {});
    if (code != STILLGRID_DEVICE_OK && code != STILLGRID_DEVICE_END) self.first_fault = code;
    const std::uint64_t count = ++self.count;
    self.is_over = self.is_over || count == self.end_at;
    self.is_under_way = false;
    return self.is_over ? 1 : 0;
  }
};

bool sets_pace(CheckedDevice& device) {
  return (device.describe().flags & STILLGRID_DEVICE_SETS_PACE) != 0;
}

void require_pace(CheckedDevice& device) {
  if (!sets_pace(device)) end_check(Verdict::kPass, "the device does not set the pace");
  if (device.api().set_tick == nullptr)
    broken("it declares STILLGRID_DEVICE_SETS_PACE, and set_tick is null");
}

void set_tick(CheckedDevice& device, stillgrid_device_tick_fn tick, void* context) {
  device.require(call_driver("set_tick()",
                             [&] { return device.api().set_tick(device.handle(), tick, context); }),
                 "set_tick()");
}

void require_sound(const Ticks& ticks) {
  if (ticks.in_other_threads > 0) broken("ticks come from more than one thread in one life");
  if (ticks.at_once > 0) broken("a tick is called while another is under way");
  if (ticks.after_end > 0)
    broken(std::to_string(ticks.after_end.load()) + " ticks come after one that was the last");
  if (ticks.first_fault != STILLGRID_DEVICE_OK)
    broken("read() or write() in a tick answers " + code_name(ticks.first_fault));
}

Outcome check_ticks(const Subject& subject) {
  CheckedDevice device(subject);
  require_pace(device);
  const double rate_hz = device.describe().rate_hz;
  constexpr auto kTime = std::chrono::milliseconds(500);
  Ticks ticks{.device = device};
  set_tick(device, Ticks::tick, &ticks);
  device.activate();
  std::this_thread::sleep_for(kTime);
  device.deactivate();
  const std::uint64_t count = ticks.count;
  ticks.is_over = true;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  require_sound(ticks);
  const double due = rate_hz * 0.5;
  const std::string told = std::to_string(count) + " ticks in 0.5 s, " + number_text(due) + " due";
  if (count == 0) broken(told);
  const bool is_at_rate = rate_hz == 0.0 || std::abs(static_cast<double>(count) - due) <= 0.2 * due;
  return {is_at_rate ? Verdict::kPass : Verdict::kWarn, told, {}};
}

Outcome check_end(const Subject& subject) {
  CheckedDevice device(subject);
  require_pace(device);
  Ticks ticks{.device = device, .end_at = 5};
  set_tick(device, Ticks::tick, &ticks);
  for (int life = 0; life < 2; ++life) {  // the end holds until the next activate()
    ticks.count = 0;
    ticks.is_over = false;
    ticks.thread = std::thread::id();
    device.activate();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    device.deactivate();
    require_sound(ticks);
    if (ticks.count != 5) broken(std::to_string(ticks.count.load()) + " of 5 ticks come");
  }
  return {};
}

Outcome check_given(const Subject& subject) {
  CheckedDevice device(subject);
  if (device.api().set_tick == nullptr)
    end_check(Verdict::kPass, "the device does not set the pace");
  Ticks ticks{.device = device};
  device.activate();
  const std::int32_t late = call_driver("set_tick() while active", [&] {
    return device.api().set_tick(device.handle(), Ticks::tick, &ticks);
  });
  if (late >= 0) broken("set_tick() while active answers " + code_name(late));
  read_ticks(device, 5);
  device.deactivate();
  set_tick(device, Ticks::tick, &ticks);
  set_tick(device, nullptr, nullptr);
  device.activate();
  read_ticks(device, 5);
  device.deactivate();
  if (ticks.count > 0) broken("a tick comes that was refused or taken back");
  if (call_driver("set_tick() of no device",
                  [&] { return device.api().set_tick(nullptr, Ticks::tick, &ticks); }) >= 0)
    broken("set_tick() of no device is not refused");
  return {};
}

constexpr std::array kChecks = {
    Check{"pace.ticks", "calls the tick once a period, one at a time, none after deactivate",
          "life.again", check_ticks},
    Check{"pace.end", "ends its ticks when told, until the next activate", "pace.ticks", check_end},
    Check{"pace.given", "takes a tick before activate alone, and is called by the host without one",
          "life.again arguments.no_device", check_given},
};

}  // namespace

std::span<const Check> pace_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
