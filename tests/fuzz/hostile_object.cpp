#include "tests/fuzz/hostile_object.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>

#include "shared/publication/segment_files.hpp"
#include "tests/fuzz/fuzz_input.hpp"

namespace stillgrid::fuzz {

std::string HostileObject::session() {
  return "fuzz-" + std::to_string(::getpid());
}

HostileObject::HostileObject(proto::SegmentKind kind, std::span<const std::byte> bytes)
    : path_(publication::own_segment_path(session(), kind)),
      fd_(::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600)) {
  require(fd_ >= 0 && publication::lock_object(fd_),
          "an object of our own can be made in /dev/shm");
  if (bytes.empty()) return;
  const auto size = static_cast<off_t>(bytes.size());
  require(::posix_fallocate(fd_, 0, size) == 0, "there is shared memory enough");
  void* const start =
      ::mmap(nullptr, bytes.size(), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd_, 0);
  require(start != MAP_FAILED, "the object can be mapped");
  bytes_ = {static_cast<std::byte*>(start), bytes.size()};
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
}

HostileObject::~HostileObject() {
  remove_name();
  if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
  ::close(fd_);
}

void HostileObject::remove_name() noexcept {
  if (!path_.empty()) ::unlink(path_.c_str());
  path_.clear();
}

void HostileObject::shrink(std::size_t size_bytes) const noexcept {
  require(::ftruncate(fd_, static_cast<off_t>(size_bytes)) == 0, "the object can be shrunk");
}

}  // namespace stillgrid::fuzz
