#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/dynamics/scene_model.hpp"
#include "shared/dynamics/scene_ticks.hpp"
#include "shared/dynamics/tool_path.hpp"

namespace stillgrid::local {

/// A copy of a simulated scene that goes on from its snapshots, tick by tick, along the path that
/// the tool takes (docs/algorithms/local.md).
///
/// Both processes step the same model from the same state along the same path, so they come to the
/// same states, to the bit. A snapshot whose state the copy has had at that tick confirms it.
/// Another one is loaded into a second copy, which catches up and then takes the first one's place.
///
/// Thread: one. Realtime: confirmed snapshots and ticks, as Engine::step(); loading another state
/// allocates.
class LocalScene {
 public:
  /// Decodes a model with the distances of its fields; see dynamics::decode(). Throws
  /// std::invalid_argument where it is not sound, or has another number of hands than one.
  LocalScene(std::span<const std::byte> model,
             std::span<const std::shared_ptr<const collision::DistanceField>> distances);

  /// Adds where the tool is at a tick. Pre: later than the last.
  void add_to_path(const dynamics::PathPose& pose) noexcept { path_.add(pose); }

  /// Whether the copy had this state at that tick. Then nothing is to be done.
  [[nodiscard]] bool confirms(std::uint64_t tick, std::uint64_t hash) const noexcept;
  /// Begins a second copy from the state that a snapshot has of that tick. Returns whether the
  /// state is one of this model.
  bool begin_at(std::uint64_t tick, std::span<const std::byte> state);

  /// Moves the copies on to a tick, the second one by a few ticks at most. Returns whether the
  /// scene is known there.
  bool advance_to(std::uint64_t tick);

  /// Whether a copy has caught up at all.
  [[nodiscard]] bool is_begun() const noexcept { return shown_->is_begun; }
  /// The scene at the tick of the last advance_to(). Pre: it returned true.
  [[nodiscard]] const dynamics::SceneState& state() const noexcept {
    return shown_->ticks.engine().state();
  }
  [[nodiscard]] const dynamics::Description& description() const noexcept {
    return copies_[0].ticks.engine().description();
  }
  /// Ticks that the second copy took in the last advance_to().
  [[nodiscard]] int caught_up() const noexcept { return caught_up_; }

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
  explicit LocalScene(const dynamics::SceneModel& model);
  [[nodiscard]] Copy& other() noexcept { return copies_[shown_ == &copies_[0] ? 1 : 0]; }
  [[nodiscard]] const Copy& other() const noexcept {
    return copies_[shown_ == &copies_[0] ? 1 : 0];
  }
  void step(Copy& copy);
  void note(const Copy& copy) noexcept;

  static constexpr std::size_t kPassed = 4096;
  std::array<Copy, 2> copies_;
  Copy* shown_ = &copies_[0];
  dynamics::TickPath path_;
  std::vector<Passed> passed_;  // states of the copies, by tick modulo kPassed
  int caught_up_ = 0;
};

}  // namespace stillgrid::local
