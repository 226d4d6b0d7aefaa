#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/conjugate_gradients.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/implicit_coupling.hpp"

namespace stillgrid::dynamics {

/// Springs and dampers along lines between nodes in an implicit step, also joints of a rest length.
/// The force acts along the line at the end, and depends on its length there and on the change over
/// the step. It is the derivative of a potential. A damper on the velocity along a line would
/// stretch a spring that turns, and so gain energy.
///
/// Thread: one. Memory is allocated by the constructor.
class ImplicitSprings {
 public:
  explicit ImplicitSprings(const Description& description);

  /// Leaves out springs of nodes that sleep.
  void leave_out(std::span<const std::uint8_t> sleeping_nodes);
  void start(std::span<const Vector4> positions_m);
  /// Adds the impulses of a step that ends at positions_m, and stores how they change.
  void add_impulses(std::span<const Vector4> positions_m, double step_s, Motions& impulses);
  /// Adds the decrease of impulses by these velocities.
  void multiply(const Motions& velocities, Motions& sums) const;
  void add_blocks(MassBlocks& blocks) const;
  /// Returns the losses by dampers in a step that ends at positions_m.
  [[nodiscard]] double damping_J(std::span<const Vector4> positions_m, double step_s) const;

 private:
  struct Spring {
    std::int32_t a, b;
    double rest_m, stiffness_N_per_m, damping_N_s_per_m;
    Vector4 line_m;      // a to b at the start; w: its length
    Vector4 along_root;  // its outer product and w times the identity are the slope in kg
  };
  std::vector<Spring> all_, springs_;  // springs_: those that are awake
};

}  // namespace stillgrid::dynamics
