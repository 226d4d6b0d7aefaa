#pragma once

#include <Eigen/Core>

#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_layout.hpp"

namespace stillgrid::dynamics {

/// Sets the forces of the sheet's nodes. Returns the power that dampers take, W.
double pull_sheet(SpringSheet& sheet, const SpringNodes& nodes);

/// The sheet takes its nodes from the state, to move them by itself until it gives them back.
void take_nodes(const ExplicitState& state, SpringSheet& sheet);
void give_nodes(SpringSheet& sheet, ExplicitState& state);

/// Moves the nodes that the sheet took: what pull_sheet() and move_nodes() do, to the bit, in one
/// pass over them. Returns the power that dampers take, W.
double move_sheet(SpringSheet& sheet, const Move& move, const Eigen::Vector3d& gravity_m_s2);

}  // namespace stillgrid::dynamics
