#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace stillgrid::realtime {

/// One call by name: how often sections made it, and where the first came from.
struct Violation {
  constexpr Violation() noexcept = default;
  constexpr explicit Violation(const char* name) noexcept : call(name) {}

  const char* call = nullptr;
  std::atomic<std::uint64_t> count = 0;
  std::uint64_t first_tick = 0;
  std::array<std::uintptr_t, 24> frames{};  // of the first call, innermost first, 0 at the end
  Violation* next = nullptr;                // of those that happened
};

/// Counts the call if the calling thread is inside a section. violation: never destroyed.
/// Realtime: lock-free, allocates nothing; the first of a name unwinds the stack.
void note(Violation& violation) noexcept;

}  // namespace stillgrid::realtime
