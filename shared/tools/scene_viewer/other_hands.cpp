#include "shared/tools/scene_viewer/other_hands.hpp"

#include <algorithm>

#include "shared/publication/hands.hpp"

namespace stillgrid::scene_viewer {
namespace {

constexpr std::uint64_t kLooksPerFind = 30;

}  // namespace

void OtherHands::find_new() {
  const std::string_view whole = publication::session_of(session_);
  for (const std::string& name : publication::hands_of_session(whole)) {
    const bool is_known = std::any_of(hands_.begin(), hands_.end(),
                                      [&](const Followed& hand) { return hand.name == name; });
    if (name.empty() || name == publication::hand_of(session_) || is_known) continue;
    const std::string session = publication::hand_session(whole, name);
    hands_.push_back({name, reading::SegmentFollower(session, proto::SegmentKind::kScene),
                      reading::SegmentFollower(session, proto::SegmentKind::kTool)});
  }
}

std::vector<OtherHand> OtherHands::look() {
  std::vector<OtherHand> seen;
  if (publication::hand_of(session_).empty()) return seen;
  if (looks_++ % kLooksPerFind == 0) find_new();
  for (Followed& hand : hands_) {
    hand.scene.look();
    hand.tool.look();
    if (hand.tool.life() != reading::Life::kAlive || hand.scene.scene() == nullptr) continue;
    const auto state = hand.tool.tool()->read();
    if (!state) continue;
    const proto::SceneHeader& scene = hand.scene.scene()->scene();
    OtherHand& other = seen.emplace_back(OtherHand{hand.name, *state, {}});
    if (!publication::has_sound_figures(*state)) other.tool.before = {};
    other.spheres.assign(scene.tool.begin(), scene.tool.begin() + scene.tool_sphere_count);
  }
  return seen;
}

}  // namespace stillgrid::scene_viewer
