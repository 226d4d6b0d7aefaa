#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/segment_header.hpp"
#include "shared/publication/mouse_segment.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/segment_files.hpp"
#include "shared/publication/tool_segment.hpp"

namespace stillgrid::reading {

enum class SegmentState {
  kAlive,     // announced, and its writer lives
  kDead,      // announced, left by a writer that was killed
  kStarting,  // not announced yet, and its writer lives
  kHalfMade,  // left by a writer that was killed before it announced
  kRefused,  // what stands there cannot be read: foreign, truncated, another version, not permitted
  kGone,     // the name went away while it was looked at
};

/// Figures of one segment. In other states than kAlive and kDead only the name, the refusal and the
/// size are set.
struct SegmentSummary {
  publication::SegmentFile file;
  SegmentState state = SegmentState::kGone;
  std::string refusal;          // one line of printable ASCII; empty but for kRefused
  bool is_other_build = false;  // refused for its version or layout
  bool is_leftover = false;     // ours, and its writer is dead
  std::uint64_t size_bytes = 0;
  std::optional<proto::SegmentHeader> header;  // as checked; the words that change are the newest
  std::optional<double> measured_rate_hz;      // publications in real time; 0: none was seen
  std::optional<double> age_s;  // since the latest snapshot or tool state; nothing in virtual time
  std::optional<std::uint32_t> moving_spheres;  // in the latest snapshot
  std::optional<std::uint32_t> static_spheres;
  std::optional<proto::RelayFigures> relay;  // sound; nothing: no relay writes the segment
};

/// A segment that is being looked at: its summary, and the mapping if it can be read.
struct ObservedSegment {
  SegmentSummary summary;
  std::optional<publication::SceneView> scene;
  std::optional<publication::ToolView> tool;
  std::optional<publication::MouseView> mouse;

  /// The mapping, or null.
  [[nodiscard]] const publication::SegmentReader* reader() const noexcept;
};

/// Looks at what stands under the name, whatever it is, without disturbing anybody. Never throws
/// for what it finds there. At most MappingGuard::kMax may be held at one time.
[[nodiscard]] ObservedSegment observe(const publication::SegmentFile& file);

/// Brings the summary of a readable segment up to date.
void look_again(ObservedSegment& segment);

/// Seconds from a stamp of the writer's clock to now; nothing for virtual time, for no stamp and
/// for one that lies ahead.
[[nodiscard]] std::optional<double> age_of(std::uint64_t stamp_ns, proto::Clock clock,
                                           std::uint64_t now_ns) noexcept;

/// The same text for a terminal: whatever is not printable ASCII is a question mark.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace stillgrid::reading
