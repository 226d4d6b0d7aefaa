#include "sim_server/fields/mesh_field.hpp"

#include "sim_server/mesh/mesh_distance.hpp"

namespace stillgrid::fields {

collision::DistanceField make_mesh_field(const mesh::TriangleMesh& closed,
                                         const collision::FieldFineness& fineness) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex_m : closed.vertices_m) box.extend(vertex_m);
  const mesh::MeshDistance distance(closed);
  return collision::make_field(box, fineness, [&](const Eigen::Vector3d& point_m) {
    return distance.signed_distance_m(point_m);
  });
}

}  // namespace stillgrid::fields
