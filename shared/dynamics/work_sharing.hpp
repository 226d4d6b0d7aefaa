#pragma once

#include <algorithm>
#include <cstddef>

namespace stillgrid::dynamics {

/// Shares independent work over threads; this one leaves all of it to the caller.
///
/// Work is divided into chunks by its size alone, and no chunk depends on another. Results are
/// equal to the bit for any number of threads. Thread: one caller at a time.
class WorkSharing {
 public:
  WorkSharing() = default;
  virtual ~WorkSharing() = default;
  WorkSharing(const WorkSharing&) = delete;
  WorkSharing& operator=(const WorkSharing&) = delete;

  /// The caller alone.
  [[nodiscard]] static const WorkSharing& alone() {
    static const WorkSharing alone;
    return alone;
  }

  /// Calls work(first, end) for each chunk of 0 .. count - 1, in any order. Throws the exceptions
  /// of work.
  template <class Work>
  void for_each_chunk(std::size_t count, std::size_t chunk, const Work& work) const {
    const std::size_t chunks = (count + chunk - 1) / chunk;
    const auto one = [&](std::size_t i) { work(i * chunk, std::min(count, (i + 1) * chunk)); };
    share(
        chunks,
        [](const void* todo, std::size_t i) { (*static_cast<const decltype(one)*>(todo))(i); },
        &one);
  }

 private:
  virtual void share(std::size_t chunks, void (*one)(const void*, std::size_t),
                     const void* work) const {
    for (std::size_t i = 0; i < chunks; ++i) one(work, i);
  }
};

}  // namespace stillgrid::dynamics
