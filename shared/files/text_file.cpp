#include "shared/files/text_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace stillgrid::files {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": cannot be read: " + why);
}

[[noreturn]] void refuse_size(const std::filesystem::path& file, std::uintmax_t most_bytes) {
  refuse(file, "expected at most " + std::to_string(most_bytes / kMiB) + " MiB");
}

void refuse_packed(const std::filesystem::path& file, std::string_view start) {
  if (start.starts_with("\x89MCAP"))
    throw std::runtime_error(file.string() +
                             ": an MCAP file: expected CSV, as stillgrid_import makes");
  if (start.starts_with("\x1f\x8b"))
    throw std::runtime_error(file.string() +
                             ": compressed by gzip: expected text, as gunzip makes");
}

}  // namespace

void require_regular(const std::filesystem::path& file, std::uintmax_t most_bytes) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (error) refuse(file, error.message());
  if (!std::filesystem::is_regular_file(status)) refuse(file, "expected a regular file");
  if (std::filesystem::file_size(file, error) > most_bytes && !error) refuse_size(file, most_bytes);
}

std::string read_text(const std::filesystem::path& file, std::uintmax_t most_bytes) {
  require_regular(file, most_bytes);
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse(file, std::strerror(errno));
  std::string text;
  std::array<char, 65536> part{};
  while (stream) {
    stream.read(part.data(), part.size());
    const auto count = static_cast<std::size_t>(stream.gcount());
    if (text.empty()) refuse_packed(file, {part.data(), count});
    if (std::find(part.data(), part.data() + count, '\0') != part.data() + count)
      refuse(file, "expected text, found a zero byte");
    text.append(part.data(), count);
    if (text.size() > most_bytes) refuse_size(file, most_bytes);  // it has grown
  }
  if (stream.bad()) refuse(file, "its end could not be read");
  return text;
}

}  // namespace stillgrid::files
