#include "shared/publication/tool_segment.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "shared/collision/unit_quaternion.hpp"

namespace stillgrid::publication {
namespace {

using Atomics = double_buffer::HardwareAtomics;

/// Written so that a NaN does not pass.
bool is_plausible(double x) {
  return std::abs(x) <= proto::kLargestNumber;
}
template <std::size_t N>
bool are_plausible(const std::array<double, N>& values) {
  return std::all_of(values.begin(), values.end(), is_plausible);
}

/// Of a ToolState or a PathSample.
template <class Pose>
bool is_plausible_pose(const Pose& pose) {
  return are_plausible(pose.position_m) && are_plausible(pose.velocity_m_s) &&
         collision::is_unit(pose.orientation_xyzw);
}

proto::ToolPath& path_in(SegmentWriter& segment) {
  return *reinterpret_cast<proto::ToolPath*>(segment.bytes() + sizeof(proto::SegmentHeader));
}

}  // namespace

bool is_sound(const proto::ToolState& state) noexcept {
  return is_plausible_pose(state) && are_plausible(state.force_N);
}

bool is_sound(const proto::PathSample& sample) noexcept {
  return is_plausible_pose(sample);
}

bool has_sound_figures(const proto::ToolState& state) noexcept {
  const proto::TickFigures& figures = state.before;
  const proto::DisplayedSnapshot& shown = figures.displayed;
  return are_plausible(figures.torque_N_m) && (figures.flags & ~proto::kSafetyFlagMask) == 0 &&
         are_plausible(state.device.axes) && is_plausible(state.device.gripper_m) &&
         is_plausible(state.device.gripper_force_N) && is_plausible(state.device.temperature_C) &&
         shown.alpha >= 0.0 && shown.alpha <= 1.0 && shown.age_s >= 0.0 &&
         is_plausible(shown.age_s) && shown.is_local <= 1;
}

ToolWriter::ToolWriter(SessionLock lock, std::uint64_t period_ns, proto::Clock clock,
                       std::uint64_t start_ns, std::optional<gid_t> readers)
    : segment_(std::move(lock),
               {.kind = proto::SegmentKind::kTool,
                .layout_hash = proto::kToolLayoutHash,
                .period_ns = period_ns,
                .clock = clock,
                .start_ns = start_ns,
                .fixed_bytes = sizeof(proto::SegmentHeader) + sizeof(proto::ToolPath),
                .payload_bytes = sizeof(proto::ToolState),
                .readers = readers}) {
  proto::ToolPath& path = path_in(segment_);
  path.newest = proto::kNever;
  for (proto::PathSample& sample : path.samples) sample.number = proto::kNever;
  segment_.announce();
}

/// docs/protocol.md, "The tool's path".
void ToolWriter::add_to_path(const proto::PathSample& sample) noexcept {
  const std::uint64_t n = sample.number;
  if (n == proto::kNever || (newest_ != proto::kNever && n <= newest_)) return;
  const auto words =
      std::bit_cast<std::array<std::uint64_t, sizeof(proto::PathSample) / 8>>(sample);
  proto::ToolPath& path = path_in(segment_);
  auto* const target =
      reinterpret_cast<std::uint64_t*>(&path.samples[n % proto::kPathLength]);  // the number first
  Atomics::store(target[0], proto::kNever, std::memory_order_relaxed);          // P1 being written
  Atomics::fence(std::memory_order_release);                                    // P2
  for (std::size_t i = 1; i < words.size(); ++i)                                // P3
    Atomics::store(target[i], words[i], std::memory_order_relaxed);
  Atomics::store(target[0], n, std::memory_order_release);    // P4
  Atomics::store(path.newest, n, std::memory_order_release);  // P5
  newest_ = n;
}

void ToolWriter::publish(const proto::ToolState& state) noexcept {
  add_to_path({state.path_number, state.position_m, state.orientation_xyzw, state.velocity_m_s});
  const auto words = std::bit_cast<std::array<std::uint64_t, sizeof(proto::ToolState) / 8>>(state);
  double_buffer::publish(segment_.buffer(), ++count_, {{0, words}});
  Atomics::store(segment_.header().heartbeat_ns, state.time_ns, std::memory_order_relaxed);
}

std::optional<std::uint64_t> PathView::newest() const noexcept {
  const std::uint64_t n = Atomics::load(path_->newest, std::memory_order_acquire);  // Q1
  if (n == proto::kNever) return std::nullopt;
  return n;
}

std::optional<proto::PathSample> PathView::sample(std::uint64_t n) const noexcept {
  const proto::PathSample& shared = path_->samples[n % proto::kPathLength];
  if (n == proto::kNever || Atomics::load(shared.number, std::memory_order_acquire) != n)  // Q2
    return std::nullopt;
  auto sample = double_buffer::load_struct<proto::PathSample>(
      reinterpret_cast<const std::uint64_t*>(&shared));                                   // Q3
  Atomics::fence(std::memory_order_acquire);                                              // Q4
  if (Atomics::load(shared.number, std::memory_order_relaxed) != n) return std::nullopt;  // Q5
  sample.number = n;
  if (!is_sound(sample)) return std::nullopt;
  return sample;
}

ToolView::ToolView(SegmentReader&& reader) : reader_(std::move(reader)) {
  if (reader_.fixed_bytes() < sizeof(proto::SegmentHeader) + sizeof(proto::ToolPath))
    throw SegmentError("the tool segment has no room for the tool's path");
  if (reader_.header().payload_bytes < sizeof(proto::ToolState))
    throw SegmentError("the tool segment's slots are too small for a tool state");
}

std::optional<proto::ToolState> ToolView::read() const noexcept {
  const auto state = double_buffer::read_struct<proto::ToolState>(reader_.buffer());
  return state && is_sound(*state) ? state : std::nullopt;
}

PathView ToolView::path() const noexcept {
  return PathView(
      *reinterpret_cast<const proto::ToolPath*>(reader_.bytes() + sizeof(proto::SegmentHeader)));
}

}  // namespace stillgrid::publication
