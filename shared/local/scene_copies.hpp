#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shared/dynamics/tool_path.hpp"

namespace stillgrid::local {

/// How a copy came to a tick.
struct Advance {
  bool is_known = false;  // the scene, at that tick
  bool is_swap = false;   // a copy from a newer state took the place of the one shown
  int ticks = 0;          // that both copies were stepped

  Advance& operator+=(const Advance& later) noexcept {
    is_known = later.is_known;
    is_swap = is_swap || later.is_swap;
    ticks += later.ticks;
    return *this;
  }
};

/// Two copies of a scene and the paths of the tools along which both go on. One copy is shown. The
/// other one begins from a newer state, catches up, and takes the first one's place. Copy: a type
/// with a tick, with is_begun, and with is_plausible(), which says whether its numbers are such as
/// a reader takes.
///
/// Thread: one. Realtime: yes, but for the constructor, which allocates.
template <class Copy>
class SceneCopies {
 public:
  /// Adds where the own tool is at a tick. Pre: later than the last.
  void add_to_path(const dynamics::PathPose& pose) noexcept { tools_[own_hand_].path.add(pose); }
  /// Adds the new samples of another hand's tool; see dynamics::follow(). The tool goes on evenly
  /// for led_on_ticks beyond its newest sample, then it is away. Pre: hand < hands().
  template <class View>
  void follow(std::size_t hand, const View& path, std::uint64_t led_on_ticks) noexcept {
    dynamics::follow(path, tools_[hand].path);
    tools_[hand].led_on_ticks = led_on_ticks;
  }
  /// Another hand's tool is away beyond its newest sample.
  void leave(std::size_t hand) noexcept { tools_[hand].led_on_ticks = 0; }
  [[nodiscard]] std::size_t own_hand() const noexcept { return own_hand_; }
  [[nodiscard]] std::size_t hands() const noexcept { return tools_.size(); }

 protected:
  /// Pre: own_hand < hands.
  template <class Model>
  SceneCopies(const Model& model, std::size_t hands, std::size_t own_hand)
      : copies_{Copy(model), Copy(model)}, tools_(hands), own_hand_(own_hand), poses_(hands) {}

  [[nodiscard]] std::span<Copy, 2> copies() noexcept { return copies_; }
  [[nodiscard]] Copy& shown() noexcept { return copies_[shown_]; }
  [[nodiscard]] const Copy& shown() const noexcept { return copies_[shown_]; }
  [[nodiscard]] Copy& next() noexcept { return copies_[1 - shown_]; }
  [[nodiscard]] const Copy& next() const noexcept { return copies_[1 - shown_]; }

  /// Whether a state of that tick is near enough to the own tool's newest sample to begin from.
  [[nodiscard]] bool can_begin_at(std::uint64_t tick) const noexcept {
    constexpr std::uint64_t kMaxLag = 1000;  // ticks
    return tick <= known() + kMaxLag && tick + kMaxLag >= known();
  }
  /// Returns where each hand's tool is at a tick. Valid until the next call.
  [[nodiscard]] std::span<const std::optional<dynamics::ToolPose>> poses_at(
      std::uint64_t tick) noexcept {
    for (std::size_t hand = 0; hand < tools_.size(); ++hand)
      poses_[hand] = dynamics::led_on_pose(tools_[hand].path, tick, tools_[hand].led_on_ticks);
    return poses_;
  }
  /// Moves the copies on to a tick. The next one moves by a few ticks at most. step(copy) steps a
  /// copy by a tick. before_swap() precedes a swap of both.
  template <class Step, class BeforeSwap>
  Advance advance(std::uint64_t tick, const Step& step, const BeforeSwap& before_swap);

 private:
  struct Tool {
    dynamics::TickPath path;
    std::uint64_t led_on_ticks = 0;
  };
  [[nodiscard]] std::uint64_t known() const noexcept {
    return tools_[own_hand_].path.newest().value_or(0);
  }

  std::array<Copy, 2> copies_;
  std::size_t shown_ = 0;    // its index
  std::vector<Tool> tools_;  // one a hand
  std::size_t own_hand_;
  std::vector<std::optional<dynamics::ToolPose>> poses_;  // in a tick, by hand
};

template <class Copy>
template <class Step, class BeforeSwap>
Advance SceneCopies<Copy>::advance(std::uint64_t tick, const Step& step,
                                   const BeforeSwap& before_swap) {
  // A copy that is a second behind is there in half a second.
  constexpr int kCatchUpTicks = 3;
  constexpr std::uint64_t kMaxTicks = 8;  // missed ones that are made up for in one
  Advance advance;
  const auto step_by_one = [&](Copy& copy) {
    step(copy);
    ++advance.ticks;
  };
  // Behind its newest point the own path is not known yet.
  const std::uint64_t end = std::min(tick, known());
  // One that is too far behind waits for a state that is nearer.
  if (shown().tick + kMaxTicks < end) shown().is_begun = false;
  while (shown().is_begun && shown().tick < end) step_by_one(shown());
  for (int k = 0; next().is_begun && next().tick < end && k < kCatchUpTicks; ++k)
    step_by_one(next());
  if (next().is_begun && next().tick >= end) {
    before_swap();
    shown().is_begun = false;
    shown_ = 1 - shown_;
    advance.is_swap = true;
  }
  shown().is_begun = shown().is_begun && shown().is_plausible();
  advance.is_known = shown().is_begun && shown().tick == tick;
  return advance;
}

}  // namespace stillgrid::local
