#include "shared/collision/exact_shape.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace stillgrid::collision::exact_shape_test {
namespace {

using Eigen::Vector3d;
using proto::FieldKind;

struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Vector3d point(const Vector3d& half_m) {
    const double x = in(-half_m.x(), half_m.x()), y = in(-half_m.y(), half_m.y());
    return {x, y, in(-half_m.z(), half_m.z())};
  }
};

proto::FieldShape drawn(FieldKind kind, Random& random) {
  Vector3d half_m(random.in(0.002, 0.02), random.in(0.002, 0.02), random.in(0.002, 0.02));
  if (kind != FieldKind::kBox) half_m.y() = half_m.x();
  if (kind == FieldKind::kCapsule) half_m.z() += half_m.x();
  return exact_shape(kind, half_m);
}

/// Inside by the definition of the solid, not by a distance.
bool is_inside(const proto::FieldShape& shape, const Vector3d& point_m) {
  const Vector3d half_m = half_sides_m(shape);
  const double off_axis_m = std::hypot(point_m.x(), point_m.y());
  const double straight_m = half_m.z() - half_m.x(), beyond_m = std::abs(point_m.z()) - straight_m;
  switch (static_cast<FieldKind>(shape.kind)) {
    case FieldKind::kBox:
      return (point_m.array().abs() < half_m.array()).all();
    case FieldKind::kCylinder:
      return off_axis_m < half_m.x() && std::abs(point_m.z()) < half_m.z();
    default:
      return std::hypot(off_axis_m, std::max(0.0, beyond_m)) < half_m.x();
  }
}

/// Points of the surface where rays from the centre leave the solid, found by bisection: every
/// shape here is convex and holds its centre.
std::vector<Vector3d> surface_points(const proto::FieldShape& shape) {
  constexpr int kCount = 40'000;
  std::vector<Vector3d> points;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kCount,
                 turn_rad = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double off_axis = std::sqrt(1.0 - z * z);
    const Vector3d ray(off_axis * std::cos(turn_rad), off_axis * std::sin(turn_rad), z);
    double low_m = 0.0, high_m = double{shape.bounding_radius_m};
    for (int step = 0; step < 40; ++step) {
      const double middle_m = 0.5 * (low_m + high_m);
      (is_inside(shape, middle_m * ray) ? low_m : high_m) = middle_m;
    }
    points.emplace_back(low_m * ray);
  }
  return points;
}

}  // namespace

TEST_CASE("A closed form is the distance to the nearest of many points of the surface",
          "[exact_shape]") {
  const auto kind = GENERATE(FieldKind::kBox, FieldKind::kCapsule, FieldKind::kCylinder);
  const unsigned seed = GENERATE(1U, 2U, 3U, 4U);
  Random random(seed);
  const proto::FieldShape shape = drawn(kind, random);
  REQUIRE(is_consistent(shape));
  const std::vector<Vector3d> surface = surface_points(shape);
  for (int i = 0; i < 60; ++i) {
    const Vector3d at_m = random.point(1.5 * half_sides_m(shape));
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Vector3d& point_m : surface)
      nearest_m = std::min(nearest_m, (point_m - at_m).norm());
    const double distance_m = exact_sample(shape, at_m)->distance_m;
    CAPTURE(at_m.transpose());
    CHECK((distance_m < 0.0) == is_inside(shape, at_m));
    CHECK(std::abs(distance_m) <= nearest_m + 1e-9);
    // The points are up to this far apart.
    CHECK(std::abs(distance_m) >= nearest_m - 0.03 * double{shape.bounding_radius_m});
  }
}

TEST_CASE("A closed form's gradient is a unit vector and its derivative", "[exact_shape]") {
  const auto kind = GENERATE(FieldKind::kBox, FieldKind::kCapsule, FieldKind::kCylinder);
  const unsigned seed = GENERATE(1U, 2U, 3U, 4U);
  Random random(seed);
  const proto::FieldShape shape = drawn(kind, random);
  constexpr double kStep_m = 1e-8;
  int at_edges = 0;
  for (int i = 0; i < 500; ++i) {
    const Vector3d at_m = random.point(2.0 * half_sides_m(shape));
    const auto sample = exact_sample(shape, at_m);
    REQUIRE(sample->gradient.norm() == Approx(1.0));
    Vector3d slope;
    for (int k = 0; k < 3; ++k) {
      const Vector3d step = kStep_m * Vector3d::Unit(k);
      slope[k] = (exact_sample(shape, at_m + step)->distance_m -
                  exact_sample(shape, at_m - step)->distance_m) /
                 (2.0 * kStep_m);
    }
    at_edges += (slope - sample->gradient).norm() > 1e-5 ? 1 : 0;
  }
  CHECK(at_edges <= 1);  // where two sides are equally near there is no derivative
}

TEST_CASE("Every point that is a number has a distance with a direction", "[exact_shape]") {
  const auto kind = GENERATE(FieldKind::kBox, FieldKind::kCapsule, FieldKind::kCylinder);
  const DistanceField field(exact_shape(kind, {0.01, 0.01, 0.02}));
  CHECK(field.bytes() == 0);
  const double far_m = GENERATE(0.0, -0.0, 0.01, 1e3, 1e150);
  for (const Vector3d& at_m :
       {Vector3d(far_m, 0.0, 0.0), Vector3d(0.0, 0.0, far_m), Vector3d(far_m, far_m, far_m)}) {
    const auto contact = field_contact(field.view(), at_m, 0.005);
    REQUIRE(contact);
    CHECK(contact->normal.norm() == Approx(1.0));
    CHECK(contact->stiffness_scale == Approx(1.0));
  }
  CHECK_FALSE(field_contact(field.view(), {0.0, std::nan(""), 0.0}, 0.005));
  CHECK_FALSE(
      field_contact(field.view(), {0.0, 0.0, std::numeric_limits<double>::infinity()}, 1.0));
}

TEST_CASE("A closed form of any sides is sound", "[exact_shape]") {
  const auto kind = GENERATE(FieldKind::kBox, FieldKind::kCapsule, FieldKind::kCylinder);
  Random random(5);
  for (int i = 0; i < 3000; ++i) CHECK(is_consistent(drawn(kind, random)));
}

TEST_CASE("A closed form with any other byte is refused", "[exact_shape]") {
  const auto kind = GENERATE(FieldKind::kBox, FieldKind::kCapsule, FieldKind::kCylinder);
  const proto::FieldShape sound = exact_shape(kind, {0.01, 0.01, 0.02});
  REQUIRE(is_consistent(sound));
  const auto bytes = std::bit_cast<std::array<unsigned char, sizeof sound>>(sound);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    for (const int flip : {0x01, 0x80, 0xFF}) {
      auto spoilt = bytes;
      spoilt[i] = static_cast<unsigned char>(spoilt[i] ^ flip);
      const auto shape = std::bit_cast<proto::FieldShape>(spoilt);
      CAPTURE(i, flip);
      if (is_consistent(shape)) {
        CHECK((half_sides_m(shape) - half_sides_m(sound)).norm() < 1e-6);
        CHECK(shape.bounding_radius_m == Approx(sound.bounding_radius_m).epsilon(2e-6));
        CHECK(std::memcmp(&shape.brick_m, &sound.brick_m,
                          offsetof(proto::FieldShape, bounding_radius_m) -
                              offsetof(proto::FieldShape, brick_m)) == 0);
        CHECK(shape.kind == sound.kind);
      }
    }
  for (const double bad : {0.0, -0.01, 2e6, std::nan(""), std::numeric_limits<double>::infinity()})
    CHECK_FALSE(is_consistent(exact_shape(kind, {bad, bad, bad})));
  CHECK_FALSE(is_consistent(exact_shape(FieldKind::kCapsule, {0.01, 0.01, 0.009})));
  CHECK_FALSE(is_consistent(exact_shape(FieldKind::kCylinder, {0.01, 0.011, 0.02})));
  CHECK_FALSE(
      is_consistent(exact_shape(static_cast<FieldKind>(proto::kFieldKinds), {1.0, 1.0, 1.0})));
}

}  // namespace stillgrid::collision::exact_shape_test
