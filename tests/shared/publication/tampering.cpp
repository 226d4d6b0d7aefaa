#include "tests/shared/publication/tampering.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <stdexcept>

namespace stillgrid::publication {

Tampering::Tampering(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  struct stat status {};
  if (fd < 0 || ::fstat(fd, &status) != 0) throw std::runtime_error("cannot open " + path);
  const auto size_bytes = static_cast<std::size_t>(status.st_size);
  void* start = ::mmap(nullptr, size_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  ::close(fd);
  if (start == MAP_FAILED) throw std::runtime_error("cannot map " + path);
  bytes_ = {static_cast<std::byte*>(start), size_bytes};
}

Tampering::~Tampering() {
  ::munmap(bytes_.data(), bytes_.size());
}

}  // namespace stillgrid::publication
