#include "haptic_server/recording/line_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace stillgrid::recording {

LineFile::LineFile(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0)
    throw std::runtime_error("--record: value '" + file.string() +
                             "': expected a file that can be written: " + std::strerror(errno));
}

LineFile::~LineFile() {
  (void)end();
}

void LineFile::add(std::string_view line) {
  waiting_ += line;
  waiting_ += '\n';
}

int LineFile::flush() noexcept {
  while (!waiting_.empty()) {
    const ::ssize_t written = ::write(descriptor_, waiting_.data(), waiting_.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return EIO;  // no device that takes lines says so
    const auto bytes = static_cast<std::size_t>(written);
    const std::size_t newline = std::string_view(waiting_).substr(0, bytes).rfind('\n');
    half_line_bytes_ =
        newline == std::string_view::npos ? half_line_bytes_ + bytes : bytes - newline - 1;
    waiting_.erase(0, bytes);
  }
  return 0;
}

std::uint64_t LineFile::end() noexcept {
  if (descriptor_ < 0) return 0;
  (void)flush();
  const ::off_t size = ::lseek(descriptor_, 0, SEEK_END);  // fails on a pipe, which keeps its half
  if (half_line_bytes_ > 0 && size >= 0)
    (void)::ftruncate(descriptor_, size - static_cast<::off_t>(half_line_bytes_));
  ::close(descriptor_);
  descriptor_ = -1;
  return static_cast<std::uint64_t>(std::count(waiting_.begin(), waiting_.end(), '\n'));
}

}  // namespace stillgrid::recording
