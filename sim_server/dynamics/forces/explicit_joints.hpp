#pragma once

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_spectrum.hpp"

namespace stillgrid::dynamics {

/// What joints take from the world by dampers, and are given by what is led, W.
struct JointPower {
  double damping_W = 0.0, given_W = 0.0;
};
/// Adds the forces of joints where the state is to what it has of forces.
JointPower pull_joints(const bodies::World& world, ExplicitState& state);

/// Upper bounds of the largest eigenvalues of joints alone, by rows of what each makes of all,
/// where the world is and for a time on: a joint that is long has a longer lever, and a stiffness
/// against turning. Of joints together with springs the sums are.
[[nodiscard]] SpringRates joint_rates(const bodies::World& world, double within_s);

}  // namespace stillgrid::dynamics
