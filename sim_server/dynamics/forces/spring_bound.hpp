#pragma once

#include "sim_server/bodies/world.hpp"

namespace stillgrid::dynamics {

/// Largest eigenvalues of M^-1 K (1/s2) and of M^-1 C (1/s), or bounds of them.
struct SpringRates {
  double stiffness_per_s2 = 0.0;
  double damping_per_s = 0.0;
};

/// Returns upper bounds for the springs of all nodes that have an unknown, in every shape that the
/// bodies can have. A spring never resists more, in any direction, than by its stiffness. It
/// resists by all of it along its line, and by its tension over its length across. For each node
/// the bound sums k (1 / m_a + 1 / m_b) over its springs; the largest sum bounds the eigenvalue.
[[nodiscard]] SpringRates bound_springs(const bodies::World& world);

/// Returns how many substeps a second explicit integrators make for springs of these rates. They
/// are twice as many as are stable; the limit is h^2 k + 2 h c = 4.
[[nodiscard]] double substeps_per_s(const SpringRates& rates);

/// Largest h^2 omega^2 / 2 of a substep's contacts. An undamped bounce gains energy beyond it.
inline constexpr double kContactRatio = 1.0 / 16.0;

/// Returns how many substeps a second keep to kContactRatio; rate_per_s2: omega^2 / 2 of the
/// stiffest contact.
[[nodiscard]] double contact_substeps_per_s(double rate_per_s2);

}  // namespace stillgrid::dynamics
