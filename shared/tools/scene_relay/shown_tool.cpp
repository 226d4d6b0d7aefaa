#include "shared/tools/scene_relay/shown_tool.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "shared/tools/scene_relay/deadband.hpp"
#include "shared/tools/scene_relay/sequence.hpp"

namespace stillgrid::scene_relay {
namespace {

/// As often as samples are led on.
constexpr std::uint64_t kTick_ns = 1'000'000;
/// Between two attempts to take a lock that another holds.
constexpr std::uint64_t kTry_ns = 100'000'000;

constexpr std::uint64_t kPathTick_ns = proto::kPathTick_ns;

/// By how many ticks the path here is to be ahead of the hand's: a tick that took half the shortest
/// round trip has the present one's number then.
std::int64_t shift_of(const ClockOffset& clock) {
  const std::int64_t ahead_ns =
      static_cast<std::int64_t>(clock.round_trip_ns() / 2) - clock.offset_ns();
  constexpr auto kTick = static_cast<std::int64_t>(kPathTick_ns);
  return ahead_ns / kTick - (ahead_ns % kTick < 0 ? 1 : 0);
}

proto::PathSample sample_of(const PathSample& told) {
  return {told.number, std::to_array(told.position_m), std::to_array(told.orientation_xyzw),
          std::to_array(told.velocity_m_s)};
}

/// Whether the path's numbers ascend up to that of the state, which is about its time, and its
/// poses are sound.
bool is_sound_path(const ToolMessage& message) {
  const std::uint64_t newest = message.path_number, now = message.time_ns / kPathTick_ns;
  if (newest > now + 1 || newest + proto::kPathLength < now) return false;
  const auto path = elements(message.path);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool ascends = i == 0 || path[i].number > path[i - 1].number;
    if (!ascends || path[i].number > newest || path[i].number + proto::kPathLength < newest ||
        !publication::is_sound(sample_of(path[i])))
      return false;
  }
  return true;
}

/// The tool's state as its message tells it, but for its time and number.
proto::ToolState state_of(const ToolMessage& message) {
  proto::ToolState state{};
  state.tick = message.tick;
  state.position_m = std::to_array(message.position_m);
  state.orientation_xyzw = std::to_array(message.orientation_xyzw);
  state.velocity_m_s = std::to_array(message.velocity_m_s);
  state.force_N = std::to_array(message.force_N);
  state.buttons = message.buttons;
  state.before.torque_N_m = std::to_array(message.torque_N_m);
  state.before.contacts = message.contacts;
  state.before.flags = message.flags;
  return state;
}

}  // namespace

ShownTool::ShownTool(std::string session, std::optional<gid_t> readers)
    : session_(std::move(session)), readers_(readers) {}

ShownTool::Shown ShownTool::show(const ToolMessage& message, const ClockOffset& clock,
                                 std::uint64_t now_ns) {
  proto::ToolState state = state_of(message);
  if (!publication::is_sound(state) || !publication::has_sound_figures(state) ||
      !is_sound_path(message) || message.period_ns < 10'000 || message.period_ns > 1'000'000'000)
    return Shown::kRefused;
  if (const Shown opened = open(message, clock, now_ns); opened != Shown::kShown) return opened;
  state.time_ns = std::max(clock.to_ours(message.time_ns), time_ns_ + 1);
  state.path_number = number_here(message.path_number);
  stamps_[next_stamp_] = {state.time_ns, message.time_ns};
  next_stamp_ = (next_stamp_ + 1) % stamps_.size();
  time_ns_ = state.time_ns;
  newest_ns_ = message.time_ns;
  heard_ns_ = now_ns;
  add_to_path(message);
  writer_->publish(state);
  sample_ = message.is_led_on ? std::optional(state) : std::nullopt;
  return Shown::kShown;
}

/// A haptic_server that was started anew is another writer: the second sample says that it was no
/// flipped bit.
ShownTool::Shown ShownTool::open(const ToolMessage& message, const ClockOffset& clock,
                                 std::uint64_t now_ns) {
  const std::int64_t shift = shift_of(clock);
  const bool is_known = writer_ && epoch_ == message.segment_epoch;
  if (is_known && std::abs(shift - shift_) <= kLongestDrift) return Shown::kShown;
  if (writer_ && !is_known && next_epoch_ != message.segment_epoch) {
    next_epoch_ = message.segment_epoch;
    return Shown::kWaits;
  }
  writer_.reset();
  if (now_ns < next_try_ns_) return Shown::kWaits;
  next_try_ns_ = now_ns + kTry_ns;
  auto lock = publication::SessionLock::try_take(session_, proto::SegmentKind::kTool);
  if (!lock) return Shown::kTaken;
  writer_.emplace(std::move(*lock), message.period_ns, proto::Clock::kMonotonic, now_ns, readers_);
  next_try_ns_ = 0;
  epoch_ = message.segment_epoch;
  shift_ = shift;
  ++segments_;
  return Shown::kShown;
}

std::uint64_t ShownTool::number_here(std::uint64_t hands) const noexcept {
  return hands + static_cast<std::uint64_t>(shift_);
}

std::optional<std::uint64_t> ShownTool::hands_number(std::uint64_t number) const noexcept {
  if (segments_ == 0) return std::nullopt;
  return number - static_cast<std::uint64_t>(shift_);
}

void ShownTool::add_to_path(const ToolMessage& message) noexcept {
  for (const PathSample& told : elements(message.path)) {
    proto::PathSample sample = sample_of(told);
    sample.number = number_here(told.number);
    writer_->add_to_path(sample);
  }
}

/// As the samples that were kept back would have said, about. No such state bears a stamp of the
/// hand's, so that the account of energy joins at none of them, and a number of the path that it
/// has already: the path holds what was heard alone.
void ShownTool::lead_on(std::uint64_t now_ns) {
  if (!writer_ || !sample_ || now_ns < led_ns_ + kTick_ns || now_ns < heard_ns_ + kTick_ns) return;
  led_ns_ = now_ns;
  const proto::ToolState state = led_on(*sample_, now_ns - heard_ns_);
  if (state.time_ns <= time_ns_) return;
  time_ns_ = state.time_ns;
  writer_->publish(state);
}

void ShownTool::look(std::uint64_t now_ns, std::uint64_t patience_ns) {
  lead_on(now_ns);
  if (now_ns >= heard_ns_ + patience_ns) withdraw();
}

std::uint64_t ShownTool::on_hands_clock(std::uint64_t here_ns) const noexcept {
  if (here_ns == 0) return 0;
  const auto* const found = std::find_if(
      stamps_.begin(), stamps_.end(), [&](const Stamp& stamp) { return stamp.here_ns == here_ns; });
  return found != stamps_.end() ? found->hands_ns : 0;
}

proto::SegmentHeader* ShownTool::header() noexcept {
  return writer_ ? &writer_->header() : nullptr;
}

}  // namespace stillgrid::scene_relay
