#include "sim_server/bodies/kinds/mesh.hpp"

#include <algorithm>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {

BodyCounts counts_of(const RigidMeshBody& mesh) {
  BodyCounts counts{.spheres = static_cast<double>(mesh.balls.size())};
  if (mesh.field) counts.field_bytes = static_cast<double>(mesh.field->bytes());
  return counts;
}

BodyCounts counts_of(const SoftMeshBody& mesh) {
  return counts_of_solid(static_cast<double>(mesh.balls.size()), mesh.lattice, mesh.springs);
}

SpringNet net_of(const SoftMeshBody& mesh, const BodyDescription& body) {
  return net_of_solid(mesh.lattice, mesh.springs, body.position_m, body.orientation);
}

RigidShape rigid_shape(const RigidMeshBody& mesh, double mass_kg) {
  RigidShape shape{.inertia_kg_m2 = mass_kg * mesh.inertia_per_kg_m2};
  for (const spheres::Ball& ball : mesh.balls)
    shape.bounding_radius_m =
        std::max(shape.bounding_radius_m, ball.centre_m.norm() + ball.radius_m);
  if (!mesh.field) return shape;
  for (const Eigen::Vector3d& vertex_m : mesh.surface.vertices_m)
    shape.bounding_radius_m = std::max(shape.bounding_radius_m, vertex_m.norm());
  return shape;
}

std::vector<SphereBinding> spheres_of(const RigidMeshBody& mesh, const BodyDescription& body) {
  std::vector<SphereBinding> spheres = fixed_spheres(mesh.balls, body.position_m, body.orientation);
  for (SphereBinding& sphere : spheres) sphere.is_field_point = mesh.field != nullptr;
  return spheres;
}

std::vector<SphereBinding> spheres_of(const SoftMeshBody& mesh, const BodyDescription& body) {
  return spheres_in_solid(mesh.balls, mesh.lattice, mesh.springs, body.position_m,
                          body.orientation);
}

BodySurface surface_of(const RigidMeshBody& mesh, const BodyDescription& body,
                       const RestSpheres& spheres) {
  if (mesh.field && body.motion == Motion::kStatic)
    return still_surface(mesh.surface, body.position_m, body.orientation);
  return bound_surface(mesh.surface, body.position_m, body.orientation, spheres);
}

BodySurface surface_of(const SoftMeshBody& mesh, const BodyDescription& body,
                       const RestSpheres& spheres) {
  return bound_surface(mesh.surface, body.position_m, body.orientation, spheres);
}

}  // namespace stillgrid::bodies
