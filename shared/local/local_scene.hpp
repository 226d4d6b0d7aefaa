#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/dynamics/scene_model.hpp"
#include "shared/dynamics/scene_ticks.hpp"
#include "shared/local/scene_copies.hpp"

namespace stillgrid::local {

/// A copy that is stepped as the simulation steps its scene.
struct SimulatedCopy {
  explicit SimulatedCopy(const dynamics::SceneModel& model) : ticks(model) {}
  [[nodiscard]] bool is_plausible() const noexcept;
  dynamics::SceneTicks ticks;
  std::uint64_t tick = 0;
  bool is_begun = false;
};

/// A copy of a simulated scene. It goes on from the snapshots along the paths that the tools take.
/// See docs/algorithms/local.md.
///
/// Both processes step the same model from the same state along the same path, so they come to the
/// same states, to the bit. A snapshot whose state the copy has had at that tick confirms it.
/// Another one is loaded into a second copy, which catches up and then takes the first one's place.
/// A copy that led another hand's tool on to a wrong place is replaced in this way.
///
/// Thread: one. Realtime: as SceneTicks.
class LocalScene : public SceneCopies<SimulatedCopy> {
 public:
  /// Decodes a model of a session's hands, of which this process has one, with the distances of its
  /// fields; see dynamics::decode(). Throws std::invalid_argument where it is not sound, has
  /// another number of hands, or takes too long a tick.
  LocalScene(std::span<const std::byte> model,
             std::span<const std::shared_ptr<const collision::DistanceField>> distances,
             std::size_t hands, std::size_t own_hand);

  /// Whether the copy had this state at that tick: the snapshot confirms it.
  [[nodiscard]] bool confirms(std::uint64_t tick, std::uint64_t hash) const noexcept;
  /// Ends both copies: a snapshot came without a state.
  void end() noexcept { shown().is_begun = next().is_begun = false; }
  /// Begins a second copy from the state that a snapshot has of that tick. Returns whether the
  /// state is one of this model.
  bool begin_at(std::uint64_t tick, std::span<const std::byte> state);

  /// Moves the copies on to a tick, the second one by a few ticks at most.
  Advance advance_to(std::uint64_t tick);

  /// The scene at the tick of the last advance_to(). Pre: it was known there.
  [[nodiscard]] const dynamics::SceneState& state() const noexcept {
    return shown().ticks.engine().state();
  }
  [[nodiscard]] const dynamics::Description& description() const noexcept {
    return shown().ticks.engine().description();
  }
  /// See SceneTicks::proxies_m() and stretches_m().
  [[nodiscard]] std::span<const dynamics::Vector4> own_proxies_m() const noexcept {
    return shown().ticks.proxies_m(own_hand());
  }
  [[nodiscard]] std::span<const dynamics::Vector4> own_stretches_m() const noexcept {
    return shown().ticks.stretches_m(own_hand());
  }

 private:
  struct Passed {
    std::uint64_t tick = UINT64_MAX, hash = 0;
  };
  LocalScene(const dynamics::SceneModel& model, std::size_t own_hand);
  void step(SimulatedCopy& copy);
  void note(const SimulatedCopy& copy) noexcept;

  static constexpr std::size_t kPassed = 4096;
  std::vector<Passed> passed_;  // states of the copies, by tick modulo kPassed
};

}  // namespace stillgrid::local
