#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "shared/publication/mouse_segment.hpp"

namespace stillgrid::scene_viewer {

/// A page's message about its mouse.
struct MouseMessage {
  std::string holder;       // which page; drawn by it at random
  bool is_release = false;  // it lets the hand go; the pose is unset
  proto::MousePose pose;    // but for its time
};

/// Returns the message in a request's body, in the JSON of docs/viewer.md. Returns std::nullopt if
/// a member is missing, has another type, or is out of bounds.
[[nodiscard]] std::optional<MouseMessage> mouse_message(std::string_view body);

/// The hands that pages hold by the mouse: one page a session, until it lets go or is silent for
/// kHeld_ns. Thread: one.
class MouseHands {
 public:
  static constexpr std::uint64_t kHeld_ns = 1'000'000'000;

  /// Publishes the pose, or ends the hold. Returns why not, one line, or an empty one. Throws
  /// SegmentError where shared memory gives no segment. now_ns: CLOCK_MONOTONIC. session: the
  /// user's own.
  [[nodiscard]] std::string move(const std::string& session, const MouseMessage& message,
                                 std::uint64_t now_ns);

  /// Ends the hold of pages that are silent.
  void drop_silent(std::uint64_t now_ns);

 private:
  struct Hold {
    Hold(std::string page, std::uint64_t now_ns, publication::SessionLock lock)
        : holder(std::move(page)), heard_ns(now_ns), writer(std::move(lock)) {}

    std::string holder;
    std::uint64_t heard_ns;
    publication::MouseWriter writer;
  };
  std::map<std::string, Hold> holds_;  // the key is a session
};

}  // namespace stillgrid::scene_viewer
