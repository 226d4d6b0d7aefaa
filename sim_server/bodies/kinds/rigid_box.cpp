#include "sim_server/bodies/kinds/rigid_box.hpp"

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/bodies/solid_shape.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

SolidShape solid_of(const Eigen::Vector3d& size_m) {
  return {.kind = SolidShape::Kind::kBox, .half_m = 0.5 * size_m};
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
  const bool is_covered = table.has("spheres");
  const RigidBoxBody box = read_box(table, body);
  if (is_covered)
    body.shape = box;
  else
    body.shape = compound_of({solid_of(box.size_m)}, body);
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
  mesh::TriangleMesh mesh;
  add_surface(solid_of(box.size_m), mesh);
  return bound_surface(mesh, body.position_m, body.orientation, spheres);
}

}  // namespace stillgrid::bodies
