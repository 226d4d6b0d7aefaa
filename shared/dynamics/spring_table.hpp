#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/work_sharing.hpp"

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
                  std::span<Vector4> forces_N, const WorkSharing& sharing = WorkSharing::alone());

  /// Arrays of springs, padded to whole vectors by springs of no stiffness.
  struct Arrays {
    std::vector<std::int32_t> a, b;
    std::vector<double> rest_m, stiffness_N_per_m, damping_N_s_per_m;
  };
  /// Springs of a node in the list of ends: those that begin at it, then those that end at it.
  struct NodeEnds {
    std::int32_t node;
    std::uint32_t first, first_ending, end;
  };

 private:
  void list_ends();

  Arrays all_, arrays_;
  std::vector<NodeEnds> nodes_;         // nodes with springs
  std::vector<std::uint32_t> ends_;     // springs
  std::vector<std::uint32_t> next_[2];  // nodes: scratch of list_ends()
  std::vector<Vector4> pulls_N_;        // springs: forces on their first nodes
  std::size_t used_;                    // springs in arrays_
};

}  // namespace stillgrid::dynamics
