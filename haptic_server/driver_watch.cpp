#include "haptic_server/driver_watch.hpp"

#include <spdlog/spdlog.h>

#include <cfenv>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string_view>
#include <utility>

#include "haptic_server/safety/safety_flag.hpp"

namespace stillgrid::haptic_server {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(50);
constexpr int kPollsALook = 20;

/// What a reason means to a user, in the order of its flags.
constexpr std::array<std::string_view, 9> kReasonLines = {
    "no position is marked valid",
    "a position is no number",
    "a position is farther than 10 m from its origin",
    "a position is far outside the workspace that it declares",
    "an orientation is no number, or no unit quaternion",
    "a time stamp goes back",
    "a time stamp is more than 100 ms from now",
    "its sequence stands still under fresh time stamps",
    "a position leaps, faster than the device declares or any hand moves"};
constexpr std::size_t kFirstReason = 16;
static_assert(safety::kFlagNoPosition == 1U << kFirstReason);

/// What a device tells of itself, likewise.
constexpr std::array<std::string_view, 5> kStatusLines = {
    "its motors are off", "its enabling switch is open", "it is not calibrated",
    "its motors are too hot", "it has found a fault of its own"};
constexpr std::size_t kFirstStatus = kFirstReason + kReasonLines.size();
static_assert(safety::kFlagMotorsOff == 1U << kFirstStatus &&
              safety::kFlagCrushed == 1U << (kFirstStatus + kStatusLines.size()));

std::string_view name_of_change(std::size_t i) {
  return i < realtime::kProcessParts.size() ? realtime::kProcessParts[i] : "the rounding mode";
}

void add(std::atomic<std::uint64_t>& count) {  // one writer
  count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace

DriverWatch::DriverWatch(std::string device)
    : device_(std::move(device)),
      before_(realtime::process_state()),
      thread_([this](const std::stop_token& end) { keep_watch(end); }) {}

DriverWatch::~DriverWatch() {
  thread_.request_stop();
  thread_.join();
  if (ticks_ > 0) look_at_process();
  say_new();
  std::string counts;
  const auto list = [&counts](std::string_view what, std::uint64_t count) {
    if (count > 0) counts.append(", ").append(what).append(" ").append(std::to_string(count));
  };
  for (std::size_t i = kFirstReason; i < kFirstStatus; ++i)
    list(safety::kSafetyFlagNames[i], bad_ticks_[i]);
  if (!counts.empty())
    spdlog::warn("device '{}': not believed in {} of {} ticks{}", device_, unbelieved_.load(),
                 ticks_.load(), counts);
  counts.clear();
  for (std::size_t i = kFirstStatus; i < safety::kSafetyFlagNames.size(); ++i)
    list(safety::kSafetyFlagNames[i], bad_ticks_[i]);
  if (!counts.empty())
    spdlog::warn("device '{}': no force, of {} ticks{}", device_, ticks_.load(), counts);
  counts.clear();
  for (std::size_t i = 0; i < kChanges; ++i) list(name_of_change(i), changes_[i]);
  if (!counts.empty()) spdlog::warn("device '{}': seen changed{}", device_, counts);
}

void DriverWatch::note(std::uint32_t flags) noexcept {
  add(ticks_);
  if ((flags & safety::kFlagBadDevice) != 0) add(unbelieved_);
  constexpr std::uint32_t kCounted = safety::kDeviceReasonMask | safety::kDeviceStatusMask;
  if (const std::uint32_t reasons = flags & kCounted; reasons != 0)
    for (std::size_t i = kFirstReason; i < safety::kSafetyFlagNames.size(); ++i)
      if ((reasons >> i & 1U) != 0) add(bad_ticks_[i]);
  if (std::fegetround() == FE_TONEAREST) return;
  std::fesetround(FE_TONEAREST);
  add(changes_[kRoundingMode]);
}

void DriverWatch::keep_watch(const std::stop_token& end) {
  std::mutex mutex;
  std::condition_variable_any changed;
  std::unique_lock lock(mutex);
  for (int poll = 1; !end.stop_requested(); ++poll) {
    changed.wait_for(lock, end, kPoll, [] { return false; });
    if (poll % kPollsALook == 0 && ticks_ > 0) look_at_process();
    say_new();
  }
}

void DriverWatch::look_at_process() {
  const realtime::ProcessState now = realtime::process_state(before_.thread);
  constexpr auto kSchedule = static_cast<std::size_t>(realtime::ProcessPart::kSchedule);
  if (!std::exchange(has_schedule_, true)) before_.parts[kSchedule] = now.parts[kSchedule];
  for (std::size_t i = 0; i < realtime::kProcessParts.size(); ++i)
    if (now.parts[i] != before_.parts[i]) add(changes_[i]);
}

void DriverWatch::say_new() {
  const auto is_new = [this](std::size_t bit, std::uint64_t count) {
    if (count == 0 || (said_ >> bit & 1U) != 0) return false;
    said_ |= std::uint64_t{1} << bit;
    return true;
  };
  for (std::size_t i = 0; i < kReasonLines.size(); ++i)
    if (is_new(i, bad_ticks_[kFirstReason + i]))
      spdlog::warn("device '{}': not believed: {}; the force fades", device_, kReasonLines[i]);
  for (std::size_t i = 0; i < kStatusLines.size(); ++i)
    if (is_new(kFirstStatus + i, bad_ticks_[kFirstStatus + i]))
      spdlog::warn("device '{}': {}; no force until that has passed", device_, kStatusLines[i]);
  for (std::size_t i = 0; i < kChanges; ++i)
    if (is_new(32 + i, changes_[i]))
      spdlog::warn("device '{}': {} of the process has changed since the device was opened{}",
                   device_, name_of_change(i), i == kRoundingMode ? ", and is set back" : "");
}

}  // namespace stillgrid::haptic_server
