#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "shared/collision/distance_field.hpp"
#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::dynamics {

inline constexpr double kFieldCell_m = 0.0015;

/// Fields of solids whose distance is known, with room for spheres of 12 mm round them.
using SharedField = std::shared_ptr<const collision::DistanceField>;
[[nodiscard]] inline SharedField field_of(const Eigen::Vector3d& half_size_m,
                                          const collision::ScalarField& distance_m,
                                          const collision::ScalarField& stiffness = {}) {
  return std::make_shared<const collision::DistanceField>(collision::make_field(
      {-half_size_m, half_size_m}, {kFieldCell_m, 4.0 * kFieldCell_m, 0.012 + 4.0 * kFieldCell_m},
      distance_m, stiffness));
}
[[nodiscard]] inline SharedField ball_field(double radius_m) {
  return field_of(Eigen::Vector3d::Constant(radius_m),
                  [radius_m](const Eigen::Vector3d& x) { return x.norm() - radius_m; });
}
[[nodiscard]] inline SharedField box_field(const Eigen::Vector3d& size_m,
                                           const collision::ScalarField& stiffness = {}) {
  return field_of(
      0.5 * size_m,
      [size_m](const Eigen::Vector3d& x) {
        const Eigen::Array3d out = x.array().abs() - 0.5 * size_m.array();
        return out.max(0.0).matrix().norm() + std::min(0.0, out.maxCoeff());
      },
      stiffness);
}

inline void add_field(EngineScene& scene, int rigid, SharedField distance) {
  Description::Field field;
  field.distance = std::move(distance);
  field.rigid = field.body = rigid;
  scene.description.fields.push_back(std::move(field));
}
/// Adds a body that never moves; returns its rigid body.
inline int add_static_field(EngineScene& scene, SharedField distance,
                            const Eigen::Vector3d& position_m) {
  const int rigid = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), position_m, true);
  add_field(scene, rigid, std::move(distance));
  return rigid;
}
inline void add_surface_point(EngineScene& scene, int rigid, double radius_m,
                              const Eigen::Vector3d& local_m) {
  scene.add_sphere(rigid, radius_m, local_m);
  scene.description.spheres.back().is_field_point = true;
}

/// Adds a free box with a field and points on its edges and faces; returns its rigid body.
inline int add_field_box(EngineScene& scene, const Eigen::Vector3d& size_m, double mass_kg,
                         const Eigen::Vector3d& position_m, SharedField distance) {
  constexpr int kEdge = 4;
  constexpr double kPoint_m = 0.0009;
  const Eigen::Vector3d square = size_m.cwiseProduct(size_m);
  const int rigid = scene.add_rigid(
      mass_kg, mass_kg / 12.0 * (Eigen::Vector3d::Constant(square.sum()) - square), position_m);
  for (int k = 0; k < kEdge * kEdge * kEdge; ++k) {
    const Eigen::Array3i at(k % kEdge, k / kEdge % kEdge, k / kEdge / kEdge);
    if (at.minCoeff() > 0 && at.maxCoeff() < kEdge - 1) continue;
    const Eigen::Array3d share = at.cast<double>() / (kEdge - 1) - 0.5;
    add_surface_point(scene, rigid, kPoint_m, (size_m.array() - 2.0 * kPoint_m) * share);
  }
  add_field(scene, rigid, std::move(distance));
  return rigid;
}
/// Adds a free ball of 1000 kg/m^3 with a field and points on a spiral; returns its rigid body.
inline int add_field_ball(EngineScene& scene, double radius_m, const Eigen::Vector3d& position_m,
                          SharedField distance, int points = 120) {
  constexpr double kPoint_m = 0.0009;
  const double mass_kg = 1000.0 * 4.0 / 3.0 * M_PI * std::pow(radius_m, 3);
  const int rigid = scene.add_rigid(
      mass_kg, Eigen::Vector3d::Constant(0.4 * mass_kg * radius_m * radius_m), position_m);
  for (int i = 0; i < points; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / points, flat = std::sqrt(1.0 - z * z);
    const double turn_rad = std::numbers::pi * (3.0 - std::sqrt(5.0)) * i;
    const Eigen::Vector3d out(flat * std::cos(turn_rad), flat * std::sin(turn_rad), z);
    add_surface_point(scene, rigid, kPoint_m, (radius_m - kPoint_m) * out);
  }
  add_field(scene, rigid, std::move(distance));
  return rigid;
}

}  // namespace stillgrid::dynamics
