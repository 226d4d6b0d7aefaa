#pragma once

#include <cstdint>
#include <vector>

#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/work_sharing.hpp"

namespace stillgrid::dynamics {

/// Contacts are soft constraints with a warm start. A contact has the stiffness and damping of its
/// materials. Its force is the mean of the contact law over a substep, to second order. Contacts
/// of many bodies are solved by Gauss-Seidel; those of nodes, and of few rigid bodies that have
/// many, by Jacobi with shares of mass. Friction is a spring that holds the points of contact and
/// slides at Coulomb's limit.
///
/// A substep calls prepare_rows() at its middle with the velocities of its start. It adds all other
/// forces to the velocities. Then it calls warm_start_rows(), solve_rows() for each iteration, and
/// finish_rows(). All functions are deterministic to the bit, on every instruction
/// set. Realtime: yes, if LiveRows has the capacity of the list.
///
/// Source: Macklin et al., Small Steps in Physics Simulation, SCA 2019; Catto, Solver2D, 2024.

/// Rows of a group that may touch within the substep; indices are into RowList::rows.
struct LiveRows {
  float substep_s = 0.0F;
  ContactRates rates;  // largest of contacts that are not of balls
  const WorkSharing* sharing = &WorkSharing::alone();
  std::vector<std::uint8_t> is_live;  // all rows of the list
  std::vector<std::uint32_t> rows;
  std::vector<std::size_t> group_end;  // one for each of RowList::groups
};

/// Computes geometry and effective masses of all rows that may touch, and lists these.
void prepare_rows(RowList& list, ContactBodies& bodies, float substep_s, LiveRows& live);
/// Applies the impulses of the last substep.
void warm_start_rows(RowList& list, ContactBodies& bodies, const LiveRows& live);
/// Iterates once over the live rows that have as many iterations; see RowGroup.
void solve_rows(RowList& list, ContactBodies& bodies, const LiveRows& live, int iteration);
/// Stretches the springs that friction holds.
void finish_rows(RowList& list, float substep_s, const LiveRows& live);

}  // namespace stillgrid::dynamics
