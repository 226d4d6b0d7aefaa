#include "sim_server/fields/field_force.hpp"

namespace stillgrid::fields {

Eigen::Vector3d unit_force_m(const collision::FieldView& field, const Eigen::Vector3d& tool_m,
                             double tool_radius_m) {
  const auto contact = collision::field_contact(field, tool_m, tool_radius_m);
  if (!contact || contact->depth_m <= 0.0) return Eigen::Vector3d::Zero();
  return contact->stiffness_scale * contact->depth_m * contact->normal;
}

}  // namespace stillgrid::fields
