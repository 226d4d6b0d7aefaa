#include "sim_server/fields/mesh_field.hpp"

#include <algorithm>

#include "sim_server/fields/stiffness_map.hpp"
#include "sim_server/mesh/mesh_distance.hpp"

namespace stillgrid::fields {

collision::DistanceField make_mesh_field(const mesh::TriangleMesh& closed,
                                         const collision::FieldFineness& fineness,
                                         const MeasuredSurface& measured) {
  const Eigen::AlignedBox3d box = mesh::box_of(closed);
  const Eigen::Vector3d grown_m = Eigen::Vector3d::Constant(std::max(measured.offset_m, 0.0));
  const Eigen::AlignedBox3d solid_m(box.min() - grown_m, box.max() + grown_m);
  const mesh::MeshDistance distance(closed);
  collision::ScalarField stiffness_scale;
  if (!measured.places.empty())
    stiffness_scale = [map = StiffnessMap(measured.places, measured.own_N_per_m),
                       own_N_per_m = measured.own_N_per_m,
                       &distance](const Eigen::Vector3d& point_m) {
      return map.stiffness_N_per_m(distance.closest(point_m).point_m) / own_N_per_m;
    };
  const auto distance_m = [&](const Eigen::Vector3d& point_m) {
    return distance.signed_distance_m(point_m) - measured.offset_m;
  };
  return collision::make_field(solid_m, fineness, distance_m, stiffness_scale);
}

}  // namespace stillgrid::fields
