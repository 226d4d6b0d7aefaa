#include "sim_server/bodies/solid_shape.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "shared/collision/exact_shape.hpp"
#include "sim_server/bodies/surfaces.hpp"

namespace stillgrid::bodies {
namespace {

using Eigen::Vector3d;
using Kind = SolidShape::Kind;

constexpr double kSmall = 0.02;  // radius of a contact ball over the least side
constexpr int kRim = 16;         // balls on a rim, and corners of a drawn one
constexpr double kMaxOnAxis = 32.0;

/// Half of the length of the straight part of a capsule.
double straight_m(const Vector3d& half_m) {
  return half_m.z() - half_m.x();
}

double volume_m3(const SolidShape& shape) {
  constexpr double kPi = std::numbers::pi;
  const Vector3d& half_m = shape.half_m;
  const double radius_m = half_m.x(), disc_m2 = kPi * radius_m * radius_m;
  if (shape.kind == Kind::kBox) return 8.0 * half_m.prod();
  if (shape.kind == Kind::kCylinder) return 2.0 * disc_m2 * half_m.z();
  return 4.0 / 3.0 * disc_m2 * radius_m + 2.0 * disc_m2 * straight_m(half_m);
}

/// Moments about the centre along the own axes, for a mass of 1 kg.
Vector3d moments_per_kg_m2(const SolidShape& shape) {
  const Vector3d& half_m = shape.half_m;
  if (shape.kind == Kind::kBox) {
    const Eigen::Array3d squares = half_m.array().square() / 3.0;
    return (squares.sum() - squares).matrix();
  }
  const double r2 = half_m.x() * half_m.x();
  if (shape.kind == Kind::kCylinder) {
    const double across = r2 / 4.0 + half_m.z() * half_m.z() / 3.0;
    return {across, across, r2 / 2.0};
  }
  // A cylinder and the two halves of a ball, whose centres are 3/8 of the radius beyond its ends.
  const double a = straight_m(half_m), ball = 4.0 / 3.0 * half_m.x(), sum = ball + 2.0 * a;
  const double across = 2.0 * a / sum * (r2 / 4.0 + a * a / 3.0) +
                        ball / sum * (0.4 * r2 + a * a + 0.75 * a * half_m.x());
  return {across, across, (2.0 * a * r2 / 2.0 + ball * 0.4 * r2) / sum};
}

/// A corner of a box by its number, x + 2 y + 4 z.
Vector3d corner_of(const Vector3d& half_m, int corner) {
  return half_m.cwiseProduct(
      Vector3d((corner & 1) * 2 - 1, (corner & 2) - 1, (corner & 4) / 2 - 1));
}

/// A sphere is a capsule without a straight part.
proto::FieldKind field_kind(const SolidShape& shape) {
  if (shape.kind == Kind::kBox) return proto::FieldKind::kBox;
  return shape.kind == Kind::kCylinder ? proto::FieldKind::kCylinder : proto::FieldKind::kCapsule;
}

proto::FieldShape exact_of(const SolidShape& shape) {
  return collision::exact_shape(field_kind(shape), shape.half_m);
}

std::vector<spheres::Ball> balls_of_box(const Vector3d& half_m) {
  constexpr double kMaxOnEdges = 48.0;
  const double least_m = half_m.minCoeff(), radius_m = 2.0 * kSmall * least_m;
  const Vector3d inner_m = half_m.array() - radius_m;
  const double spacing_m = std::max(least_m, 8.0 * half_m.sum() / kMaxOnEdges);
  std::vector<spheres::Ball> balls;
  for (int corner = 0; corner < 8; ++corner)
    balls.push_back({corner_of(inner_m, corner), radius_m});
  for (int axis = 0; axis < 3; ++axis) {
    const double parts = std::ceil(2.0 * half_m[axis] / spacing_m - 1e-9);
    for (double part = 1.0; part < parts; part += 1.0)
      for (int corner = 0; corner < 8; ++corner) {
        if ((corner >> axis & 1) != 0) continue;
        Vector3d at_m = balls[static_cast<std::size_t>(corner)].centre_m;
        at_m[axis] *= 1.0 - 2.0 * part / parts;
        balls.push_back({at_m, radius_m});
      }
  }
  return balls;
}

/// Balls of the radius, at most that far apart if their number allows.
void add_along_axis(double radius_m, double straight_m, std::vector<spheres::Ball>& balls) {
  const double parts = std::min(kMaxOnAxis - 1.0, std::ceil(2.0 * straight_m / radius_m));
  for (double part = 0.0; part <= parts; part += 1.0)
    balls.push_back(
        {(parts > 0.0 ? 2.0 * part / parts - 1.0 : 0.0) * straight_m * Vector3d::UnitZ(),
         radius_m});
}

Vector3d on_circle(double radius_m, int corner) {
  const double turn_rad = 2.0 * std::numbers::pi * corner / kRim;
  return {radius_m * std::cos(turn_rad), radius_m * std::sin(turn_rad), 0.0};
}

std::vector<spheres::Ball> balls_of_cylinder(const Vector3d& half_m) {
  const double radius_m = 2.0 * kSmall * half_m.minCoeff();
  std::vector<spheres::Ball> balls;
  for (const double side : {-1.0, 1.0})
    for (int corner = 0; corner < kRim; ++corner)
      balls.push_back({on_circle(half_m.x() - radius_m, corner) +
                           side * (half_m.z() - radius_m) * Vector3d::UnitZ(),
                       radius_m});
  if (half_m.z() > half_m.x()) add_along_axis(half_m.x(), straight_m(half_m), balls);
  return balls;
}

/// Radius and height of the corners of half a section, from the lower end to the upper.
std::vector<std::array<double, 2>> section_m(const SolidShape& shape) {
  const double radius_m = shape.half_m.x(), top_m = shape.half_m.z();
  if (shape.kind == Kind::kCylinder)
    return {{0.0, -top_m}, {radius_m, -top_m}, {radius_m, top_m}, {0.0, top_m}};
  constexpr int kSteps = kRim / 4;
  std::vector<std::array<double, 2>> section;
  for (const int end : {-1, 1})
    for (int step = 0; step <= kSteps; ++step) {
      const double turn_rad = 0.5 * std::numbers::pi * (end < 0 ? step - kSteps : step) / kSteps;
      section.push_back({radius_m * std::cos(turn_rad),
                         end * straight_m(shape.half_m) + radius_m * std::sin(turn_rad)});
    }
  return section;
}

void add_turned(const SolidShape& shape, mesh::TriangleMesh& mesh) {
  const auto section = section_m(shape);
  const auto first = static_cast<int>(mesh.vertices_m.size());
  for (const auto& [radius_m, height_m] : section)
    for (int corner = 0; corner < kRim; ++corner)
      mesh.vertices_m.emplace_back(on_circle(radius_m, corner) + height_m * Vector3d::UnitZ());
  for (int ring = 0; ring + 1 < static_cast<int>(section.size()); ++ring)
    for (int corner = 0; corner < kRim; ++corner) {
      const int a = first + ring * kRim + corner, b = first + ring * kRim + (corner + 1) % kRim;
      add_quad(mesh, a, b, b + kRim, a + kRim);
    }
}

void add_box(const Vector3d& half_m, mesh::TriangleMesh& mesh) {
  const auto first = static_cast<int>(mesh.vertices_m.size());
  for (int corner = 0; corner < 8; ++corner) mesh.vertices_m.push_back(corner_of(half_m, corner));
  constexpr std::array<std::array<int, 4>, 6> kFaces = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : kFaces)
    add_quad(mesh, first + a, first + b, first + c, first + d);
}

}  // namespace

mesh::MassProperties mass_properties(std::span<const SolidShape> shapes) {
  mesh::MassProperties all;
  for (const SolidShape& shape : shapes) {
    all.volume_m3 += volume_m3(shape);
    all.centre_m += volume_m3(shape) * shape.position_m;
  }
  all.centre_m /= all.volume_m3;
  for (const SolidShape& shape : shapes) {
    const Eigen::Matrix3d axes = shape.orientation.toRotationMatrix();
    const Vector3d arm_m = shape.position_m - all.centre_m;
    all.inertia_per_kg_m2 +=
        volume_m3(shape) / all.volume_m3 *
        (axes * moments_per_kg_m2(shape).asDiagonal() * axes.transpose() +
         arm_m.squaredNorm() * Eigen::Matrix3d::Identity() - arm_m * arm_m.transpose());
  }
  return all;
}

PrincipalAxes principal_axes(const Eigen::Matrix3d& inertia) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  PrincipalAxes principal{solver.eigenvectors(), solver.eigenvalues()};
  if (principal.axes.determinant() < 0.0) principal.axes.col(0) = -principal.axes.col(0);
  return principal;
}

std::shared_ptr<const collision::DistanceField> field_of(const SolidShape& shape) {
  return std::make_shared<const collision::DistanceField>(exact_of(shape));
}

std::vector<spheres::Ball> contact_balls(const SolidShape& shape) {
  std::vector<spheres::Ball> balls;
  if (shape.kind == Kind::kBox)
    balls = balls_of_box(shape.half_m);
  else if (shape.kind == Kind::kCylinder)
    balls = balls_of_cylinder(shape.half_m);
  else
    add_along_axis(shape.half_m.x(), straight_m(shape.half_m), balls);
  for (spheres::Ball& ball : balls)
    ball.centre_m = shape.position_m + shape.orientation * ball.centre_m;
  return balls;
}

bool hides(const SolidShape& shape, const spheres::Ball& ball) {
  constexpr double kTouching = 0.01;  // of the ball's radius: a ball so near touches the surface
  const Vector3d at_m = shape.orientation.conjugate() * (ball.centre_m - shape.position_m);
  const auto sample = collision::exact_sample(exact_of(shape), at_m);
  return sample && sample->distance_m + (1.0 + kTouching) * ball.radius_m < 0.0;
}

double bounding_radius_m(const SolidShape& shape) {
  return shape.position_m.norm() + collision::ball_radius_m(field_kind(shape), shape.half_m);
}

void add_surface(const SolidShape& shape, mesh::TriangleMesh& mesh) {
  const std::size_t first = mesh.vertices_m.size();
  if (shape.kind == Kind::kBox)
    add_box(shape.half_m, mesh);
  else
    add_turned(shape, mesh);
  for (std::size_t i = first; i < mesh.vertices_m.size(); ++i)
    mesh.vertices_m[i] = shape.position_m + shape.orientation * mesh.vertices_m[i];
}

}  // namespace stillgrid::bodies
