#include "sim_server/bodies/kinds/rigid_box.hpp"

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

/// In the body's frame; vertex x + 2 y + 4 z.
mesh::TriangleMesh box_mesh(const Eigen::Vector3d& size_m) {
  mesh::TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.vertices_m.emplace_back(((corner & 1) - 0.5) * size_m.x(),
                                 ((corner >> 1 & 1) - 0.5) * size_m.y(),
                                 ((corner >> 2) - 0.5) * size_m.z());
  add_quad(mesh, 0, 2, 3, 1);
  add_quad(mesh, 4, 5, 7, 6);
  add_quad(mesh, 0, 1, 5, 4);
  add_quad(mesh, 2, 6, 7, 3);
  add_quad(mesh, 0, 4, 6, 2);
  add_quad(mesh, 1, 3, 7, 5);
  return mesh;
}

}  // namespace

RigidBoxBody read_box(toml::TableReader& table, BodyDescription& body) {
  RigidBoxBody box;
  body.position_m = table.vector_or("position_m", body.position_m);
  body.orientation = table.orientation_or_identity("orientation_xyzw");
  box.size_m = table.vector("size_m", toml::Bound::kPositive);
  box.spheres = read_packing(table, box.size_m.maxCoeff());
  if (2.0 * box.spheres.radius_m > box.size_m.minCoeff()) {
    table.table("spheres").refuse("radius_m", "at most half of the box's shortest side");
  }
  box.spheres = completed_for_box(box.spheres, box.size_m);
  return box;
}

void read_rigid_box(toml::TableReader& table, BodyDescription& body,
                    std::vector<std::string>& /*notes*/) {
  body.shape = read_box(table, body);
}

BodyCounts counts_of(const RigidBoxBody& box) {
  return {.spheres = ball_count_of_box(box.size_m, box.spheres)};
}

RigidShape rigid_shape(const RigidBoxBody& box, double mass_kg) {
  const Eigen::Array3d squared_m2 = box.size_m.array().square();
  return {(mass_kg / 12.0 * (squared_m2.sum() - squared_m2)).matrix(), 0.5 * box.size_m.norm()};
}

std::vector<SphereBinding> spheres_of(const RigidBoxBody& box, const BodyDescription& body) {
  return fixed_spheres(balls_of_box(box.size_m, box.spheres), body.position_m, body.orientation);
}

BodySurface surface_of(const RigidBoxBody& box, const BodyDescription& body,
                       const RestSpheres& spheres) {
  return bound_surface(box_mesh(box.size_m), body.position_m, body.orientation, spheres);
}

}  // namespace stillgrid::bodies
