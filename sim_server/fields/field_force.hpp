#pragma once

#include "shared/collision/distance_field.hpp"

namespace stillgrid::fields {

/// The force of a field on a tool sphere, still, for a contact stiffness of 1 N/m. In N for each
/// N/m, that is in metres; body's own frame.
[[nodiscard]] Eigen::Vector3d unit_force_m(const collision::FieldView& field,
                                           const Eigen::Vector3d& tool_m, double tool_radius_m);

}  // namespace stillgrid::fields
