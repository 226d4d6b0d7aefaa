#include "shared/files/whole_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

namespace stillgrid::files {
namespace {

/// Where to write until all is there.
std::filesystem::path part_of(const std::filesystem::path& file) {
  std::filesystem::path part = file;
  std::error_code ignored;
  const auto status = std::filesystem::status(file, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return file;
  part += ".part";
  return part;
}

std::ofstream begin(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file))
    throw std::runtime_error(file.string() + ": cannot be written: is a folder");
  std::ofstream out(part_of(file));
  if (!out)
    throw std::runtime_error(file.string() + ": cannot be written: " + std::strerror(errno));
  return out;
}

}  // namespace

void write_whole(const std::filesystem::path& file,
                 const std::function<void(std::ostream&)>& write) {
  const std::filesystem::path part = part_of(file);
  std::ofstream out = begin(file);
  std::error_code error;
  try {
    write(out);
    out.close();
    if (out && part != file) std::filesystem::rename(part, file, error);
    if (!out || error)
      throw std::runtime_error(file.string() + ": could not be written to its end" +
                               (error ? ": " + error.message() : ""));
  } catch (...) {
    if (part != file) std::filesystem::remove(part, error);
    throw;
  }
}

void require_writable(const std::filesystem::path& file) {
  if (std::filesystem::is_fifo(file)) return;  // to open one waits for its reader
  begin(file).close();
  if (part_of(file) != file) std::filesystem::remove(part_of(file));
}

}  // namespace stillgrid::files
