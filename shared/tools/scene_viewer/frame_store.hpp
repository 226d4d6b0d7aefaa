#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace stillgrid::scene_viewer {

using Message = std::shared_ptr<const std::string>;

/// The frames of the last minute, of them the newest that fit into 256 MiB. Thread: any.
class FrameStore {
 public:
  static constexpr double kKept_s = 60.0;
  static constexpr std::size_t kMaxBytes = std::size_t{256} << 20U;

  /// One more, which has the number last() + 1; wall_s: any clock that goes on.
  void add(std::string message, double wall_s);

  /// A frame, or without a number the newest; null where there is none.
  [[nodiscard]] Message get(std::optional<std::uint64_t> number) const;

  [[nodiscard]] std::uint64_t first() const;
  [[nodiscard]] std::uint64_t last() const;  // first() - 1 while there is none

 private:
  struct Stored {
    Message message;
    double wall_s;
  };
  mutable std::mutex mutex_;
  std::deque<Stored> frames_;
  std::uint64_t first_ = 1;
  std::size_t bytes_ = 0;
};

}  // namespace stillgrid::scene_viewer
