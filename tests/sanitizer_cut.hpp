#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define STILLGRID_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define STILLGRID_SANITIZED 1
#endif
#endif

namespace stillgrid::tests {

#ifdef STILLGRID_SANITIZED
inline constexpr bool kIsSanitized = true;
#else
inline constexpr bool kIsSanitized = false;
#endif
/// Into what minutes and heaps are cut with a sanitizer, which sees the same code in less.
inline constexpr int kCut = kIsSanitized ? 10 : 1;
/// The end of a range of seeds. A sanitizer ends it after seed 1.
[[nodiscard]] constexpr unsigned seeds_end(unsigned end) {
  return kIsSanitized ? 2 : end;
}

}  // namespace stillgrid::tests
