#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "haptic_server/devices/device_profile.hpp"
#include "haptic_server/devices/force_dimension_state.hpp"
#include "haptic_server/devices/openhaptics_state.hpp"
#include "haptic_server/devices/rigid_reading.hpp"

namespace stillgrid::devices::vendor_state_test {
namespace {

ForceDimensionStatus status_of_work() {
  ForceDimensionStatus status{};
  status[kDhdPower] = status[kDhdConnected] = status[kDhdForce] = 1;
  return status;
}

std::array<double, 16> transform_at_mm(double x, double y, double z) {
  return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1};
}

constexpr std::uint32_t kWorks =
    STILLGRID_STATUS_MOTORS_ON | STILLGRID_STATUS_ENABLED | STILLGRID_STATUS_CALIBRATED;

TEST_CASE("Each number of a Force Dimension status that takes the force is seen in one bit alone",
          "[vendor]") {
  ForceDimensionStatus status = status_of_work();
  CHECK(status_bits(status, false) == kWorks);
  const auto with = [](std::size_t index, int number) {
    ForceDimensionStatus changed = status_of_work();
    changed.at(index) = number;
    return status_bits(changed, false);
  };
  CHECK(with(kDhdForce, 0) == (kWorks & ~STILLGRID_STATUS_MOTORS_ON));
  CHECK(with(kDhdPower, 0) == (kWorks & ~STILLGRID_STATUS_MOTORS_ON));
  CHECK(with(kDhdReset, 1) == (kWorks & ~STILLGRID_STATUS_CALIBRATED));
  CHECK(with(kDhdError, 1) == (kWorks | STILLGRID_STATUS_FAULT));
  CHECK(with(kDhdForceOffCause, kDhdForceOffByDeadMan) == kWorks);  // of the last time
  status[kDhdForce] = 0;
  status[kDhdForceOffCause] = kDhdForceOffByDeadMan;
  CHECK(status_bits(status, false) == (kWorks & ~STILLGRID_STATUS_ENABLED));
}

TEST_CASE("A wrist without its reference matters where it has motors", "[vendor]") {
  ForceDimensionStatus status = status_of_work();
  CHECK((status_bits(status, true) & STILLGRID_STATUS_CALIBRATED) == 0);
  status[kDhdWristInit] = 1;
  CHECK(status_bits(status, true) == kWorks);
}

TEST_CASE("A pose in millimetres becomes metres, and no number, shear or mirror a pose",
          "[vendor]") {
  const auto pose = pose_of(transform_at_mm(10, -20, 30));
  REQUIRE(pose);
  CHECK((pose->position_m - Eigen::Vector3d(0.01, -0.02, 0.03)).norm() < 1e-15);
  CHECK(pose->orientation.angularDistance(Eigen::Quaterniond::Identity()) < 1e-12);
  CHECK(!pose_of(transform_at_mm(std::nan(""), 0, 0)));
  CHECK(!pose_of(transform_at_mm(0, 0, 10'001)));
  CHECK(!pose_of({}));
  auto sheared = transform_at_mm(0, 0, 0);
  sheared[4] = 0.1;
  CHECK(!pose_of(sheared));
  auto mirrored = transform_at_mm(0, 0, 0);
  mirrored[10] = -1;
  CHECK(!pose_of(mirrored));
}

TEST_CASE("A transform's columns are the tool's axes in the device's frame", "[vendor]") {
  // The tool's x along the device's y, its y along -x: a quarter turn about z.
  const auto pose = pose_of({0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  REQUIRE(pose);
  CHECK((pose->orientation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm() < 1e-12);
}

TEST_CASE("Every error of OpenHaptics has its effect, and an unknown one is a fault", "[vendor]") {
  CHECK(effect_of(0x0000) == HdEffect::kNone);
  CHECK(effect_of(0x0103) == HdEffect::kNone);
  CHECK(effect_of(0x0200) == HdEffect::kHot);
  for (const unsigned code : {0x0201U, 0x0202U, 0x0203U, 0x0204U, 0x0401U, 0x0500U, 0x7777U})
    CHECK(effect_of(code) == HdEffect::kFault);
  for (const unsigned code : {0x0300U, 0x0302U, 0x0303U, 0x0304U, 0x0600U})
    CHECK(effect_of(code) == HdEffect::kLost);
}

TEST_CASE("A profile is found by the name that the vendor tells, and fills in what is not known",
          "[vendor]") {
  const DeviceProfile* const touch_x = profile_of(openhaptics_profiles(), "Geomagic Touch X");
  REQUIRE(touch_x != nullptr);
  CHECK(touch_x->max_force_N == 7.9);
  REQUIRE(profile_of(openhaptics_profiles(), "Touch") != nullptr);
  CHECK(profile_of(openhaptics_profiles(), "Touch")->max_force_N == 3.3);
  CHECK(profile_of(force_dimension_profiles(), "OMEGA.7 Right")->max_gripper_force_N == 8.0);
  CHECK(profile_of(force_dimension_profiles(), "lambda.7") == nullptr);
  stillgrid_device_descriptor descriptor{};
  descriptor.max_force_N = 2.0;
  fill_in(descriptor, *touch_x);
  CHECK(descriptor.max_force_N == 2.0);
  CHECK(descriptor.continuous_force_N == 1.75);
}

}  // namespace
}  // namespace stillgrid::devices::vendor_state_test
