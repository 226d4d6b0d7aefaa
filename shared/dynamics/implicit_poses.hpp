#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "shared/dynamics/conjugate_gradients.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Positions at the end of an implicit step for trial velocities. Every position moves by its
/// velocity at the end: x1 = x0 + h v1, and orientations by rotation_by(h w1).
///
/// Thread: one. Memory is allocated by the constructor.
class ImplicitPoses {
 public:
  explicit ImplicitPoses(const Description& description);

  /// Begins a step of step_s. The state must not change until the step ends.
  void start(const SceneState& state, double step_s);
  /// Moves all that is awake to the end by trial velocities; driven bodies and pinned nodes too.
  void move(const Motions& velocities, const AwakeRuns& awake);

  [[nodiscard]] std::size_t centre(std::size_t rigid) const { return nodes_ + rigid; }
  [[nodiscard]] std::size_t spin(std::size_t rigid) const { return nodes_ + turns_.size() + rigid; }
  [[nodiscard]] double step_s() const { return step_s_; }
  [[nodiscard]] const SceneState& from() const { return *from_; }
  /// Positions and orientations at the end. Velocities are not set.
  [[nodiscard]] const SceneState& to() const { return to_; }

  /// Vectors to a point of a rigid body from its centre, at the start and the end.
  [[nodiscard]] Eigen::Vector3d arm_before_m(std::size_t rigid,
                                             const Eigen::Vector3d& local) const {
    return turns_[rigid].start * local;
  }
  [[nodiscard]] Eigen::Vector3d arm_m(std::size_t rigid, const Eigen::Vector3d& local) const {
    return turns_[rigid].end * local;
  }
  /// The arm r with h (w1 x r) = the change of the arm over the step. Moments about it do exactly
  /// the work of their forces.
  [[nodiscard]] Eigen::Vector3d mean_arm_m(std::size_t rigid, const Eigen::Vector3d& local) const {
    return turns_[rigid].mean * local;
  }
  /// Centres of a sphere at the start and the end.
  [[nodiscard]] Eigen::Vector3d before_m(const Description::Sphere& sphere) const;
  [[nodiscard]] Eigen::Vector3d after_m(const Description::Sphere& sphere) const;

 private:
  struct Turn {
    Eigen::Matrix3d start, end, mean;
  };
  void move_body(std::size_t rigid, const Motions& velocities);

  std::size_t nodes_;
  const SceneState* from_ = nullptr;
  SceneState to_;
  double step_s_ = 0.0;
  std::vector<Turn> turns_;
};

}  // namespace stillgrid::dynamics
