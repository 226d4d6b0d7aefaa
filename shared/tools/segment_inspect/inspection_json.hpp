#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "shared/tools/segment_inspect/segment_summary.hpp"

namespace stillgrid::segment_inspect {

/// How much of a scene goes into its JSON.
struct JsonOptions {
  std::size_t max_spheres = 100'000;  // moving and static, each
  bool history = false;               // the snapshots before the newest too
};

/// The names are those of docs/formats.md, "segment_inspect". What is not known, and a number that
/// is none, is null.
[[nodiscard]] nlohmann::ordered_json json_of(const reading::SegmentSummary& summary);

/// An array of summaries.
[[nodiscard]] nlohmann::ordered_json json_of(std::span<const reading::SegmentSummary> summaries);

/// What a scene's segment tells once: "fixed" of a session.
[[nodiscard]] nlohmann::ordered_json json_of_fixed_part(const publication::SceneView& view,
                                                        const JsonOptions& options);

/// What the device told, of the state of a tool; what it did not tell is null.
[[nodiscard]] nlohmann::ordered_json json_of(const proto::DeviceFigures& device);

/// A session with all that its segments hold. Each may be null.
[[nodiscard]] nlohmann::ordered_json json_of(const std::string& session,
                                             const reading::ObservedSegment* scene,
                                             const reading::ObservedSegment* tool,
                                             const JsonOptions& options);

/// Valid JSON whatever bytes the strings hold.
[[nodiscard]] std::string text_of(const nlohmann::ordered_json& json);

}  // namespace stillgrid::segment_inspect
