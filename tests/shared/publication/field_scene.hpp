#pragma once

#include <cmath>
#include <memory>
#include <utility>

#include "shared/collision/exact_shape.hpp"
#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid::publication {

/// Distance to a ball round a place that is not the origin, and to a slab; body frame.
inline double to_test_ball_m(const Eigen::Vector3d& point_m) {
  return (point_m - Eigen::Vector3d(0.003, -0.001, 0.002)).norm() - 0.0213;
}
inline double to_test_slab_m(const Eigen::Vector3d& point_m) {
  return std::abs(point_m.z() - 0.001) - 0.0117;
}

inline std::shared_ptr<const collision::DistanceField> test_ball() {
  const Eigen::AlignedBox3d box_m(Eigen::Vector3d::Constant(-0.025),
                                  Eigen::Vector3d::Constant(0.025));
  static const auto ball = std::make_shared<const collision::DistanceField>(
      collision::make_field(box_m, {0.0021, 0.004, 0.006}, to_test_ball_m));
  return ball;
}
/// Returns a slab with a map of stiffness.
inline std::shared_ptr<const collision::DistanceField> test_slab() {
  const Eigen::AlignedBox3d box_m(Eigen::Vector3d::Constant(-0.013),
                                  Eigen::Vector3d::Constant(0.013));
  static const auto slab = std::make_shared<const collision::DistanceField>(
      collision::make_field(box_m, {0.0019, 0.004, 0.006}, to_test_slab_m,
                            [](const Eigen::Vector3d& p) { return 1.0 + 20.0 * p.x(); }));
  return slab;
}

inline std::shared_ptr<const collision::DistanceField> test_box(float half_m) {
  return std::make_shared<collision::DistanceField>(collision::exact_shape(
      proto::FieldKind::kBox, {double{half_m}, 2.0 * double{half_m}, 0.013}));
}

inline PublishedField published_field(std::uint32_t moving, std::uint32_t material,
                                      std::uint32_t body,
                                      std::shared_ptr<const collision::DistanceField> field) {
  proto::FieldBody told{};
  told.moving = moving;
  told.material = material;
  told.body = body;
  return {told, std::move(field)};
}

/// The small scene with bodies that have fields: one at rest and two that move, of which two share
/// a field.
inline StaticScene field_scene() {
  StaticScene scene = small_scene();
  const auto ball = test_ball(), slab = test_slab();
  scene.fields = {published_field(0, 1, 7, ball), published_field(1, 0, 8, slab),
                  published_field(2, 1, 9, ball)};
  scene.fields[0].body.rest.position_m = {0.2F, -0.1F, 0.05F};
  scene.fields[0].body.rest.orientation_xyzw = {0.48F, 0.0F, 0.6F, 0.64F};
  return scene;
}

/// Returns a record of the moving-th moving field in snapshot n.
inline proto::FieldRecord field_record(std::uint32_t moving, std::uint64_t n) {
  proto::FieldRecord record{};
  const auto x = static_cast<float>(n), y = static_cast<float>(moving);
  for (std::size_t age = 0; age < record.history.size(); ++age)
    record.history[age] = {.position_m = {0.01F * x, 0.1F * y, 0.001F * static_cast<float>(age)},
                           .orientation_xyzw = {0.6F, 0.0F, 0.0F, 0.8F},
                           .velocity_m_s = {0.3F, y, x},
                           .angular_velocity_rad_s = {x, 0.7F, y},
                           .reserved = 0.0F};
  return record;
}

}  // namespace stillgrid::publication
