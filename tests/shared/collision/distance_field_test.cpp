#include "shared/collision/distance_field.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace stillgrid::collision::distance_field_test {
namespace {

using Eigen::Vector3d;

constexpr double kRadius_m = 0.0213;

double to_ball_m(const Vector3d& point_m) {
  return (point_m - Vector3d(0.003, -0.001, 0.002)).norm() - kRadius_m;
}
/// Exact, also inside and at edges.
double to_box_m(const Vector3d& point_m) {
  const Eigen::Array3d beyond = point_m.array().abs() - Eigen::Array3d(0.021, 0.013, 0.017);
  return beyond.max(0.0).matrix().norm() + std::min(0.0, beyond.maxCoeff());
}
Eigen::AlignedBox3d box(double half_m) {
  return {Vector3d::Constant(-half_m), Vector3d::Constant(half_m)};
}
DistanceField ball_field(double cell_m, double band_m = 0.004) {
  return make_field(box(0.025), {cell_m, band_m, 0.006}, to_ball_m);
}

struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  Vector3d point(double half_m) {
    const double x = in(-half_m, half_m), y = in(-half_m, half_m);
    return {x, y, in(-half_m, half_m)};
  }
};

Vector3d difference(const FieldView& field, const Vector3d& at_m, double step_m) {
  Vector3d slope;
  for (int i = 0; i < 3; ++i) {
    const Vector3d step = step_m * Vector3d::Unit(i);
    slope[i] = (sample(field, at_m + step)->distance_m - sample(field, at_m - step)->distance_m) /
               (2.0 * step_m);
  }
  return slope;
}

}  // namespace

TEST_CASE("A flat face is reproduced exactly, and its normal", "[distance_field]") {
  const unsigned seed = GENERATE(1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U);
  Random random(seed);
  const Vector3d normal = random.point(1.0).normalized();
  const double offset_m = random.in(-0.01, 0.01);
  const DistanceField field =
      make_field(box(0.02), {random.in(5e-4, 2.3e-3), 0.003, 0.002},
                 [&](const Vector3d& p) { return normal.dot(p) - offset_m; });
  REQUIRE(field.shape().fine_count > 0);
  for (int i = 0; i < 400; ++i) {
    const Vector3d at_m = random.point(0.0215);
    const auto found = sample(field.view(), at_m);
    REQUIRE(found);
    CHECK(std::abs(found->distance_m - (normal.dot(at_m) - offset_m)) < 1e-8);
    CHECK((found->gradient - normal).norm() < 2e-5);  // of floats
  }
}

TEST_CASE("The gradient is the distance's derivative, and continuous", "[distance_field]") {
  const bool is_ball = GENERATE(true, false);
  const DistanceField field = is_ball ? ball_field(0.0011, 0.002)
                                      : make_field(box(0.022), {0.0011, 0.002, 0.006}, to_box_m);
  const FieldView view = field.view();
  REQUIRE(view.shape.fine_count > 0);
  REQUIRE(view.shape.fine_count <
          view.shape.bricks[0] * view.shape.bricks[1] * view.shape.bricks[2]);
  Random random(7);
  const double brick_m = double{view.shape.brick_m};
  const Vector3d lowest_m =
      Eigen::Map<const Eigen::Vector3f>(view.shape.lowest_m.data()).cast<double>();
  const Eigen::Map<const Eigen::Array<std::uint32_t, 3, 1>> bricks(view.shape.bricks.data());
  const Vector3d sides_m = brick_m * bricks.cast<double>();
  for (int i = 0; i < 4000; ++i) {
    // All over the field; half of them on a face between bricks, where fine ones may meet coarse
    // ones.
    Vector3d at_m = lowest_m + (0.5 * (Vector3d::Ones() + random.point(1.0))).cwiseProduct(sides_m);
    if (i % 2 == 0) {
      const int axis = i / 2 % 3;
      at_m[axis] = lowest_m[axis] + brick_m * std::round((at_m[axis] - lowest_m[axis]) / brick_m);
    }
    at_m = at_m.cwiseMax(lowest_m + Vector3d::Constant(1e-6))
               .cwiseMin(lowest_m + sides_m - Vector3d::Constant(1e-6));
    const auto here = sample(view, at_m);
    REQUIRE(here);
    CHECK((difference(view, at_m, 2e-7) - here->gradient).norm() < 2e-3);
    const Vector3d step_m = 1e-9 * random.point(1.0).normalized();
    const auto beside = sample(view, at_m + step_m), behind = sample(view, at_m - step_m);
    CHECK(std::abs(beside->distance_m - behind->distance_m) < 1e-8);
    CHECK((beside->gradient - behind->gradient).norm() < 1e-4);
  }
}

TEST_CASE("A quadratic function is reproduced exactly, fine or coarse", "[distance_field]") {
  Random random(GENERATE(1U, 2U, 3U, 4U, 5U));
  Eigen::Matrix3d bend_per_m;
  for (int i = 0; i < 3; ++i) bend_per_m.col(i) = random.point(20.0);
  const Vector3d slope = random.point(1.0);
  const auto quadratic_m = [&](const Vector3d& p) {
    return 0.5 * p.dot(bend_per_m * p) + slope.dot(p) - 0.003;
  };
  const DistanceField field =
      make_field(box(0.02), {random.in(8e-4, 1.9e-3), 0.001, 0.002}, quadratic_m);
  REQUIRE(field.shape().fine_count > 0);
  REQUIRE(field.shape().fine_count <
          field.shape().bricks[0] * field.shape().bricks[1] * field.shape().bricks[2]);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d at_m = random.point(0.0215);
    const auto found = sample(field.view(), at_m);
    REQUIRE(found);
    CHECK(std::abs(found->distance_m - quadratic_m(at_m)) < 2e-8);
    const Vector3d exact = 0.5 * (bend_per_m + bend_per_m.transpose()) * at_m + slope;
    CHECK((found->gradient - exact).norm() < 1e-4);  // of floats
  }
}

TEST_CASE("A ball's distance errs by less than the square of the cell", "[distance_field]") {
  double before_m = 0.0;
  for (const double cell_m : {0.0023, 0.00115, 0.000575}) {
    const DistanceField field = ball_field(cell_m);
    Random random(3);
    double worst_m = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const Vector3d out = random.point(1.0).normalized();
      const Vector3d at_m =
          Vector3d(0.003, -0.001, 0.002) + (kRadius_m + random.in(-0.001, 0.001)) * out;
      worst_m =
          std::max(worst_m, std::abs(sample(field.view(), at_m)->distance_m - to_ball_m(at_m)));
    }
    CHECK(worst_m < 0.05 * cell_m * cell_m / kRadius_m);
    if (before_m > 0.0) CHECK(before_m / worst_m > 6.0);
    before_m = worst_m;
  }
}

TEST_CASE("No work is done on the way round, whatever the stiffness over the body",
          "[distance_field]") {
  const unsigned seed = GENERATE(1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U);
  Random random(seed);
  const Vector3d wave = random.point(400.0);
  const DistanceField field =
      make_field(box(0.022), {0.0013, 0.003, 0.006}, to_box_m,
                 [&](const Vector3d& p) { return 1.0 + 0.6 * std::sin(wave.dot(p)); });
  const Vector3d middle_m(0.021, random.in(-0.012, 0.012), random.in(-0.016, 0.016));
  const Vector3d a = 0.004 * random.point(1.0).normalized(),
                 b = 0.004 * random.point(1.0).normalized();
  constexpr double kTool_m = 0.005;
  double work_m2 = 0.0, most_m2 = 0.0;
  constexpr int kSteps = 20000;
  const auto at = [&](double turn) -> Vector3d {
    return middle_m + std::cos(2.0 * M_PI * turn) * a + std::sin(2.0 * M_PI * turn) * b;
  };
  for (int i = 0; i < kSteps; ++i) {
    const Vector3d step_m = at((i + 1.0) / kSteps) - at(i / double{kSteps});
    const auto contact = field_contact(field.view(), at((i + 0.5) / kSteps), kTool_m);
    REQUIRE(contact);
    if (!(contact->depth_m > 0.0)) continue;
    const Vector3d force_m = contact->stiffness_scale * contact->depth_m * contact->normal;
    work_m2 += force_m.dot(step_m);
    most_m2 += std::abs(force_m.dot(step_m));
  }
  REQUIRE(most_m2 > 1e-7);
  CHECK(std::abs(work_m2) < 1e-4 * most_m2);
}

TEST_CASE("However deep it is pressed, a solid pushes out", "[distance_field]") {
  const DistanceField field = ball_field(0.0012, 0.002);
  Random random(11);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d out = random.point(1.0).normalized();
    const double depth_m = random.in(1e-5, 0.95 * kRadius_m);
    const auto contact = field_contact(
        field.view(), Vector3d(0.003, -0.001, 0.002) + (kRadius_m - depth_m) * out, 0.002);
    REQUIRE(contact);
    // Coarse bricks round the middle off.
    const double middle_m = kRadius_m - depth_m, brick_m = 0.0048;
    CHECK(contact->depth_m ==
          Approx(depth_m + 0.002).margin(brick_m * brick_m / std::max(middle_m, brick_m)));
    CHECK(contact->normal.dot(out) > 0.85);
  }
}

TEST_CASE("However steep a map of stiffness is, what is pressed deeper is not let go",
          "[distance_field]") {
  const auto wall = [](const Vector3d& p) { return p.z(); };
  const DistanceField field =
      make_field(box(0.01), {1e-4, 5e-4, 0.003}, wall,
                 [](const Vector3d& p) { return p.x() > 0.0 ? 1000.0 : 1.0; });
  for (double x_m = -0.0021; x_m < 0.0021; x_m += 1.7e-5)
    for (const double depth_m : {1e-4, 1.3e-3, 2.9e-3}) {
      const auto contact = field_contact(field.view(), {x_m, 0.0003, 0.003 - depth_m}, 0.003);
      REQUIRE(contact);
      CHECK(contact->stiffness_scale * contact->depth_m > 0.9 * depth_m);
    }
}

TEST_CASE("Off the field, or nowhere, there is no distance", "[distance_field]") {
  const DistanceField field = ball_field(0.002);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Vector3d& at_m :
       {Vector3d(1.0, 0.0, 0.0), Vector3d(0.0, -0.2, 0.0), Vector3d(nan, 0.0, 0.0),
        Vector3d(0.0, 0.0, std::numeric_limits<double>::infinity())}) {
    CHECK_FALSE(sample(field.view(), at_m));
    CHECK_FALSE(field_contact(field.view(), at_m, 0.01));
  }
}

TEST_CASE("Random words lead nowhere outside, and to no force without bounds", "[distance_field]") {
  const DistanceField sound = ball_field(0.002);
  std::mt19937_64 random(GENERATE(1U, 2U, 3U, 4U));
  std::vector<std::uint64_t> words(sound.words().size());
  for (std::uint64_t& word : words) word = random();
  FieldView view = sound.view();
  view.words = words.data();
  Random places(5);
  for (int i = 0; i < 20000; ++i) {
    const auto contact = field_contact(view, places.point(0.03), 0.005);
    if (!contact) continue;
    CHECK(std::abs(contact->depth_m) < 1.0);
    CHECK(contact->stiffness_scale < 1e4);
    CHECK(contact->normal.norm() == Approx(1.0));
  }
}

TEST_CASE("A shape with a number out of range is none", "[distance_field]") {
  const proto::FieldShape sound = ball_field(0.002).shape();
  REQUIRE(is_consistent(sound));
  const auto refused = [&](auto&& change) {
    proto::FieldShape shape = sound;
    change(shape);
    return !is_consistent(shape);
  };
  CHECK(refused([](auto& shape) { shape.bricks[1] = 0; }));
  CHECK(refused([](auto& shape) { shape.bricks = {4096, 4096, 4096}; }));
  CHECK(refused([](auto& shape) { shape.bricks[2] = 0xffff'ffff; }));
  CHECK(refused([](auto& shape) { shape.fine_count = 0xffff'ffff; }));
  CHECK(refused([](auto& shape) { shape.brick_m = std::nanf(""); }));
  CHECK(refused([](auto& shape) { shape.brick_m = -0.001F; }));
  CHECK(refused([](auto& shape) { shape.lowest_m[0] = std::nanf(""); }));
  CHECK(refused([](auto& shape) { shape.bounding_radius_m = 0.0F; }));
  CHECK(refused([](auto& shape) { shape.has_stiffness = 2; }));
}

TEST_CASE("A field that would take too much is refused before it is made", "[distance_field]") {
  CHECK_THROWS_WITH(make_field(box(10.0), {1e-4, 0.002, 0.002}, to_ball_m),
                    Catch::Contains("expected at most"));
  CHECK_THROWS_WITH(
      make_field(box(0.025), {0.002, 0.004, 0.006}, [](const Vector3d&) { return std::nan(""); }),
      Catch::Contains("no number"));
}

}  // namespace stillgrid::collision::distance_field_test
