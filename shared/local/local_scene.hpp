#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "shared/dynamics/scene_model.hpp"
#include "shared/dynamics/scene_ticks.hpp"
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

/// A copy of a simulated scene. It goes on from the snapshots along the paths that the tools take.
/// See docs/algorithms/local.md.
///
/// Both processes step the same model from the same state along the same path, so they come to the
/// same states, to the bit. A snapshot whose state the copy has had at that tick confirms it.
/// Another one is loaded into a second copy, which catches up and then takes the first one's place.
/// A copy that led another hand's tool on to a wrong place is replaced in this way.
///
/// Thread: one. Realtime: confirmed snapshots and ticks, as Engine::step(); loading another state
/// allocates.
class LocalScene {
 public:
  /// Decodes a model of a session's hands, of which this process has one, with the distances of its
  /// fields; see dynamics::decode(). Throws std::invalid_argument where it is not sound, has
  /// another number of hands, or takes too long a tick.
  LocalScene(std::span<const std::byte> model,
             std::span<const std::shared_ptr<const collision::DistanceField>> distances,
             std::size_t hands, std::size_t own_hand);

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

  /// Whether the copy had this state at that tick: the snapshot confirms it.
  [[nodiscard]] bool confirms(std::uint64_t tick, std::uint64_t hash) const noexcept;
  /// Ends both copies: a snapshot came without a state.
  void end() noexcept { copies_[0].is_begun = copies_[1].is_begun = false; }
  /// Begins a second copy from the state that a snapshot has of that tick. Returns whether the
  /// state is one of this model.
  bool begin_at(std::uint64_t tick, std::span<const std::byte> state);

  /// Moves the copies on to a tick, the second one by a few ticks at most.
  Advance advance_to(std::uint64_t tick);

  /// The scene at the tick of the last advance_to(). Pre: it was known there.
  [[nodiscard]] const dynamics::SceneState& state() const noexcept {
    return shown_->ticks.engine().state();
  }
  [[nodiscard]] const dynamics::Description& description() const noexcept {
    return copies_[0].ticks.engine().description();
  }

 private:
  struct Copy {
    explicit Copy(const dynamics::SceneModel& model) : ticks(model) {}
    dynamics::SceneTicks ticks;
    std::uint64_t tick = 0;
    bool is_begun = false;
  };
  struct Passed {
    std::uint64_t tick = UINT64_MAX, hash = 0;
  };
  struct Tool {
    [[nodiscard]] std::optional<dynamics::ToolPose> pose_at(std::uint64_t tick) const noexcept;
    dynamics::TickPath path;
    std::uint64_t led_on_ticks = 0;
  };
  LocalScene(const dynamics::SceneModel& model, std::size_t own_hand);
  [[nodiscard]] Copy& other() noexcept { return copies_[shown_ == &copies_[0] ? 1 : 0]; }
  [[nodiscard]] const Copy& other() const noexcept {
    return copies_[shown_ == &copies_[0] ? 1 : 0];
  }
  void step(Copy& copy);
  void note(const Copy& copy) noexcept;

  static constexpr std::size_t kPassed = 4096;
  std::array<Copy, 2> copies_;
  Copy* shown_ = &copies_[0];
  std::vector<Tool> tools_;  // one a hand
  std::size_t own_hand_;
  std::vector<std::optional<dynamics::ToolPose>> poses_;  // in a tick, by hand
  std::vector<Passed> passed_;  // states of the copies, by tick modulo kPassed
};

}  // namespace stillgrid::local
