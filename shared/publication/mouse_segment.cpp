#include "shared/publication/mouse_segment.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "shared/collision/unit_quaternion.hpp"

namespace stillgrid::publication {
namespace {

constexpr std::uint64_t kAnimationFrame_ns = 16'666'667;  // of a browser

}  // namespace

bool is_sound(const proto::MousePose& pose) noexcept {
  // Written so that a NaN does not pass.
  return std::all_of(pose.position_m.begin(), pose.position_m.end(),
                     [](double x) { return std::abs(x) <= proto::kFarthestMouse_m; }) &&
         collision::is_unit(pose.orientation_xyzw);
}

MouseWriter::MouseWriter(SessionLock lock)
    : segment_(std::move(lock), {.kind = proto::SegmentKind::kMouse,
                                 .layout_hash = proto::kMouseLayoutHash,
                                 .period_ns = kAnimationFrame_ns,
                                 .clock = proto::Clock::kMonotonic,
                                 .start_ns = 0,
                                 .fixed_bytes = sizeof(proto::SegmentHeader),
                                 .payload_bytes = sizeof(proto::MousePose)}) {
  segment_.announce();
}

void MouseWriter::publish(const proto::MousePose& pose) noexcept {
  const auto words = std::bit_cast<std::array<std::uint64_t, sizeof(proto::MousePose) / 8>>(pose);
  double_buffer::publish(segment_.buffer(), ++count_, {{0, words}});
  double_buffer::HardwareAtomics::store(segment_.header().heartbeat_ns, pose.time_ns,
                                        std::memory_order_relaxed);
}

MouseView::MouseView(SegmentReader&& reader) : reader_(std::move(reader)) {
  if (reader_.header().payload_bytes < sizeof(proto::MousePose))
    throw SegmentError("the mouse segment's slots are too small for a pose");
}

std::optional<proto::MousePose> MouseView::read() const noexcept {
  const auto pose = double_buffer::read_struct<proto::MousePose>(reader_.buffer());
  return pose && is_sound(*pose) ? pose : std::nullopt;
}

}  // namespace stillgrid::publication
