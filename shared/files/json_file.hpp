#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace stillgrid::files {

/// Writes a report, indented by two, as write_whole() does. Text that is no UTF-8, as a file's name
/// may be, has its bad bytes replaced.
void write_json(const std::filesystem::path& file, const nlohmann::json& json);

}  // namespace stillgrid::files
