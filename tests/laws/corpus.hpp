#pragma once

#include <filesystem>

namespace stillgrid::laws {

/// Replays every case of a folder in the order of names, a line each. A case holds, or is listed as
/// failing `until` a step and fails: anything else is not as expected, what is listed and holds
/// too, so that the list stays true. Returns whether all were. Throws std::runtime_error for a
/// folder without cases.
[[nodiscard]] bool replay_corpus(const std::filesystem::path& folder);

}  // namespace stillgrid::laws
