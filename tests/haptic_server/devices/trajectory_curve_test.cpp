#include "haptic_server/devices/trajectory_curve.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid::devices::trajectory_curve_test {
namespace {

Eigen::Vector3d smooth_m(double t) {
  return {std::sin(3.0 * t), std::cos(2.0 * t) + t, t * t - 0.3 * t * t * t};
}

/// Samples of the smooth motion at irregular times, from 1 ms to 60 ms apart.
tables::Trajectory irregular_recording() {
  std::mt19937 random(7);
  tables::Trajectory trajectory;
  for (double time_s = 0.0; time_s < 2.0;) {
    trajectory.time_s.push_back(time_s);
    trajectory.position_m.push_back(smooth_m(time_s));
    time_s += 1e-3 + 59e-3 * static_cast<double>(random() % 1000U) / 1000.0;
  }
  return trajectory;
}

/// The largest distance from the smooth motion, away from the natural ends.
double error_m(const TrajectoryCurve& curve) {
  CurveCursor cursor;
  double worst_m = 0.0;
  for (int n = 300; n < 1600; ++n) {
    const double time_s = 1e-3 * n;
    const Eigen::Vector3d position_m = curve_at(curve, time_s, cursor).position_m;
    worst_m = std::max(worst_m, (position_m - smooth_m(time_s)).norm());
  }
  return worst_m;
}

double largest_speed_m_s(const TrajectoryCurve& curve) {
  CurveCursor cursor;
  double largest_m_s = 0.0;
  for (int n = 0; n * 2e-4 < curve.knot_time_s.back(); ++n) {
    largest_m_s = std::max(largest_m_s, curve_at(curve, n * 2e-4, cursor).velocity_m_s.norm());
  }
  return largest_m_s;
}

TEST_CASE("Both resamplings pass through every sample", "[trajectory_curve]") {
  const tables::Trajectory trajectory = irregular_recording();
  const auto resampling = GENERATE(Resampling::kLinear, Resampling::kCubic);
  const TrajectoryCurve curve = make_curve(trajectory, resampling);

  CurveCursor cursor;
  for (std::size_t i = 0; i < trajectory.time_s.size(); ++i) {
    const MotionPoint point = curve_at(curve, trajectory.time_s[i], cursor);
    CHECK((point.position_m - trajectory.position_m[i]).norm() < 1e-14);
  }
}

TEST_CASE("The cubic follows a smooth motion far better than the linear", "[trajectory_curve]") {
  const tables::Trajectory trajectory = irregular_recording();
  const double cubic_m = error_m(make_curve(trajectory, Resampling::kCubic));
  const double linear_m = error_m(make_curve(trajectory, Resampling::kLinear));
  CHECK(cubic_m < linear_m / 50.0);
}

TEST_CASE("A straight motion is reproduced by both at any time", "[trajectory_curve]") {
  tables::Trajectory trajectory;
  for (const double time_s : {0.0, 1e-4, 0.005, 0.0051, 0.3}) {
    trajectory.time_s.push_back(time_s);
    trajectory.position_m.emplace_back(2.0 * time_s, 1.0, -time_s);
  }
  const auto resampling = GENERATE(Resampling::kLinear, Resampling::kCubic);
  const TrajectoryCurve curve = make_curve(trajectory, resampling);
  CurveCursor cursor;
  const MotionPoint point = curve_at(curve, 0.123, cursor);
  CHECK((point.position_m - Eigen::Vector3d(0.246, 1.0, -0.123)).norm() < 1e-14);
  CHECK((point.velocity_m_s - Eigen::Vector3d(2.0, 0.0, -1.0)).norm() < 1e-12);
}

TEST_CASE("The curve's velocity is its derivative, and of the cubic does not jump",
          "[trajectory_curve]") {
  const tables::Trajectory trajectory = irregular_recording();
  const TrajectoryCurve curve = make_curve(trajectory, Resampling::kCubic);
  CurveCursor cursor;
  constexpr double kStep_s = 1e-6;
  for (std::size_t i = 1; i + 1 < trajectory.time_s.size(); ++i) {
    const double knot_s = trajectory.time_s[i];
    const MotionPoint before = curve_at(curve, knot_s - kStep_s, cursor);
    const MotionPoint at = curve_at(curve, knot_s, cursor);
    const MotionPoint after = curve_at(curve, knot_s + kStep_s, cursor);
    const Eigen::Vector3d slope_m_s = (after.position_m - before.position_m) / (2.0 * kStep_s);
    CHECK((slope_m_s - at.velocity_m_s).norm() < 1e-7);
    CHECK((before.velocity_m_s - after.velocity_m_s).norm() < 1e-3);
  }
}

TEST_CASE("Outside the recording the curve stands still at its ends", "[trajectory_curve]") {
  const tables::Trajectory trajectory = irregular_recording();
  const TrajectoryCurve curve = make_curve(trajectory, Resampling::kCubic);
  CurveCursor cursor;
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(curve_at(curve, infinity, cursor).position_m == trajectory.position_m.back());
  CHECK(curve_at(curve, -infinity, cursor).position_m == trajectory.position_m.front());
  CHECK(curve_at(curve, infinity, cursor).velocity_m_s.isZero());
}

TEST_CASE("The order of reading changes nothing", "[trajectory_curve]") {
  const TrajectoryCurve curve = make_curve(irregular_recording(), Resampling::kCubic);
  CurveCursor in_order;
  CurveCursor jumping;
  for (int n = 0; n < 1500; ++n) {
    const double time_s = 1e-3 * n;
    static_cast<void>(curve_at(curve, 1.5 - time_s, jumping));
    CHECK(curve_at(curve, time_s, in_order).position_m ==
          curve_at(curve, time_s, jumping).position_m);
  }
}

TEST_CASE("One sample alone is a point that stands still", "[trajectory_curve]") {
  tables::Trajectory trajectory;
  trajectory.time_s = {0.0};
  trajectory.position_m = {{1.0, 2.0, 3.0}};
  const TrajectoryCurve curve = make_curve(trajectory, Resampling::kCubic);
  CurveCursor cursor;
  CHECK(curve_at(curve, 0.0, cursor).position_m == Eigen::Vector3d(1.0, 2.0, 3.0));
  CHECK(curve_at(curve, 5.0, cursor).position_m == Eigen::Vector3d(1.0, 2.0, 3.0));
}

TEST_CASE("Stale readings do not make the cubic swing, and a rest stays a rest",
          "[trajectory_curve]") {
  tables::Trajectory
      trajectory;  // 0.1 m/s, logged at 1 kHz from a sensor at 100 Hz, then 1 s of rest
  for (int n = 0; n < 2000; ++n) {
    const int reading = std::min(n, 1000) / 10;
    trajectory.time_s.push_back(1e-3 * n);
    trajectory.position_m.emplace_back(1e-3 * reading, 0.0, 0.0);
  }
  const TrajectoryCurve curve = make_curve(trajectory, Resampling::kCubic);
  CHECK(largest_speed_m_s(make_curve(trajectory, Resampling::kLinear)) == Approx(1.0));
  CHECK(largest_speed_m_s(curve) < 0.14);  // it swings a little where the motion stops dead
  CurveCursor cursor;
  CHECK(curve_at(curve, 1.1, cursor).velocity_m_s.norm() < 1e-9);
}

TEST_CASE("Knots keep the distance asked for, the last sample among them", "[trajectory_curve]") {
  const tables::Trajectory trajectory = irregular_recording();
  const TrajectoryCurve curve = make_curve(trajectory, Resampling::kCubic, 0.1);
  CHECK(curve.knot_time_s.front() == 0.0);
  CHECK(curve.knot_time_s.back() == trajectory.time_s.back());
  for (std::size_t i = 1; i < curve.knot_time_s.size(); ++i) {
    CHECK(curve.knot_time_s[i] - curve.knot_time_s[i - 1] >= 0.1);
  }
  CHECK(error_m(curve) < 1e-3);
}

TEST_CASE("Orientation turns at an even rate, the short way", "[trajectory_curve]") {
  tables::Trajectory trajectory;
  trajectory.time_s = {0.0, 2.0};
  trajectory.position_m = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitZ()));
  trajectory.orientation = {Eigen::Quaterniond::Identity(),
                            Eigen::Quaterniond(Eigen::Vector4d(-quarter.coeffs()))};
  const TrajectoryCurve curve = make_curve(trajectory, Resampling::kLinear);
  CurveCursor cursor;
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  CHECK(orientation_at(curve, 0.4, cursor).angularDistance(expected) < 1e-12);
  CHECK(orientation_at(curve, 9.0, cursor).angularDistance(quarter) < 1e-12);
}

TEST_CASE("On recordings made by others the cubic stays near the samples and their speed",
          "[trajectory_curve][real_data]") {
  const auto folder = real_recordings();
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: no recordings in " << folder);
    return;
  }
  for (const char* const file :
       {"franka_1khz/franka_20260223_162545.csv", "ku_contour_force/demo_a_1.csv",
        "ku_contour_force/demo_d_2.csv"}) {
    const tables::Trajectory trajectory = tables::read_trajectory((folder / file).string());
    const TrajectoryCurve linear = make_curve(trajectory, Resampling::kLinear);
    const TrajectoryCurve cubic = make_curve(trajectory, Resampling::kCubic);
    CHECK(largest_speed_m_s(cubic) < 1.3 * largest_speed_m_s(linear));
    CurveCursor linear_cursor;
    CurveCursor cubic_cursor;
    for (int n = 0; n * 1e-3 < trajectory.time_s.back(); ++n) {
      const double time_s = n * 1e-3;
      const Eigen::Vector3d straight_m = curve_at(linear, time_s, linear_cursor).position_m;
      const Eigen::Vector3d bent_m = curve_at(cubic, time_s, cubic_cursor).position_m;
      REQUIRE((bent_m - straight_m).norm() < 1e-3);
    }
  }
}

}  // namespace
}  // namespace stillgrid::devices::trajectory_curve_test
