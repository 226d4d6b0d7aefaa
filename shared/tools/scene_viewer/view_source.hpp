#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "shared/reading/segment_follower.hpp"
#include "shared/tools/scene_viewer/frame_store.hpp"

namespace stillgrid::scene_viewer {

/// What a page asks first and again.
struct ViewStatus {
  bool live = false;
  std::uint64_t first_frame = 1, last_frame = 0;  // none: last before first
  reading::Life sim = reading::Life::kAbsent, hand = reading::Life::kAbsent;
  double now_s = 0.0;  // on the frames' axis
  std::string scene_key;
  std::string note;                       // what hinders, one line
  std::string sim_command, hand_command;  // that started each server; empty: not known
};

/// What a page shows: a session, a saved view or a recording. Thread: any, each call.
class ViewSource {
 public:
  ViewSource() = default;
  virtual ~ViewSource() = default;
  ViewSource(const ViewSource&) = delete;
  ViewSource& operator=(const ViewSource&) = delete;
  ViewSource(ViewSource&&) = delete;
  ViewSource& operator=(ViewSource&&) = delete;

  [[nodiscard]] virtual ViewStatus status() const = 0;

  /// Of that key, or without one the newest; null where it is not held.
  [[nodiscard]] virtual Message scene(std::optional<std::string_view> key) const = 0;

  /// Of that number, or without one the newest; null where it is not held. Throws
  /// std::runtime_error, one line, where what is held is no frame.
  [[nodiscard]] virtual Message frame(std::optional<std::uint64_t> number) const = 0;

  /// At most `most` ticks from number `from` on.
  [[nodiscard]] virtual std::string ticks(std::uint64_t from, std::size_t most) const = 0;
};

}  // namespace stillgrid::scene_viewer
