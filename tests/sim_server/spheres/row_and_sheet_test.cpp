#include <catch2/catch.hpp>
#include <cmath>

#include "sim_server/spheres/effective_stiffness.hpp"
#include "sim_server/spheres/force_map.hpp"

// Fig. 5 of the paper and what follows from it: balls in a row or a square sheet, a tool pressed
// between and upon them. h = A - depth is the height of the tool's centre over the balls'.
namespace stillgrid::spheres::row_and_sheet_test {
namespace {

constexpr double kContactDistance_m = 0.015;  // A, of which the tool's radius is a third
constexpr double kTool_m = 0.005;
constexpr double kBall_m = kContactDistance_m - kTool_m;
constexpr double kStiffness_N_per_m = 500.0;
constexpr double kPi = 3.14159265358979323846;

std::vector<Ball> lattice(double spacing_m, int rows) {
  constexpr int kEachWay = 12;
  std::vector<Ball> balls;
  for (int y = -(rows > 1 ? kEachWay : 0); y <= (rows > 1 ? kEachWay : 0); ++y)
    for (int x = -kEachWay; x <= kEachWay; ++x)
      balls.push_back({{x * spacing_m, y * spacing_m, 0.0}, kBall_m});
  return balls;
}
std::vector<Ball> row(double spacing_m) {
  return lattice(spacing_m, 1);
}
std::vector<Ball> sheet(double spacing_m) {
  return lattice(spacing_m, 2);
}

/// The middles of equal parts of one period of the tops of a row, or of a sheet.
SurfaceSamples one_period(double spacing_m, int along, int across) {
  SurfaceSamples samples;
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < along; ++x) {
      samples.points_m.emplace_back((x + 0.5) / along * spacing_m,
                                    across > 1 ? (y + 0.5) / across * spacing_m : 0.0, kBall_m);
      samples.normals.emplace_back(0.0, 0.0, 1.0);
    }
  return samples;
}

Eigen::Vector3d force_at_N(const std::vector<Ball>& balls, double x_m, double depth_m) {
  const BallBody body = make_ball_body(balls, kTool_m);
  return kStiffness_N_per_m * unit_force_m(body, {x_m, 0.0, kContactDistance_m - depth_m});
}

ForceMap map_of(const std::vector<Ball>& balls, const SurfaceSamples& samples, double depth_m) {
  const BallBody body = make_ball_body(balls, kTool_m);
  return map_force(samples, kTool_m, depth_m,
                   [&](const Eigen::Vector3d& tool_m) { return unit_force_m(body, tool_m); });
}

double row_mean_N(double spacing_m, double depth_m) {
  const double h_m = kContactDistance_m - depth_m,
               c_m = std::sqrt(kContactDistance_m * kContactDistance_m - h_m * h_m);
  return kStiffness_N_per_m * h_m / spacing_m *
         (2.0 * kContactDistance_m * std::asinh(c_m / h_m) - 2.0 * c_m);
}
double sheet_mean_N(double spacing_m, double depth_m) {
  return kPi * kStiffness_N_per_m * (kContactDistance_m - depth_m) * depth_m * depth_m /
         (spacing_m * spacing_m);
}
double sheet_stiffness_N_per_m(double spacing_m, double depth_m) {
  return kPi * kStiffness_N_per_m * (2.0 * kContactDistance_m * depth_m - 3.0 * depth_m * depth_m) /
         (spacing_m * spacing_m);
}

TEST_CASE("A row pushes upon its balls and between them as derived", "[force_map]") {
  struct Case {
    double spacing_m, upon_N, between_N, weakest_over_strongest, mean_N;
  };
  const auto known = GENERATE(Case{0.010, 1.00000, 1.00018, 0.87923, 0.95426},
                              Case{0.0125, 1.00000, 0.51879, 0.51879, 0.76341},
                              Case{0.005, 2.00018, 1.73010, 0.86496, 1.90852});
  const std::vector<Ball> balls = row(known.spacing_m);

  CHECK(force_at_N(balls, 0.0, 0.002).norm() == Approx(known.upon_N).epsilon(1e-4));
  CHECK(force_at_N(balls, known.spacing_m / 2.0, 0.002).norm() ==
        Approx(known.between_N).epsilon(1e-4));

  double weakest_N = 1e9, strongest_N = 0.0;
  for (int i = 0; i <= 2000; ++i) {
    const double force_N = force_at_N(balls, i / 2000.0 * known.spacing_m, 0.002).norm();
    weakest_N = std::min(weakest_N, force_N);
    strongest_N = std::max(strongest_N, force_N);
  }
  CHECK(weakest_N / strongest_N == Approx(known.weakest_over_strongest).epsilon(1e-4));
  const ForceMap map = map_of(balls, one_period(known.spacing_m, 2000, 1), 0.002);
  CHECK(kStiffness_N_per_m * map.mean_m == Approx(known.mean_N).epsilon(1e-4));
}

TEST_CASE("A row's mean force follows one formula at every spacing and depth", "[force_map]") {
  const double spacing_m = GENERATE(0.004, 0.007, 0.010, 0.0127, 0.015, 0.02);
  const double depth_m = GENERATE(0.0005, 0.002, 0.006, 0.0107);
  const ForceMap map = map_of(row(spacing_m), one_period(spacing_m, 4000, 1), depth_m);
  CHECK(kStiffness_N_per_m * map.mean_m == Approx(row_mean_N(spacing_m, depth_m)).epsilon(1e-4));
}

TEST_CASE("A row has holes from a spacing of twice the half chord on", "[force_map]") {
  constexpr double kHole_m = 0.014967;  // 2 sqrt(A^2 - h^2)
  const auto between_N = [](double spacing_m) {
    return force_at_N(row(spacing_m), spacing_m / 2.0, 0.002).norm();
  };
  CHECK(between_N(kHole_m - 1e-6) > 0.0);
  CHECK(between_N(kHole_m + 1e-6) == 0.0);

  CHECK(map_of(row(0.0140), one_period(0.0140, 1000, 1), 0.002).hole_share == 0.0);
  CHECK(map_of(row(0.0200), one_period(0.0200, 1000, 1), 0.002).hole_share > 0.25);
}

TEST_CASE("Closer balls do not always ripple less", "[force_map]") {
  const auto ripple = [](double spacing_m) {
    return map_of(row(spacing_m), one_period(spacing_m, 1000, 1), 0.002).ripple;
  };
  CHECK(ripple(0.0075) > 2.0 * ripple(0.0100));
  CHECK(ripple(0.0050) > 2.0 * ripple(0.0060));
}

TEST_CASE("A sheet's mean force and stiffness follow 1 / spacing^2", "[force_map]") {
  const double spacing_m = GENERATE(0.005, 0.010);
  const double depth_m = GENERATE(0.002, 0.005, 0.010);
  const SurfaceSamples samples = one_period(spacing_m, 500, 500);
  const ForceMap map = map_of(sheet(spacing_m), samples, depth_m);
  CHECK(kStiffness_N_per_m * map.mean_m == Approx(sheet_mean_N(spacing_m, depth_m)).epsilon(1e-4));
  // Two thirds through the slope is zero: 1e-4 of its peak.
  CHECK(kStiffness_N_per_m * map.effective_stiffness ==
        Approx(sheet_stiffness_N_per_m(spacing_m, depth_m))
            .epsilon(0.0)
            .margin(1e-4 * sheet_stiffness_N_per_m(spacing_m, kContactDistance_m / 3.0)));
}

TEST_CASE("A sheet is stiffest a third through, and gives way two thirds through", "[force_map]") {
  struct Case {
    double spacing_m, stiffness_N_per_m, push_through_N;
  };
  const auto known = GENERATE(Case{0.010, 1178.1, 7.854}, Case{0.005, 4712.4, 31.416});
  const SurfaceSamples samples = one_period(known.spacing_m, 200, 200);
  const auto map = [&](double depth_m) { return map_of(sheet(known.spacing_m), samples, depth_m); };
  CHECK(kStiffness_N_per_m * map(kContactDistance_m / 3.0).effective_stiffness ==
        Approx(known.stiffness_N_per_m).epsilon(1e-4));
  const double most_m = map(2.0 * kContactDistance_m / 3.0).mean_m;
  CHECK(kStiffness_N_per_m * most_m == Approx(known.push_through_N).epsilon(1e-4));
  CHECK(map(0.60 * kContactDistance_m).mean_m < most_m);
  CHECK(map(0.73 * kContactDistance_m).mean_m < most_m);
}

TEST_CASE("A row gives way at 0.7116 A", "[force_map]") {
  const SurfaceSamples samples = one_period(0.010, 4000, 1);
  const auto mean_N = [&](double depth_m) {
    return kStiffness_N_per_m * map_of(row(0.010), samples, depth_m).mean_m;
  };
  CHECK(mean_N(0.7116 * kContactDistance_m) == Approx(6.214).epsilon(1e-4));
  CHECK(mean_N(0.70 * kContactDistance_m) < mean_N(0.7116 * kContactDistance_m));
  CHECK(mean_N(0.73 * kContactDistance_m) < mean_N(0.7116 * kContactDistance_m));
}

TEST_CASE("A single ball gives way at its centre, then pushes to the other side", "[force_map]") {
  const std::vector<Ball> ball{{Eigen::Vector3d::Zero(), kBall_m}};
  CHECK(force_at_N(ball, 0.0, kContactDistance_m - 1e-9).z() == Approx(7.5).epsilon(1e-4));
  CHECK(force_at_N(ball, 0.0, kContactDistance_m + 1e-9).z() == Approx(-7.5).epsilon(1e-4));
  CHECK(force_at_N(ball, 0.0, kContactDistance_m)
            .isZero(0.0));  // no direction, and no number that is none
}

TEST_CASE("Sideways a ball pushes a tool off, as stiff as force over distance", "[force_map]") {
  const std::vector<Ball> ball{{Eigen::Vector3d::Zero(), kBall_m}};
  constexpr double kAside_m = 1e-6;
  CHECK(force_at_N(ball, kAside_m, 0.002).x() / kAside_m == Approx(76.92).epsilon(1e-4));
}

TEST_CASE("Four times the balls are four times as stiff, normalised they are the same",
          "[effective_stiffness]") {
  constexpr double kDepth_m = 0.002;
  const auto mean_m = [&](double spacing_m) {
    return map_of(sheet(spacing_m), one_period(spacing_m, 200, 200), kDepth_m).mean_m;
  };
  const auto scale = [&](double spacing_m) {
    return stiffness_scale(sheet(spacing_m), one_period(spacing_m, 200, 200), kTool_m, kDepth_m);
  };
  CHECK(mean_m(0.004) == Approx(4.0 * mean_m(0.008)).epsilon(1e-3));
  CHECK(scale(0.004) * mean_m(0.004) == Approx(scale(0.008) * mean_m(0.008)).epsilon(1e-3));
}

}  // namespace
}  // namespace stillgrid::spheres::row_and_sheet_test
