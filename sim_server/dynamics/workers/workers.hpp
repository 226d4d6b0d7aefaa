#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

namespace stillgrid::dynamics {

/// Threads that share the work of a large scene (oneTBB).
///
/// Work is cut into chunks by its size alone. What a chunk does must not depend on another, and
/// sums go chunk by chunk in their order: so no byte depends on the number of threads. One caller
/// at a time.
class Workers {
 public:
  /// threads: the caller's among them; one works without any other. Where the system refuses some
  /// there are fewer. Pre: at least 1.
  explicit Workers(int threads = 1);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  Workers(Workers&&) = delete;
  Workers& operator=(Workers&&) = delete;

  /// The caller alone: what is too small to be shared.
  [[nodiscard]] static const Workers& alone();
  [[nodiscard]] int threads() const noexcept { return threads_; }

  /// work(first, last) for each chunk of 0 .. count - 1, in any order.
  /// Throws what it throws: it should throw nothing, for other chunks may be done by then.
  template <class Work>
  void for_each_chunk(std::size_t count, std::size_t chunk, const Work& work) const {
    const std::size_t chunks = chunks_of(count, chunk);
    const auto one = [&](std::size_t i) { work(i * chunk, std::min(count, (i + 1) * chunk)); };
    if (threads_ == 1 || chunks < 2)
      for (std::size_t i = 0; i < chunks; ++i) one(i);
    else
      share(
          chunks,
          [](const void* todo, std::size_t i) { (*static_cast<const decltype(one)*>(todo))(i); },
          &one);
  }
  /// work(i) for each of 0 .. count - 1, as many at once as a chunk has.
  template <class Work>
  void for_each(std::size_t count, std::size_t chunk, const Work& work) const {
    for_each_chunk(count, chunk, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) work(i);
    });
  }
  [[nodiscard]] static std::size_t chunks_of(std::size_t count, std::size_t chunk) {
    return (count + chunk - 1) / chunk;
  }

 private:
  void share(std::size_t chunks, void (*one)(const void*, std::size_t), const void* work) const;

  struct Arena;
  int threads_;
  std::unique_ptr<Arena> arena_;
};

}  // namespace stillgrid::dynamics
