#include "haptic_server/devices/path.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

namespace stillgrid::devices::path_test {
namespace {

constexpr std::array kNames = {"still", "press", "stroke", "tap", "circle"};

Path path_named(const char* name) {
  Path path;
  path.kind = *path_kind(name);
  return path;
}

TEST_CASE("Every generated path starts at its centre at rest", "[path]") {
  const Path path = path_named(GENERATE(from_range(kNames)));
  const double before_s = -std::numeric_limits<double>::infinity();
  for (const double time_s : {before_s, 0.0, 1e-12}) {
    CHECK((path_at(path, time_s).position_m - path.centre_m).norm() < 1e-12);
    CHECK(path_at(path, time_s).velocity_m_s.norm() < 1e-9);
  }
}

TEST_CASE("The velocity is the derivative of the position and does not jump", "[path]") {
  const Path path = path_named(GENERATE(from_range(kNames)));
  constexpr double kStep_s = 1e-5;
  for (int n = 0; n < 5000; ++n) {
    const double time_s = 1.7e-3 * n;
    const MotionPoint before = path_at(path, time_s - kStep_s);
    const MotionPoint after = path_at(path, time_s + kStep_s);
    const Eigen::Vector3d slope_m_s = (after.position_m - before.position_m) / (2.0 * kStep_s);
    REQUIRE((slope_m_s - path_at(path, time_s).velocity_m_s).norm() < 3e-4);
    REQUIRE((after.velocity_m_s - before.velocity_m_s).norm() < 1e-3);
  }
}

TEST_CASE("A press goes straight down by the depth and comes back", "[path]") {
  const Path path = path_named("press");
  const Eigen::Vector3d lowest_m = path_at(path, 0.5 * path.period_s).position_m;
  CHECK((lowest_m - Eigen::Vector3d(0.0, 0.0, -0.01)).norm() < 1e-12);
  CHECK((path_at(path, 3.0 * path.period_s).position_m - path.centre_m).norm() < 1e-12);
}

TEST_CASE("A stroke and a circle stay down and keep within their amplitude", "[path]") {
  const char* const name = GENERATE("stroke", "circle");
  const Path path = path_named(name);
  double extent_m = 0.0;
  for (int n = 1000; n < 10'000; ++n) {
    const Eigen::Vector3d position_m = path_at(path, 1e-3 * n).position_m;
    REQUIRE(position_m.z() == Approx(-0.01).margin(1e-12));
    extent_m = std::max(extent_m, position_m.head<2>().norm());
  }
  CHECK(extent_m == Approx(path.amplitude_m).epsilon(1e-4));
}

TEST_CASE("A circle keeps its radius once it is reached", "[path]") {
  const Path path = path_named("circle");
  for (int n = 300; n < 1000; ++n) {
    REQUIRE(path_at(path, 0.01 * n).position_m.head<2>().norm() == Approx(path.amplitude_m));
  }
}

TEST_CASE("A tap dips to the depth and waits at the centre until the next", "[path]") {
  const Path path = path_named("tap");
  CHECK(path_at(path, 0.125 * path.period_s).position_m.z() == Approx(-0.01));
  CHECK(path_at(path, 0.6 * path.period_s).position_m == path.centre_m);
  CHECK(path_at(path, 5.125 * path.period_s).position_m.z() == Approx(-0.01));
}

TEST_CASE("A recorded path follows its curve and stays at its end", "[path]") {
  tables::Trajectory trajectory;
  trajectory.time_s = {0.0, 1.0};
  trajectory.position_m = {{0.0, 0.0, 0.0}, {0.5, 0.0, 0.0}};
  Path path;
  path.kind = PathKind::kRecorded;
  path.recorded = make_curve(trajectory, Resampling::kLinear);
  CHECK(path_at(path, 0.5).position_m.x() == Approx(0.25));
  CHECK(path_at(path, 0.5).velocity_m_s.x() == Approx(0.5));
  CHECK(path_at(path, 7.0).position_m.x() == 0.5);
}

TEST_CASE("Only generators have a kind by name", "[path]") {
  CHECK_FALSE(path_kind("recorded"));
  CHECK_FALSE(path_kind(""));
  CHECK(path_kind("tap") == PathKind::kTap);
}

}  // namespace
}  // namespace stillgrid::devices::path_test
