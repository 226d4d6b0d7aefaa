#include "haptic_server/devices/spacemouse_motion.hpp"

#include <catch2/catch.hpp>
#include <limits>

namespace stillgrid::devices::spacemouse_motion_test {
namespace {

SpacemouseSettings settings_without_dead_zone() {
  SpacemouseSettings settings;
  settings.dead_zone = 0.0;
  settings.range_m = 1.0;
  return settings;
}

Eigen::Vector3d steered_m(const CapCounts& counts, const SpacemouseSettings& settings) {
  SteeredPose pose;
  steer(pose, counts, settings, 0.5);
  return pose.position_m;
}

TEST_CASE("A cap at rest leaves the tool where it is", "[spacemouse]") {
  SteeredPose pose{{0.01, 0.02, 0.03}, Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5)};
  steer(pose, {}, SpacemouseSettings{}, 1.0);
  CHECK(pose.position_m == Eigen::Vector3d(0.01, 0.02, 0.03));
  CHECK(pose.orientation.coeffs() == Eigen::Vector4d(0.5, -0.5, 0.5, 0.5));
}

TEST_CASE("Full deflection to the right, up or away is full speed along x, z or y",
          "[spacemouse]") {
  const SpacemouseSettings settings = settings_without_dead_zone();
  const Eigen::Vector3d right_m = steered_m({350, 0, 0, 0, 0, 0}, settings);
  const Eigen::Vector3d up_m = steered_m({0, 350, 0, 0, 0, 0}, settings);
  const Eigen::Vector3d away_m = steered_m({0, 0, 350, 0, 0, 0}, settings);
  CHECK((right_m - Eigen::Vector3d(0.05, 0.0, 0.0)).norm() < 1e-15);
  CHECK((up_m - Eigen::Vector3d(0.0, 0.0, 0.05)).norm() < 1e-15);
  CHECK((away_m - Eigen::Vector3d(0.0, 0.05, 0.0)).norm() < 1e-15);
}

TEST_CASE("Half deflection is half speed, and beyond full it gets no faster", "[spacemouse]") {
  const SpacemouseSettings settings = settings_without_dead_zone();
  CHECK(steered_m({-175, 0, 0, 0, 0, 0}, settings).x() == Approx(-0.025));
  CHECK(steered_m({350, 350, 350, 0, 0, 0}, settings).norm() == Approx(0.05));
  const int most = std::numeric_limits<int>::max();
  const int least = std::numeric_limits<int>::min();
  CHECK(steered_m({least, most, 0, 0, 0, 0}, settings).norm() == Approx(0.05));
}

TEST_CASE("Inside the dead zone nothing moves, and its edge is no step", "[spacemouse]") {
  SpacemouseSettings settings = settings_without_dead_zone();
  settings.dead_zone = 0.2;
  CHECK(steered_m({70, 0, 0, 0, 0, 0}, settings).isZero(0.0));
  CHECK(steered_m({49, 49, 0, 49, 0, 0}, settings).norm() == 0.0);
  const double just_beyond_m = steered_m({71, 0, 0, 0, 0, 0}, settings).x();
  CHECK(just_beyond_m > 0.0);
  CHECK(just_beyond_m < 0.01 * 0.05);
  CHECK(steered_m({350, 0, 0, 0, 0, 0}, settings).x() == Approx(0.05));
}

TEST_CASE("The tool stays within its range on every axis and slides along its edge",
          "[spacemouse]") {
  SpacemouseSettings settings = settings_without_dead_zone();
  settings.range_m = 0.02;
  SteeredPose pose;
  for (int n = 0; n < 100; ++n) steer(pose, {-300, 100, 0, 0, 0, 0}, settings, 0.01);
  CHECK(pose.position_m.x() == -0.02);
  CHECK(pose.position_m.z() == 0.02);
  for (int n = 0; n < 10; ++n) steer(pose, {350, 0, 0, 0, 0, 0}, settings, 0.01);
  CHECK(pose.position_m.x() == Approx(-0.01));  // it comes back at once
}

TEST_CASE("Turns are right-handed about right, up and away, and stay unit", "[spacemouse]") {
  const SpacemouseSettings settings = settings_without_dead_zone();
  const auto turned = [&](const CapCounts& counts, const Eigen::Vector3d& arm) {
    SteeredPose pose;
    for (int n = 0; n < 1000; ++n) steer(pose, counts, settings, 1e-3);  // 1 rad in all
    CHECK(pose.orientation.norm() == Approx(1.0).epsilon(1e-14));
    return Eigen::Vector3d(pose.orientation * arm);
  };
  const double c = std::cos(1.0);
  const double s = std::sin(1.0);
  using Eigen::Vector3d;
  CHECK((turned({0, 0, 0, 350, 0, 0}, Vector3d::UnitY()) - Vector3d(0, c, s)).norm() < 1e-9);
  CHECK((turned({0, 0, 0, 0, 350, 0}, Vector3d::UnitX()) - Vector3d(c, s, 0)).norm() < 1e-9);
  CHECK((turned({0, 0, 0, 0, 0, 350}, Vector3d::UnitZ()) - Vector3d(s, 0, c)).norm() < 1e-9);
}

}  // namespace
}  // namespace stillgrid::devices::spacemouse_motion_test
