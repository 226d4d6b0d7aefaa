#include "haptic_server/safety/passivity_controller.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

namespace stillgrid::safety::passivity_controller_test {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kMass_kg = 0.1;

DeviceMotion moved(double x_m, double y_m, double z_m) {
  return {.moved_m = {x_m, y_m, z_m}};
}

TEST_CASE("Work is that of the force and of the torque", "[energy_observer]") {
  const Wrench held{{1.0, -2.0, 3.0}, {0.1, 0.2, -0.3}};
  const DeviceMotion motion{{0.01, 0.02, 0.03}, {0.5, -0.25, 0.125}};
  CHECK(work_J(held, motion) == Approx(0.06 - 0.0375));
}

TEST_CASE("The most energy given is remembered when it was taken back", "[energy_observer]") {
  HandEnergy account;
  const Wrench held{{2.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  observe(account, held, moved(-0.003, 0.0, 0.0));
  CHECK(account.most_given_J == 0.0);
  observe(account, held, moved(0.005, 0.0, 0.0));
  observe(account, held, moved(-0.001, 0.0, 0.0));
  CHECK(account.given_J == Approx(0.002));
  CHECK(account.most_given_J == Approx(0.004));
}

TEST_CASE("Energy given is taken back in one tick of the same motion", "[passivity_controller]") {
  PassivityController controller(kMass_kg);
  HandEnergy account{.given_J = 1e-6};
  const DeviceMotion motion = moved(1e-4, -2e-4, 3e-4);
  std::uint32_t flags = 0;
  const Eigen::Vector3d added_N = controller.damp(account, 0.0, motion, kTick_s, flags);
  CHECK(flags == kFlagPassivity);
  CHECK(added_N.cross(motion.moved_m).norm() < 1e-15);
  observe(account, {.force_N = added_N}, motion);
  CHECK(account.given_J == Approx(0.0).margin(1e-18));
  (void)controller.damp(account, 0.0, motion, kTick_s, flags);
  CHECK(account.dissipated_by_control_J == Approx(1e-6));
}

TEST_CASE("However much was given, the damper only stops the mass in a tick",
          "[passivity_controller]") {
  PassivityController controller(kMass_kg);
  HandEnergy account{.given_J = 1e6};
  std::uint32_t flags = 0;
  const Eigen::Vector3d added_N =
      controller.damp(account, 0.0, moved(2e-4, 0.0, 0.0), kTick_s, flags);
  const double momentum_kg_m_per_s = kMass_kg * 2e-4 / kTick_s;
  CHECK(added_N.x() == Approx(-momentum_kg_m_per_s / kTick_s));
}

TEST_CASE("Nothing is damped that rests or has given nothing", "[passivity_controller]") {
  PassivityController controller(kMass_kg);
  std::uint32_t flags = 0;
  HandEnergy given{.given_J = 1.0}, taken{.given_J = -1.0}, even;
  CHECK(controller.damp(given, 0.0, moved(0.0, 0.0, 0.0), kTick_s, flags).isZero(0.0));
  CHECK(controller.damp(taken, 0.0, moved(1e-3, 0.0, 0.0), kTick_s, flags).isZero(0.0));
  CHECK(controller.damp(even, 0.0, moved(1e-3, 0.0, 0.0), kTick_s, flags).isZero(0.0));
  CHECK(flags == 0);
}

}  // namespace
}  // namespace stillgrid::safety::passivity_controller_test
