#pragma once

#include <optional>
#include <span>
#include <vector>

#include "shared/reading/observed_segment.hpp"

namespace stillgrid::segment_inspect {

/// Counts the publications of those that live, for watch_s or, without it, for as long as the
/// slowest needs, 0.3 to 2 s. Returns at once when none lives.
void measure_rates(std::span<reading::ObservedSegment> segments, std::optional<double> watch_s);

/// Summaries with measured rates, in the order of the names; what has gone meanwhile is left out.
[[nodiscard]] std::vector<reading::SegmentSummary> survey(
    std::span<const publication::SegmentFile> files, std::optional<double> watch_s);

/// Removes what a killed writer left, and says whether it did. What lives, and what is not ours, is
/// not touched. Throws SegmentError when it may not.
bool remove_leftover(const publication::SegmentFile& file);

}  // namespace stillgrid::segment_inspect
