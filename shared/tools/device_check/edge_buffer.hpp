#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <system_error>

namespace stillgrid::device_check {

/// Room for a struct of which only the first struct_size bytes exist: whoever reads or writes
/// behind them dies of SIGSEGV.
template <class Struct>
class EdgeBuffer {
 public:
  EdgeBuffer()
      : page_(static_cast<std::size_t>(::sysconf(_SC_PAGESIZE))),
        memory_(::mmap(nullptr, 2 * page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1,
                       0)) {
    if (memory_ == MAP_FAILED || ::mprotect(end(), page_, PROT_NONE) != 0)
      throw std::system_error(errno, std::generic_category(), "a buffer at the edge of memory");
  }
  ~EdgeBuffer() { ::munmap(memory_, 2 * page_); }
  EdgeBuffer(const EdgeBuffer&) = delete;
  EdgeBuffer& operator=(const EdgeBuffer&) = delete;

  /// The struct that ends with the room, zero but for its struct_size; the one before is gone.
  /// struct_size: a multiple of 8, for the alignment, below a page; of 0 the first 8 bytes exist.
  [[nodiscard]] Struct* cut(std::size_t struct_size) noexcept {
    const std::size_t size = std::max<std::size_t>(struct_size, 8);
    std::memset(end() - size, 0, size);
    auto* const result = reinterpret_cast<Struct*>(end() - size);
    result->struct_size = static_cast<std::uint32_t>(struct_size);
    return result;
  }

 private:
  [[nodiscard]] std::byte* end() const noexcept { return static_cast<std::byte*>(memory_) + page_; }

  std::size_t page_;
  void* memory_;
};

}  // namespace stillgrid::device_check
