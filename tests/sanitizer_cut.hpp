#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define STILLGRID_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define STILLGRID_SANITIZED 1
#endif
#endif

namespace stillgrid::tests {

/// Into what minutes, heaps and seeds are cut with a sanitizer, which sees the same code in less.
#ifdef STILLGRID_SANITIZED
inline constexpr int kCut = 10;
#else
inline constexpr int kCut = 1;
#endif

}  // namespace stillgrid::tests
