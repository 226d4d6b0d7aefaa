#include "shared/tools/scene_relay/tool_messages.hpp"

#include <algorithm>

#include "shared/tools/scene_relay/arrays.hpp"
#include "shared/tools/scene_relay/sequence.hpp"

namespace stillgrid::scene_relay {
namespace {

/// Of a message, beside its path.
constexpr std::size_t kState_bytes = 228;

}  // namespace

static_assert(kState_bytes + ToolMessages::kRepeated_ticks * sizeof(PathSample) <=
              ToolMessages::kPacket_bytes);

std::size_t message_bytes(const ToolMessage& message) noexcept {
  return kState_bytes + message.path._length * sizeof(PathSample);
}

const ToolMessage& ToolMessages::encode(const publication::ToolView& tool,
                                        const proto::ToolState& state, bool has_path) {
  message_ = {};
  message_.relay_id = relay_id_;
  message_.number = ++number_;
  message_.segment_epoch = tool.header().epoch;
  message_.period_ns = tool.header().period_ns;
  message_.time_ns = state.time_ns;
  message_.tick = state.tick;
  message_.path_number = state.path_number;
  copy(state.position_m, message_.position_m);
  copy(state.orientation_xyzw, message_.orientation_xyzw);
  copy(state.velocity_m_s, message_.velocity_m_s);
  copy(state.force_N, message_.force_N);
  message_.buttons = state.buttons;
  if (publication::has_sound_figures(state)) {
    copy(state.before.torque_N_m, message_.torque_N_m);
    message_.contacts = state.before.contacts;
    message_.flags = state.before.flags;
  }
  path_.clear();
  if (has_path) add_path(tool.path(), state.path_number);
  point_to(message_.path, path_);
  return message_;
}

void ToolMessages::add_path(const publication::PathView& path, std::uint64_t newest) {
  const auto back = [newest](std::uint64_t ticks) { return newest - std::min(newest, ticks - 1); };
  std::uint64_t first = back(kRepeated_ticks);
  if (newest_ < newest) first = std::clamp(newest_ + 1, back(kMaxTicks), first);
  for (std::uint64_t n = first; n <= newest; ++n) {
    const auto sample = path.sample(n);
    if (!sample) continue;
    PathSample& of_tick = path_.emplace_back();
    of_tick.number = n;
    copy(sample->position_m, of_tick.position_m);
    copy(sample->orientation_xyzw, of_tick.orientation_xyzw);
    copy(sample->velocity_m_s, of_tick.velocity_m_s);
  }
  newest_ = newest;
}

}  // namespace stillgrid::scene_relay
