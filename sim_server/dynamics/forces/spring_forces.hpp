#pragma once

#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_layout.hpp"

namespace stillgrid::dynamics {

/// The forces of all springs of the bodies that are awake, with vector instructions.
///
/// Of a regular sheet, whose springs of one kind are all alike, they are a stencil over rows of
/// nodes; others are taken in groups. Each spring is computed once. 1 / length is a float estimate
/// made better by a series: exact to 1e-13 (docs/algorithms/explicit_step.md).
///
/// Sums are in a fixed order: on one machine results repeat to the bit.
class SpringForces {
 public:
  /// Takes springs and bodies as they are.
  explicit SpringForces(const bodies::World& world);

  /// Sets force_N of every node of the bodies that are awake; of others it is not touched. Returns
  /// the power that dampers take, W. Never allocates. Pre: the world's bodies are the
  /// constructor's.
  double evaluate(const bodies::World& world, ExplicitState& state);

 private:
  std::vector<SpringSheet> sheets_;
  std::vector<SpringGroup> groups_;
};

/// v += kick (f / m + g), then x += drift v; where 1 / m is zero neither changes.
void move_nodes(const Move& move, const Eigen::Vector3d& gravity_m_s2, ExplicitState& state);

}  // namespace stillgrid::dynamics
