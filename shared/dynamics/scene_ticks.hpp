#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/scene_model.hpp"
#include "shared/dynamics/tool_path.hpp"

namespace stillgrid::dynamics {

/// A scene that both processes step tick by tick, with its prescribed bodies and along the paths of
/// its tools. Equal states and equal poses lead to equal states, to the
/// bit.
///
/// Thread: one. Realtime: step() as Engine::step().
class SceneTicks {
 public:
  /// Throws as Engine. method: of the model, or one that only this process has.
  SceneTicks(SceneModel model, double time_s, EngineMethod method);
  explicit SceneTicks(const SceneModel& model) : SceneTicks(model, 0.0, model.method()) {}

  /// How a tick is taken.
  struct Tick {
    double length_s = kTick_s;
    double left_s = kTick_s;  // this tick too: tools move evenly to their poses in it
    int substeps = 0;         // 0: as many as stability asks
    std::span<const std::optional<ToolPose>> tools = {};  // hands; a tool without a pose is away
  };
  void step(const Tick& tick);

  /// Writes all that later ticks depend on as one block, or continues from one to the bit; see
  /// Engine::save() and Engine::load().
  void save(std::vector<std::byte>& block) const;
  void load(std::span<const std::byte> block);
  /// Goes through a tick and back, so that later ticks and loads find their memory.
  void warm_up();

  [[nodiscard]] Engine& engine() noexcept { return *engine_; }
  [[nodiscard]] const Engine& engine() const noexcept { return *engine_; }
  [[nodiscard]] double time_s() const noexcept { return time_s_; }
  /// Returns the counted time of the last tick as if it had listed contacts anew, which one in some
  /// ticks does; see counted_tick_ns().
  [[nodiscard]] double counted_ns() const noexcept;
  /// Returns that of the next tick by small steps, as far as it is known before.
  [[nodiscard]] double next_counted_ns();
  void set_time(double time_s) noexcept { time_s_ = time_s; }
  void set_prescribed(std::size_t body, const PrescribedMotion& motion) {
    prescribed_[body] = motion;
  }
  [[nodiscard]] std::size_t hands() const noexcept { return hands_; }
  /// Number of a hand's tool among driven bodies, and among rigid bodies.
  [[nodiscard]] std::size_t driven_of_hand(std::size_t hand) const noexcept {
    return driven_.size() - hands_ + hand;
  }
  [[nodiscard]] std::size_t rigid_of_hand(std::size_t hand) const noexcept {
    return engine_->state().rigid_position_m.size() - hands_ + hand;
  }
  /// Returns the proxies of a hand's tool and their stretches of friction, by its spheres. See
  /// SceneState::proxy_m. Contact by penalty has no proxies.
  [[nodiscard]] std::span<const Vector4> proxies_m(std::size_t hand) const noexcept {
    return of_hand(engine_->state().proxy_m, hand);
  }
  [[nodiscard]] std::span<const Vector4> stretches_m(std::size_t hand) const noexcept {
    return of_hand(engine_->state().proxy_stretch_m, hand);
  }

 private:
  [[nodiscard]] std::span<const Vector4> of_hand(const std::vector<Vector4>& values,
                                                 std::size_t hand) const noexcept;
  [[nodiscard]] double counted_ns(double substeps, double products) const noexcept;
  void aim(const Tick& tick);
  void draw(double share, const SceneState& start);

  std::vector<PrescribedMotion> prescribed_;
  std::size_t hands_;
  TickCounts counts_;
  std::vector<DrivenPose> driven_;  // at the end of a tick
  double time_s_;
  std::unique_ptr<Engine> engine_;
};

}  // namespace stillgrid::dynamics
