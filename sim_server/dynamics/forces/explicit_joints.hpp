#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_bound.hpp"

namespace stillgrid::dynamics {

/// What joints take from the world by dampers, and are given by what is led, W.
struct JointPower {
  double damping_W = 0.0, given_W = 0.0;
};
/// Adds the forces of joints where the state is to what it has of forces.
JointPower pull_joints(const bodies::World& world, ExplicitState& state);

/// Bounds the largest eigenvalues of joints alone, by rows of what each makes of all; of joints
/// together with springs the sums are bounds.
class JointSpectrum {
 public:
  /// Of a world whose joints, masses and inertias stay.
  explicit JointSpectrum(const bodies::World& world);

  /// Upper bounds where the world is and for a time on: a joint that is long has a longer lever,
  /// and a stiffness against turning.
  [[nodiscard]] SpringRates bound(const bodies::World& world, double within_s);

 private:
  /// How easily the thing that an end holds gives way, by its mass and by turning.
  struct HeldEnd {
    std::size_t thing;  // a node, then a rigid body, last the world
    double by_mass_per_kg = 0.0, by_arm_per_kg = 0.0;
    double arm_m = 0.0, inertia_kg_m2 = std::numeric_limits<double>::infinity();
  };
  /// What one of a joint's two forces does: its own value c, and what the joint's length adds to
  /// the square of the arm at each end.
  struct Row {
    double value;
    std::array<double, 2> more_m2;
  };
  /// By all joints that hold a thing, of sqrt(c), and of sqrt(c t).
  struct Carried {
    double sum = 0.0, turning = 0.0;
  };

  [[nodiscard]] HeldEnd held_end(const bodies::World& world, const bodies::JointEnd& end) const;
  double largest_rate(std::span<const Row> rows);

  std::vector<std::array<HeldEnd, 2>> ends_;
  std::vector<Row> springs_, dampers_;
  std::vector<Carried> carried_;
};

}  // namespace stillgrid::dynamics
