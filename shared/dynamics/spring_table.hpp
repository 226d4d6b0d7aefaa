#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Springs with dampers between nodes, in arrays for vectors.
class SpringTable {
 public:
  explicit SpringTable(const Description& description);

  /// Leaves out springs whose first node sleeps. Realtime: yes.
  void leave_out(std::span<const std::uint8_t> sleeping_nodes);

  /// Adds the forces of all springs and their dampers to forces_N, in the order of nodes.
  /// Deterministic to the bit on every instruction set. Realtime: never allocates, locks or throws.
  void add_forces(std::span<const Vector4> position_m, std::span<const Vector4> velocity_m_s,
                  std::span<Vector4> forces_N) const;

  /// Arrays of springs, padded to whole vectors by springs of no stiffness.
  struct Arrays {
    std::vector<std::int32_t> a, b;
    std::vector<double> rest_m, stiffness_N_per_m, damping_N_s_per_m;
  };

 private:
  Arrays all_, arrays_;
  std::size_t used_;  // springs in arrays_
};

}  // namespace stillgrid::dynamics
