#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/publication/segment_files.hpp"
#include "shared/tools/scene_viewer/tick_history.hpp"

namespace stillgrid::scene_viewer {

/// What a record of a saved view holds: docs/formats.md, "Saved views".
enum class ViewRecord : std::uint32_t {
  kScene = 1,  // the message of /api/scene
  kFrame = 2,  // that of /api/frame, numbered from 1 on
  kTicks = 3,  // TickSamples, some 30 ms of them
};

/// Appends records to a new file, each by one call: killed, it leaves whole ones but for the last.
/// Thread: one.
class ViewWriter {
 public:
  /// Throws std::runtime_error in one line, as the others.
  explicit ViewWriter(const std::filesystem::path& file);

  void add(ViewRecord kind, std::string_view bytes);
  void add(std::span<const TickSample> samples);

 private:
  std::filesystem::path path_;
  publication::FileDescriptor file_;
  std::string buffer_;
};

/// A saved view, of which only the places of its records are held. What was cut off at its end is
/// as if it were not there. Thread: any.
class ViewReader {
 public:
  /// Throws std::runtime_error, one line, where that is no saved view.
  explicit ViewReader(const std::filesystem::path& file);

  [[nodiscard]] std::size_t scene_count() const noexcept { return scenes_.size(); }
  [[nodiscard]] std::size_t frame_count() const noexcept { return frames_.size(); }

  /// Pre: below the count. Nothing if the file has been cut since.
  [[nodiscard]] std::optional<std::string> scene(std::size_t i) const;
  [[nodiscard]] std::optional<std::string> frame(std::size_t i) const;

  /// At most `most` from number `from` on.
  [[nodiscard]] std::vector<TickSample> ticks(std::uint64_t from, std::size_t most) const;

 private:
  struct Place {
    std::uint64_t offset = 0;
    std::uint32_t bytes = 0;
    std::uint64_t first_tick = 0;
  };
  [[nodiscard]] std::optional<std::string> read(const Place& place) const;

  publication::FileDescriptor file_;
  std::vector<Place> scenes_, frames_, ticks_;
};

}  // namespace stillgrid::scene_viewer
