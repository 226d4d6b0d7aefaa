#include "sim_server/bodies/kinds/compound.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

using Kind = SolidShape::Kind;

constexpr std::size_t kMaxShapes = 64;

/// Half of the sides along the own axes.
Eigen::Vector3d read_half_m(toml::TableReader& table, Kind kind) {
  if (kind == Kind::kBox) return 0.5 * table.vector("size_m", toml::Bound::kPositive);
  const double radius_m = table.number("radius_m", toml::Bound::kPositive);
  if (kind == Kind::kSphere) return Eigen::Vector3d::Constant(radius_m);
  const double half_length_m = 0.5 * table.number("length_m", toml::Bound::kPositive);
  if (kind == Kind::kCapsule && half_length_m < radius_m)
    table.refuse("length_m", "at least twice radius_m: round ends included");
  return {radius_m, radius_m, half_length_m};
}

SolidShape read_shape(toml::TableReader& table) {
  constexpr std::array<std::string_view, 4> kNames = {"box", "sphere", "capsule", "cylinder"};
  constexpr std::array kKinds = {Kind::kBox, Kind::kSphere, Kind::kCapsule, Kind::kCylinder};
  SolidShape shape;
  shape.kind = kKinds[table.choice("kind", kNames)];
  shape.half_m = read_half_m(table, shape.kind);
  shape.position_m = table.vector_or("position_m", shape.position_m);
  shape.orientation = table.orientation_or_identity("orientation_xyzw");
  table.finish();
  return shape;
}

/// The axes of the frame if an inertia is diagonal there, else its principal ones.
Eigen::Matrix3d diagonal_axes(const Eigen::Matrix3d& inertia) {
  constexpr double kRounding = 1e-12;  // of the trace
  const Eigen::Matrix3d diagonal = inertia.diagonal().asDiagonal();
  if ((inertia - diagonal).norm() <= kRounding * inertia.trace())
    return Eigen::Matrix3d::Identity();
  return principal_axes(inertia).axes;
}

}  // namespace

void read_compound(toml::TableReader& table, BodyDescription& body,
                   std::vector<std::string>& /*notes*/) {
  body.position_m = table.vector_or("position_m", body.position_m);
  body.orientation = table.orientation_or_identity("orientation_xyzw");
  std::vector<SolidShape> shapes;
  for (toml::TableReader& shape : table.tables("shape")) shapes.push_back(read_shape(shape));
  if (shapes.empty() || shapes.size() > kMaxShapes)
    table.refuse("shape", "1 to " + std::to_string(kMaxShapes) + " tables [[body.shape]]");
  body.shape = compound_of(std::move(shapes), body);
}

CompoundBody compound_of(std::vector<SolidShape> shapes, BodyDescription& body) {
  const mesh::MassProperties mass = mass_properties(shapes);
  const Eigen::Matrix3d axes = diagonal_axes(mass.inertia_per_kg_m2);
  const Eigen::Quaterniond turn(axes);
  for (SolidShape& shape : shapes) {
    shape.position_m = axes.transpose() * (shape.position_m - mass.centre_m);
    shape.orientation = turn.conjugate() * shape.orientation;
  }
  body.position_m += body.orientation * mass.centre_m;
  body.orientation = body.orientation * turn;
  return {std::move(shapes), (axes.transpose() * mass.inertia_per_kg_m2 * axes).diagonal()};
}

BodyCounts counts_of(const CompoundBody& compound) {
  BodyCounts counts;
  for (const SolidShape& shape : compound.shapes)
    counts.spheres += static_cast<double>(contact_balls(shape).size());
  return counts;
}

RigidShape rigid_shape(const CompoundBody& compound, double mass_kg) {
  RigidShape rigid{.inertia_kg_m2 = mass_kg * compound.inertia_per_kg_m2};
  for (const SolidShape& shape : compound.shapes)
    rigid.bounding_radius_m = std::max(rigid.bounding_radius_m, bounding_radius_m(shape));
  return rigid;
}

std::vector<SphereBinding> spheres_of(const CompoundBody& compound, const BodyDescription& body) {
  std::vector<SphereBinding> spheres;
  for (const SolidShape& shape : compound.shapes) {
    std::vector<spheres::Ball> balls = contact_balls(shape);
    const bool is_sphere = shape.kind == Kind::kSphere;
    if (!is_sphere)
      std::erase_if(balls, [&](const spheres::Ball& ball) {
        return std::ranges::any_of(compound.shapes,
                                   [&](const SolidShape& other) { return hides(other, ball); });
      });
    for (SphereBinding& sphere : fixed_spheres(balls, body.position_m, body.orientation)) {
      sphere.is_field_point = !is_sphere;
      spheres.push_back(sphere);
    }
  }
  return spheres;
}

BodySurface surface_of(const CompoundBody& compound, const BodyDescription& body,
                       const RestSpheres& spheres) {
  mesh::TriangleMesh mesh;
  for (const SolidShape& shape : compound.shapes) add_surface(shape, mesh);
  return body.motion == Motion::kStatic
             ? still_surface(mesh, body.position_m, body.orientation)
             : bound_surface(mesh, body.position_m, body.orientation, spheres);
}

}  // namespace stillgrid::bodies
