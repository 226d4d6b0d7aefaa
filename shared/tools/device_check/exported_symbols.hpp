#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stillgrid::device_check {

/// The names that a shared library offers to others, read from its file without loading it.
///
/// Throws std::runtime_error, a line without the file's name, if it is no whole 64-bit ELF library
/// of this processor's byte order.
[[nodiscard]] std::vector<std::string> exported_symbols(const std::filesystem::path& library);

}  // namespace stillgrid::device_check
