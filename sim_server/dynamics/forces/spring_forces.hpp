#pragma once

#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_layout.hpp"

namespace stillgrid::dynamics {

/// The forces of all springs of the bodies that are awake, with vector instructions.
///
/// Of a regular sheet, whose springs of one kind are all alike, they are a stencil over rows of
/// nodes; others are taken in groups. Each spring is computed once. 1 / length is an estimate made
/// better by a series: exact to 1e-13 (docs/algorithms/explicit_step.md).
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

  /// Where nothing but springs and gravity acts: sheets take their nodes out of the state, move()
  /// moves all nodes, those of the state and those taken, and sheets give theirs back.
  void take(const bodies::World& world, const ExplicitState& state);
  /// As evaluate() and move_nodes() do, to the bit. Returns the power that dampers take, W.
  double move(const bodies::World& world, const Move& move, ExplicitState& state);
  void give(const bodies::World& world, ExplicitState& state);

 private:
  double pull_groups(const bodies::World& world, const SpringNodes& nodes);

  std::vector<SpringSheet> sheets_;
  std::vector<SpringGroup> groups_;
  std::vector<NodeRange> in_groups_;  // nodes of groups
};

/// v += kick (f / m + g), then x += drift v; where 1 / m is zero neither changes. Where drift is
/// zero positions are not looked at, where kick is zero forces are not.
void move_nodes(const Move& move, const Eigen::Vector3d& gravity_m_s2, ExplicitState& state);

}  // namespace stillgrid::dynamics
