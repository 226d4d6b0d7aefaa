#pragma once

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "shared/collision/field_history.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering {

/// A body's frame and how it moves. World frame.
struct FieldPlace {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d out_of(const Eigen::Vector3d& point_m) const {
    return position_m + orientation * point_m;
  }
  [[nodiscard]] Eigen::Vector3d into(const Eigen::Vector3d& point_m) const {
    return orientation.conjugate() * (point_m - position_m);
  }
  /// Returns the frame duration_s later, moved evenly at these velocities.
  [[nodiscard]] FieldPlace after(double duration_s) const {
    FieldPlace later = *this;
    later.position_m += duration_s * velocity_m_s;
    if (const double rate_rad_s = spin_rad_s.norm(); rate_rad_s > 0.0)
      later.orientation =
          Eigen::AngleAxisd(duration_s * rate_rad_s, spin_rad_s / rate_rad_s) * orientation;
    return later;
  }
};

inline std::array<float, 3> floats(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

inline proto::FieldState field_state(const FieldPlace& place) {
  const Eigen::Vector4f q = place.orientation.coeffs().cast<float>();
  return {floats(place.position_m),
          {q.x(), q.y(), q.z(), q.w()},
          floats(place.velocity_m_s),
          floats(place.spin_rad_s),
          0.0F};
}

using Field = std::shared_ptr<const collision::DistanceField>;

inline Eigen::AlignedBox3d cube(double half_m) {
  return {Eigen::Vector3d::Constant(-half_m), Eigen::Vector3d::Constant(half_m)};
}

inline constexpr double kFieldMargin_m = 0.012;

/// Makes the field of each shape once: under sanitizers that takes a second, and a generated case
/// asks for its field anew each time.
template <class Make>
Field made_once(const std::vector<double>& shape, Make&& make) {
  static std::map<std::vector<double>, Field> made;
  Field& field = made[shape];
  if (!field) field = std::make_shared<collision::DistanceField>(make());
  return field;
}

/// Returns the field of a ball whose centre is centre_m.
inline Field ball_field(double radius_m, const Eigen::Vector3d& centre_m = Eigen::Vector3d::Zero(),
                        double cell_m = 0.001) {
  const Eigen::Vector3d half_m = Eigen::Vector3d::Constant(radius_m);
  return made_once({radius_m, centre_m.x(), centre_m.y(), centre_m.z(), cell_m}, [&] {
    return collision::make_field(
        {centre_m - half_m, centre_m + half_m}, {cell_m, 0.006, kFieldMargin_m},
        [=](const Eigen::Vector3d& p) { return (p - centre_m).norm() - radius_m; });
  });
}

/// Distance to a box round the origin; exact, also inside and at edges.
inline double to_box_m(const Eigen::Vector3d& point_m, const Eigen::Vector3d& half_m) {
  const Eigen::Array3d beyond = point_m.array().abs() - half_m.array();
  return beyond.max(0.0).matrix().norm() + std::min(0.0, beyond.maxCoeff());
}
inline Field box_field(const Eigen::Vector3d& half_m, double cell_m = 0.001,
                       const collision::ScalarField& stiffness = {}) {
  const auto make = [&] {
    return collision::make_field(
        {-half_m, half_m}, {cell_m, 0.006, kFieldMargin_m},
        [=](const Eigen::Vector3d& p) { return to_box_m(p, half_m); }, stiffness);
  };
  if (stiffness) return std::make_shared<collision::DistanceField>(make());
  return made_once({half_m.x(), half_m.y(), half_m.z(), cell_m}, make);
}

/// A scene of one material with that field: at rest there, or the one that moves.
inline publication::StaticScene still_field(publication::StaticScene scene, const Field& field,
                                            const FieldPlace& place) {
  publication::PublishedField& body = scene.fields.emplace_back();
  body.field = field;
  body.body.rest = field_state(place);
  body.body.body = static_cast<std::uint32_t>(scene.fields.size());
  return scene;
}
inline publication::StaticScene moving_field(publication::StaticScene scene, const Field& field) {
  scene = still_field(std::move(scene), field, {});
  std::uint32_t moving = 0;
  for (const publication::PublishedField& other : scene.fields)
    moving = std::max(moving, other.body.moving);
  scene.fields.back().body.moving = moving + 1;
  return scene;
}

/// Numbers of a seed, off the round ones.
struct Drawn {
  std::mt19937 engine;
  explicit Drawn(unsigned seed) : engine(seed) {}
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Eigen::Vector3d vector(double half) {
    const double x = in(-half, half), y = in(-half, half);
    return {x, y, in(-half, half)};
  }
  Eigen::Vector3d direction() {
    for (;;)
      if (const Eigen::Vector3d v = vector(1.0); v.norm() > 0.1 && v.norm() <= 1.0)
        return v.normalized();
  }
  Eigen::Quaterniond turn() {
    const double x = in(-1.0, 1.0), y = in(-1.0, 1.0), z = in(-1.0, 1.0);
    return Eigen::Quaterniond(in(-1.0, 1.0), x, y, z).normalized();
  }
};

}  // namespace stillgrid::rendering
