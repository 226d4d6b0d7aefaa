#include "tests/haptic_server/devices/allocation_counter.hpp"

#include <atomic>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__)  // g++
#define STILLGRID_COUNTS_ALLOCATIONS
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define STILLGRID_COUNTS_ALLOCATIONS
#endif
#endif

#ifdef STILLGRID_COUNTS_ALLOCATIONS
#include <sanitizer/allocator_interface.h>

namespace {

std::atomic<std::uint64_t> allocations = 0;

const int hooks = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void* /*memory*/, std::size_t /*size*/) { ++allocations; },
    [](const volatile void* /*memory*/) {});

}  // namespace

namespace stillgrid::devices {

std::optional<std::uint64_t> allocation_count() noexcept {
  return hooks > 0 ? std::optional<std::uint64_t>(allocations) : std::nullopt;
}

}  // namespace stillgrid::devices

#else

namespace stillgrid::devices {

std::optional<std::uint64_t> allocation_count() noexcept {
  return std::nullopt;
}

}  // namespace stillgrid::devices

#endif
