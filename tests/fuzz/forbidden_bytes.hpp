#pragma once

#include <cstddef>
#include <span>

#if defined(__SANITIZE_ADDRESS__)
#define STILLGRID_FORBIDS_BYTES 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define STILLGRID_FORBIDS_BYTES 1
#endif
#endif
#ifdef STILLGRID_FORBIDS_BYTES
#include <sanitizer/asan_interface.h>
#endif

namespace stillgrid::fuzz {

/// With the address sanitizer every look at these bytes is an error while this object lives, which
/// must be no longer than they are mapped. Without it nothing happens.
class ForbiddenBytes {
 public:
  explicit ForbiddenBytes(std::span<const std::byte> bytes) : bytes_(bytes) {
#ifdef STILLGRID_FORBIDS_BYTES
    ASAN_POISON_MEMORY_REGION(bytes_.data(), bytes_.size());
#endif
  }
  ~ForbiddenBytes() {
#ifdef STILLGRID_FORBIDS_BYTES
    ASAN_UNPOISON_MEMORY_REGION(bytes_.data(), bytes_.size());
#endif
  }
  ForbiddenBytes(const ForbiddenBytes&) = delete;
  ForbiddenBytes& operator=(const ForbiddenBytes&) = delete;

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace stillgrid::fuzz
