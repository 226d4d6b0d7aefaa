#pragma once

#include <string>

#include "shared/tables/trajectory.hpp"

namespace stillgrid::devices {

/// What of a recording no hand did, in one line: the first such place, FILE:LINE: and how many
/// there are; empty where there is none. It is replayed as it is: a path that was written by hand
/// may be meant so.
///
/// A gap: two rows more than 100 ms apart, and more than twenty times what rows are apart by the
/// median, of ten rows or more. A jump: more than 1 mm at more than 5 m/s, counted since the
/// position last changed, for a fast logger repeats the readings of a slow sensor. As
/// stillgrid_import, which refuses both (docs/import.md).
[[nodiscard]] std::string faults_of(const std::string& file, const tables::Trajectory& trajectory);

}  // namespace stillgrid::devices
