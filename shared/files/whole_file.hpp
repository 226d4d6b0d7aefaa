#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>

namespace stillgrid::files {

/// Writes a file that appears whole or not at all, whatever stops the program: what `write` puts
/// out goes to FILE.part, which then takes the file's name. What exists and is no file, as a pipe
/// or a terminal, is written as it is. Throws std::runtime_error naming the file if it cannot be
/// written.
void write_whole(const std::filesystem::path& file,
                 const std::function<void(std::ostream&)>& write);

/// Throws std::runtime_error unless write_whole() can begin: asked before work that takes long.
void require_writable(const std::filesystem::path& file);

}  // namespace stillgrid::files
