#pragma once

#include <cstdint>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace stillgrid::realtime {

/// While it lives, the calling thread treats numbers below 2.2e-308 as zero, as operands and as
/// results. Velocities that decay then become zero. Otherwise they stay at 1e-323 for ever, and an
/// operation on such a number takes a hundred times as long. Has no effect on processors other than
/// x86-64 and 64-bit ARM.
class FlushDenormals {
 public:
  FlushDenormals() noexcept : before_(control()) { set_control(before_ | kFlush); }
  ~FlushDenormals() { set_control(before_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
#if defined(__SSE2__)
  static constexpr std::uint64_t kFlush = 0x8040;  // MXCSR: flush to zero, denormals are zero
  static std::uint64_t control() noexcept {
    return _mm_getcsr();
  }
  static void set_control(std::uint64_t value) noexcept {
    _mm_setcsr(static_cast<std::uint32_t>(value));
  }
#elif defined(__aarch64__)
  static constexpr std::uint64_t kFlush = std::uint64_t{1} << 24;  // FPCR: FZ
  static std::uint64_t control() noexcept {
    std::uint64_t value = 0;
    asm volatile("mrs %0, fpcr" : "=r"(value));
    return value;
  }
  static void set_control(std::uint64_t value) noexcept {
    asm volatile("msr fpcr, %0" : : "r"(value));
  }
#else
  static constexpr std::uint64_t kFlush = 0;
  static std::uint64_t control() noexcept {
    return 0;
  }
  static void set_control(std::uint64_t) noexcept {}
#endif

  std::uint64_t before_;
};

}  // namespace stillgrid::realtime
