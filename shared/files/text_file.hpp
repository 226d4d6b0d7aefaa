#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace stillgrid::files {

inline constexpr std::uintmax_t kMiB = 1U << 20U;

/// Throws std::runtime_error, one line that begins with the file's name, unless it is a regular
/// file of at most `most_bytes`. A pipe, a device or a folder is refused without being opened.
void require_regular(const std::filesystem::path& file, std::uintmax_t most_bytes);

/// Returns the content of a text file. Throws like require_regular(), and for a file that cannot be
/// read, holds a zero byte, or is packed as MCAP or gzip. Reads 64 KiB at a time: a sparse file is
/// refused at its first hole.
[[nodiscard]] std::string read_text(const std::filesystem::path& file, std::uintmax_t most_bytes);

}  // namespace stillgrid::files
