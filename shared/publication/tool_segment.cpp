#include "shared/publication/tool_segment.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

namespace stillgrid::publication {
namespace {

/// Written so that a NaN does not pass.
bool is_plausible(double x) {
  return std::abs(x) <= proto::kLargestNumber;
}
template <std::size_t N>
bool are_plausible(const std::array<double, N>& values) {
  return std::all_of(values.begin(), values.end(), is_plausible);
}

}  // namespace

bool is_sound(const proto::ToolState& state) noexcept {
  double norm_squared = 0.0;
  for (const double q : state.orientation_xyzw) norm_squared += q * q;
  return are_plausible(state.position_m) && are_plausible(state.velocity_m_s) &&
         are_plausible(state.force_N) && std::abs(norm_squared - 1.0) < 1e-3;
}

bool has_sound_figures(const proto::ToolState& state) noexcept {
  const proto::TickFigures& figures = state.before;
  const proto::DisplayedSnapshot& shown = figures.displayed;
  return are_plausible(figures.torque_N_m) && (figures.flags & ~proto::kSafetyFlagMask) == 0 &&
         are_plausible(shown.position) && are_plausible(shown.velocity_s) &&
         are_plausible(shown.modes) && is_plausible(shown.prediction_s) &&
         is_plausible(shown.compliance_lag_s) &&
         std::all_of(shown.shifts.begin(), shown.shifts.end(),
                     [](const proto::BodyShift& of) { return are_plausible(of.shift_m); }) &&
         are_plausible(state.device.axes) && is_plausible(state.device.gripper_m) &&
         is_plausible(state.device.gripper_force_N) && is_plausible(state.device.temperature_C) &&
         shown.alpha >= 0.0 && shown.alpha <= 1.0 && shown.age_s >= 0.0 &&
         is_plausible(shown.age_s);
}

ToolWriter::ToolWriter(SessionLock lock, std::uint64_t period_ns, proto::Clock clock,
                       std::uint64_t start_ns, std::optional<gid_t> readers)
    : segment_(std::move(lock), {.kind = proto::SegmentKind::kTool,
                                 .layout_hash = proto::kToolLayoutHash,
                                 .period_ns = period_ns,
                                 .clock = clock,
                                 .start_ns = start_ns,
                                 .fixed_bytes = sizeof(proto::SegmentHeader),
                                 .payload_bytes = sizeof(proto::ToolState),
                                 .readers = readers}) {
  segment_.announce();
}

void ToolWriter::publish(const proto::ToolState& state) noexcept {
  const auto words = std::bit_cast<std::array<std::uint64_t, sizeof(proto::ToolState) / 8>>(state);
  double_buffer::publish(segment_.buffer(), ++count_, {{0, words}});
  double_buffer::HardwareAtomics::store(segment_.header().heartbeat_ns, state.time_ns,
                                        std::memory_order_relaxed);
}

ToolView::ToolView(SegmentReader&& reader) : reader_(std::move(reader)) {
  if (reader_.header().payload_bytes < sizeof(proto::ToolState))
    throw SegmentError("the tool segment's slots are too small for a tool state");
}

std::optional<proto::ToolState> ToolView::read() const noexcept {
  proto::ToolState state{};
  const double_buffer::ReadResult result =
      double_buffer::read_latest(reader_.buffer(), [&](const std::uint64_t* payload) {
        state = double_buffer::load_struct<proto::ToolState>(payload);
      });
  if (result.status != double_buffer::ReadStatus::kAccepted || !is_sound(state))
    return std::nullopt;
  return state;
}

}  // namespace stillgrid::publication
