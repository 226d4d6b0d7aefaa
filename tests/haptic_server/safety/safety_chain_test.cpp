#include "haptic_server/safety/safety_chain.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/haptic_server/safety/safety_input.hpp"

namespace stillgrid::safety::safety_chain_test {
namespace {

constexpr double kLever_m = 0.1;  // of a device that declares no torque
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST_CASE("A force within the limits passes unchanged and unflagged", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3});
  const Commanded commanded = tick(chain, push(1.0, -2.0, 0.5));
  CHECK(commanded.wrench.force_N == Eigen::Vector3d(1.0, -2.0, 0.5));
  CHECK(commanded.flags == 0);
}

TEST_CASE("The norm is cut to the limit and the direction kept", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3});
  const Commanded commanded = tick(chain, push(30.0, 40.0));
  CHECK((commanded.wrench.force_N - Eigen::Vector3d(1.98, 2.64, 0.0)).norm() < 1e-12);
  CHECK(commanded.flags == kFlagClamped);
}

TEST_CASE("The torque is shortened, slewed and faded with its force", "[safety_chain]") {
  SafetyInput input = push(30.0, 40.0);
  input.rendered.torque_N_m = {1.0, -2.0, 3.0};
  SafetyChain clamping = warmed_up({.max_force_N = 2.5});
  CHECK((tick(clamping, input).wrench.torque_N_m - 0.05 * input.rendered.torque_N_m).norm() <
        1e-12);

  SafetyChain slewing = warmed_up({.max_force_N = 100.0, .max_slew_N_per_ms = 1.0});
  const Commanded slewed = tick(slewing, input);
  const double asked_N = norm_N(input.rendered, kLever_m);
  CHECK((slewed.wrench.torque_N_m - input.rendered.torque_N_m / asked_N).norm() < 1e-12);

  SafetyChain ramping({.max_force_N = 100.0});
  CHECK((tick(ramping, input).wrench.torque_N_m - 0.01 * input.rendered.torque_N_m).norm() < 1e-12);
}

TEST_CASE("A device that takes no force is commanded none, and then from zero", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3});
  REQUIRE(after(chain, push(2.0), 10).x_N() == 2.0);
  SafetyInput unready = push(2.0);
  unready.device_ready = false;
  const int ticks = GENERATE(1, 37, 3000);
  for (int i = 0; i < ticks; ++i) {
    const Commanded none = tick(chain, unready);
    REQUIRE(none.wrench.force_N.isZero(0.0));
    REQUIRE(none.flags == kFlagRamped);
  }
  double before_N = 0.0;
  for (int i = 0; i < 100; ++i) {
    const Commanded ramped = tick(chain, push(2.0));
    REQUIRE(ramped.x_N() > before_N);
    REQUIRE(ramped.x_N() - before_N < 0.021);  // a hundredth of it
    before_N = ramped.x_N();
  }
  CHECK(tick(chain, push(2.0)).x_N() == 2.0);
}

TEST_CASE("The mean square of a torque stays that of the continuous one", "[safety_chain]") {
  SafetyInput couple = push(0.3);
  couple.rendered.torque_N_m = {0.2, -0.1, 0.05};
  const double torque_limit_N_m = GENERATE(0.03, 0.07, 0.19);
  SafetyChain chain = warmed_up({.max_force_N = 5.0,
                                 .continuous_torque_N_m = torque_limit_N_m,
                                 .motor_time_constant_s = 0.5});
  CHECK(tick(chain, couple).wrench.torque_N_m == couple.rendered.torque_N_m);
  const Commanded held = after(chain, couple, 5000);
  CHECK(held.wrench.torque_N_m.norm() == Approx(torque_limit_N_m).epsilon(0.02));
  CHECK(held.wrench.torque_N_m.norm() <= torque_limit_N_m * (1.0 + 1e-9));
  CHECK((held.flags & kFlagBudget) != 0);
  const double share = held.wrench.torque_N_m.norm() / couple.rendered.torque_N_m.norm();
  CHECK(held.x_N() == Approx(0.3 * share));  // one factor for both

  SafetyChain undeclared = warmed_up({.max_force_N = 5.0});
  CHECK(after(undeclared, couple, 5000).flags == 0);
}

TEST_CASE("A couple without a force is limited to what the force's limit makes at the lever",
          "[safety_chain]") {
  SafetyInput couple = push(0.0);
  couple.rendered.torque_N_m = {0.0, 50.0, 0.0};
  SafetyChain clamping = warmed_up({.max_force_N = 5.0});
  const Commanded clamped = tick(clamping, couple);
  CHECK(clamped.wrench.torque_N_m.y() == Approx(5.0 * kLever_m));
  CHECK(clamped.flags == kFlagClamped);

  SafetyChain slewing = warmed_up({.max_force_N = 5.0, .max_slew_N_per_ms = 0.1});
  const Commanded slewed = tick(slewing, couple);
  CHECK(slewed.wrench.torque_N_m.y() == Approx(0.1 * kLever_m));
  CHECK((slewed.flags & kFlagSlewed) != 0);
}

TEST_CASE("A force or torque that is no number becomes zero, with the other", "[safety_chain]") {
  SafetyInput bad = push(1.0);
  SECTION("force nan") {
    bad.rendered.force_N.y() = kNaN;
  }
  SECTION("force endless") {
    bad.rendered.force_N.z() = -kInf;
  }
  SECTION("force whose norm is endless, at a speed above the limit") {
    bad.rendered.force_N.setConstant(1.5e308);
    bad.velocity_m_s.setConstant(10.0);
  }
  SECTION("torque") {
    bad.rendered.torque_N_m.x() = kNaN;
  }
  SafetyChain chain = warmed_up({.max_force_N = 3.3, .max_speed_m_s = 2.0});
  const Commanded commanded = tick(chain, bad);
  CHECK(commanded.wrench.force_N.isZero(0.0));
  CHECK(commanded.wrench.torque_N_m.isZero(0.0));
  CHECK(commanded.flags == kFlagRejected);
}

/// Of one contact whose normal is along that way.
Eigen::Matrix3d spring(double stiffness_N_per_m, const Eigen::Vector3d& way) {
  const Eigen::Vector3d normal = way.normalized();
  return stiffness_N_per_m * normal * normal.transpose();
}

TEST_CASE("Contacts together are governed to the device's stiffness, along their own direction",
          "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 10.0, .stiffness_N_per_m = 1000.0});
  SafetyInput stiff = push(2.0);
  stiff.stiffness_N_per_m = spring(4000.0, {1.0, 2.0, -0.5});
  const Commanded commanded = after(chain, stiff, 100);
  CHECK(commanded.x_N() == Approx(0.5));
  CHECK(commanded.flags == kFlagStiffness);

  SafetyInput corner = push(2.0);
  corner.stiffness_N_per_m = 900.0 * Eigen::Matrix3d::Identity();  // 900 along any direction
  CHECK(after(chain, corner, 101).x_N() == 2.0);

  SafetyInput held_by_two = push(2.0);
  held_by_two.stiffness_N_per_m = spring(600.0, {0.0, 0.0, 1.0}) + spring(600.0, {0.0, 0.0, -1.0});
  CHECK(after(chain, held_by_two, 100).x_N() == Approx(2.0 / 1.2));
}

TEST_CASE("The first touch of a contact that is too stiff is no pulse", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 10.0, .stiffness_N_per_m = 1000.0});
  for (int ms = 1; ms <= 20; ++ms) {
    SafetyInput input = push(2.0 * ms);
    input.stiffness_N_per_m = spring(4000.0, {1.0, 0.0, 0.0});
    CHECK(tick(chain, input).x_N() == Approx(0.5 * ms));
  }
}

TEST_CASE("One contact more is no step of the governed force", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 10.0, .stiffness_N_per_m = 1000.0});
  SafetyInput input = push(1.0);
  input.stiffness_N_per_m = spring(1000.0, {1.0, 0.0, 0.0});
  double before_N = tick(chain, input).x_N();
  input.stiffness_N_per_m *= 2.0;
  for (int i = 0; i < 20; ++i) {
    const double force_N = tick(chain, input).x_N();
    CHECK(before_N - force_N < 0.1001);
    before_N = force_N;
  }
  CHECK(before_N == Approx(0.5));
}

TEST_CASE("No force, for however long, is warmer than the continuous one", "[safety_chain]") {
  SafetyChain chain =
      warmed_up({.max_force_N = 8.0, .continuous_force_N = 1.5, .motor_time_constant_s = 2.0});
  double heat_N2 = 0.0, most_N2 = 0.0;
  std::uint32_t flags = 0;
  double force_N = 0.0;
  for (int ms = 0; ms < 60'000; ++ms) {
    const Commanded commanded = tick(chain, push(ms % 5000 < 3000 ? 20.0 : 1.0));
    force_N = commanded.x_N();
    flags |= commanded.flags;
    heat_N2 += kTick_s / 2.0 * (force_N * force_N - heat_N2);
    most_N2 = std::max(most_N2, heat_N2);
    if (ms == 10) CHECK(force_N == 8.0);  // cold motors bear a peak
  }
  CHECK(most_N2 <= 1.5 * 1.5 * 1.01);
  CHECK(most_N2 > 0.8 * 1.5 * 1.5);
  CHECK((flags & kFlagBudget) != 0);
  CHECK(after(chain, push(20.0), 20'000).x_N() == Approx(1.5).epsilon(1e-3));
}

TEST_CASE("Over the last 5 mm of the workspace the force goes to zero, and outside there is none",
          "[safety_chain]") {
  SafetyChain chain =
      warmed_up({.max_force_N = 3.3, .workspace = {{-0.1, -0.1, -0.05}, {0.1, 0.1, 0.05}}});
  SafetyInput input = push(1.0);
  const auto force_at = [&](double x_m, double z_m) {
    input.device_m = {x_m, 0.0, z_m};
    return tick(chain, input).x_N();
  };
  CHECK(force_at(0.0949, 0.0) == 1.0);
  CHECK(force_at(0.0975, 0.0) == Approx(0.5));
  CHECK(force_at(-0.0975, 0.0) == Approx(0.5));
  CHECK(force_at(0.0, 0.049) == Approx(0.2));
  CHECK(force_at(0.0, 0.06) == 0.0);
  CHECK((tick(chain, input).flags & kFlagWorkspace) != 0);
}

TEST_CASE("An axis without extent has no edge, and on a thin one the last quarter fades",
          "[safety_chain]") {
  SafetyChain chain =
      warmed_up({.max_force_N = 3.3, .workspace = {{-0.1, 0.0, -0.004}, {0.1, 0.0, 0.004}}});
  SafetyInput input = push(1.0);
  const auto force_at = [&](const Eigen::Vector3d& device_m) {
    input.device_m = device_m;
    return tick(chain, input).x_N();
  };
  CHECK(force_at({0.0, 0.5, 0.0}) == 1.0);
  CHECK(force_at({0.0, 0.5, 0.002}) == Approx(1.0));
  CHECK(force_at({0.0, 0.5, 0.003}) == Approx(0.5));
  CHECK(force_at({0.2, 0.5, 0.0}) == 0.0);
}

TEST_CASE("Above the speed limit a force resists and no longer drives", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3, .max_speed_m_s = 1.0});
  SafetyInput input = push(1.0, 1.0);
  const auto force_at = [&](double vx_m_s) {
    input.velocity_m_s = {vx_m_s, 0.0, 0.0};
    return tick(chain, input).wrench.force_N;
  };
  CHECK(force_at(0.99) == Eigen::Vector3d(1.0, 1.0, 0.0));
  CHECK((force_at(1.25) - Eigen::Vector3d(0.5, 1.0, 0.0)).norm() < 1e-12);
  CHECK((force_at(3.0) - Eigen::Vector3d(0.0, 1.0, 0.0)).norm() < 1e-12);
  CHECK(tick(chain, input).flags == kFlagSpeed);
  CHECK(force_at(-3.0) == Eigen::Vector3d(1.0, 1.0, 0.0));
}

TEST_CASE("The norm's limit holds for the force with the control's damping", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 3.3, .passivity_mass_kg = 0.1});
  SafetyInput input = push(3.0);
  (void)tick(chain, input);
  input.motion.moved_m = {0.01, 0.0, 0.0};  // gives the hand 30 mJ
  (void)tick(chain, input);
  input.motion.moved_m = {0.0, -1e-4, 0.0};  // 0.1 m/s, which 10 N stop in a tick
  const Commanded commanded = tick(chain, input);
  CHECK(commanded.wrench.force_N.norm() == Approx(3.3));
  CHECK(commanded.wrench.force_N.y() > 1.0);
  CHECK((commanded.flags & kFlagClamped) != 0);
}

TEST_CASE("Energy is booked of what was told, not of what was rendered", "[safety_chain]") {
  SafetyChain chain = warmed_up({.max_force_N = 1.0});
  SafetyInput input = push(50.0);
  (void)tick(chain, input);
  input.motion.moved_m = {0.001, 0.0, 0.0};
  (void)tick(chain, input);
  CHECK(chain.energy().given_J == Approx(1e-3));
}

TEST_CASE("Whatever comes in, the force is within its limit and slews no faster than it may",
          "[safety_chain]") {
  SafetyChain chain({.max_force_N = 3.3,
                     .max_slew_N_per_ms = 0.05,
                     .stiffness_N_per_m = 1000.0,
                     .continuous_force_N = 0.9,
                     .max_speed_m_s = 1.0,
                     .workspace = {{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}},
                     .passivity_mass_kg = 0.1});
  std::mt19937_64 random(20);
  const auto any = [&](double scale) {
    const auto draw = random() % 40;
    if (draw == 0) return kNaN;
    if (draw == 1) return kInf;
    return std::normal_distribution<double>(0.0, draw == 2 ? 1e200 : scale)(random);
  };
  const auto vector = [&](double scale) {
    return Eigen::Vector3d(any(scale), any(scale), any(scale));
  };
  Wrench before;
  for (int i = 0; i < 20'000; ++i) {
    SafetyInput input = push(0.0);
    input.rendered = {vector(3.0), vector(0.1)};
    input.stiffness_N_per_m = spring(any(2000.0), {1.0, 0.3, 0.1});
    input.device_believed = random() % 10 != 0;
    input.snapshot.writer_alive = random() % 10 != 0;
    input.snapshot.snapshot_age_s = any(0.03);
    input.device_m = vector(0.05);
    input.velocity_m_s = vector(1.0);
    input.motion.moved_m = Eigen::Vector3d::Constant(1e-4 * static_cast<double>(random() % 3));
    input.elapsed_s = 1e-3 * static_cast<double>(1 + random() % 8);
    const Commanded commanded = tick(chain, input);
    REQUIRE(commanded.wrench.force_N.allFinite());
    REQUIRE(commanded.wrench.force_N.norm() <= 3.3 * (1.0 + 1e-12));
    REQUIRE(commanded.wrench.torque_N_m.norm() <= 3.3 * kLever_m * (1.0 + 1e-12));
    const double now_N = norm_N(commanded.wrench, kLever_m), before_N = norm_N(before, kLever_m);
    if (before_N > now_N) before *= now_N / before_N;  // a fall is free
    const Wrench change{commanded.wrench.force_N - before.force_N,
                        commanded.wrench.torque_N_m - before.torque_N_m};
    REQUIRE(norm_N(change, kLever_m) <= 0.05 * (1.0 + 1e-9));
    before = commanded.wrench;
  }
}

}  // namespace
}  // namespace stillgrid::safety::safety_chain_test
