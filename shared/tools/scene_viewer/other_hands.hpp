#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "shared/reading/segment_follower.hpp"
#include "shared/tools/scene_viewer/frame.hpp"

namespace stillgrid::scene_viewer {

/// The tools of a session's other hands. Thread: one.
class OtherHands {
 public:
  /// session: SESSION+HAND, of the hand that is shown in full; SESSION has no others.
  explicit OtherHands(std::string session) : session_(std::move(session)) {}

  /// Those whose haptic_server lives.
  [[nodiscard]] std::vector<OtherHand> look();

 private:
  struct Followed {
    std::string name;
    reading::SegmentFollower scene, tool;
  };
  void find_new();

  std::string session_;
  std::uint64_t looks_ = 0;
  std::deque<Followed> hands_;
};

}  // namespace stillgrid::scene_viewer
