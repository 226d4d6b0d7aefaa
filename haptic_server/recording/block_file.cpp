#include "haptic_server/recording/block_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

namespace stillgrid::recording {
namespace {

std::filesystem::file_type type_of(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::status(file, ignored).type();
}

}  // namespace

BlockFile::BlockFile(const std::filesystem::path& file)
    : path_(file),
      is_new_(type_of(file) == std::filesystem::file_type::not_found),
      holds_earlier_(type_of(file) == std::filesystem::file_type::regular),
      descriptor_(::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0)
    throw std::runtime_error("--record: value '" + file.string() +
                             "': expected a file that can be written: " + std::strerror(errno));
}

BlockFile::~BlockFile() {
  (void)end();
}

void BlockFile::add(std::string_view block, std::uint64_t rows) {
  waiting_ += block;
  blocks_.push_back({block.size(), rows});
}

int BlockFile::flush() noexcept {
  if (holds_earlier_ && !has_begun_) return 0;
  if (holds_earlier_ && ::ftruncate(descriptor_, 0) != 0) return errno;
  holds_earlier_ = false;
  while (!waiting_.empty()) {
    const ::ssize_t written = ::write(descriptor_, waiting_.data(), waiting_.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return EIO;  // no device that takes bytes says so
    waiting_.erase(0, static_cast<std::size_t>(written));
    half_block_bytes_ += static_cast<std::size_t>(written);
    while (!blocks_.empty() && half_block_bytes_ >= blocks_.front().bytes) {
      half_block_bytes_ -= blocks_.front().bytes;
      blocks_.pop_front();
    }
  }
  return 0;
}

std::uint64_t BlockFile::end() noexcept {
  if (descriptor_ < 0) return 0;
  if (has_begun_) (void)flush();
  const ::off_t size = ::lseek(descriptor_, 0, SEEK_END);  // fails on a pipe, which keeps its half
  if (half_block_bytes_ > 0 && size >= 0)
    (void)::ftruncate(descriptor_, size - static_cast<::off_t>(half_block_bytes_));
  ::close(descriptor_);
  descriptor_ = -1;
  std::error_code ignored;
  if (is_new_ && !has_begun_)
    std::filesystem::remove(std::filesystem::canonical(path_, ignored), ignored);
  std::uint64_t rows = 0;
  for (const Block& block : blocks_) rows += block.rows;
  return rows;
}

}  // namespace stillgrid::recording
