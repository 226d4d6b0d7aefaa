#include "haptic_server/devices/phantom_instrument.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/haptic_server/devices/plugin.hpp"
#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid::devices::phantom_instrument_test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Instrument held_at(const Vector3d& handle_m, const Vector3d& pivot_m) {
  return place_instrument({}, handle_m, pivot_m);
}

/// Where a point fixed to the tool is.
Vector3d placed_m(const Instrument& instrument, const Vector3d& point_m) {
  return instrument.handle_m + orientation_of(instrument) * point_m;
}

/// How fast the tool turns about itself while its handle moves: differences, to fourth order.
Vector3d turning_rad_s(const Vector3d& handle_m, const Vector3d& pivot_m,
                       const Vector3d& velocity_m_s) {
  const auto turned = [&](double half_s) -> Vector3d {
    const Quaterniond turn =
        orientation_of(held_at(handle_m + half_s * velocity_m_s, pivot_m)) *
        orientation_of(held_at(handle_m - half_s * velocity_m_s, pivot_m)).conjugate();
    return turn.vec() / (turn.w() * half_s);  // 2 tan(angle / 2) / (2 half)
  };
  constexpr double kStep_s = 1e-4;
  return (4.0 * turned(kStep_s) - turned(2.0 * kStep_s)) / 3.0;
}

/// Handles above a pivot anywhere, shafts up to 80 degrees from upright.
struct RandomStates {
  std::mt19937 random{7};
  double draw(double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  }
  Vector3d vector(double most) { return {draw(-most, most), draw(-most, most), draw(-most, most)}; }
  Vector3d way_up_m() {
    const double tilt = draw(0.0, 1.4), turn = draw(0.0, 6.3);
    return draw(0.03, 0.3) * Vector3d(std::sin(tilt) * std::cos(turn),
                                      std::sin(tilt) * std::sin(turn), std::cos(tilt));
  }
};

TEST_CASE("The force at the handle does the work of force and torque in any motion",
          "[instrument]") {
  RandomStates states;
  for (int n = 0; n < 1000; ++n) {
    const Vector3d pivot_m = states.vector(0.2), handle_m = pivot_m + states.way_up_m();
    const Vector3d velocity_m_s = states.vector(0.5);
    const Vector3d force_N = states.vector(5.0), torque_N_m = states.vector(1.0);

    const Vector3d felt_N = force_at_handle_N(held_at(handle_m, pivot_m), force_N, torque_N_m);
    const double given_W =
        force_N.dot(velocity_m_s) + torque_N_m.dot(turning_rad_s(handle_m, pivot_m, velocity_m_s));
    REQUIRE(felt_N.dot(velocity_m_s) == Approx(given_W).epsilon(1e-9).margin(1e-7));
  }
}

TEST_CASE("The trocar's force is across the shaft", "[instrument]") {
  RandomStates states;
  for (int n = 0; n < 100; ++n) {
    const Instrument instrument = held_at(states.way_up_m(), Vector3d::Zero());
    const Vector3d force_N = states.vector(5.0);
    const Vector3d felt_N = force_at_handle_N(instrument, force_N, states.vector(1.0));
    REQUIRE(std::abs((felt_N - force_N).dot(instrument.shaft)) < 1e-12);
  }
}

TEST_CASE("A force across the shaft is felt times its lever, reversed beyond the pivot",
          "[instrument]") {
  const Vector3d pivot_m(0.01, -0.02, 0.03), shaft = Vector3d(0.3, -0.2, -1.0).normalized();
  const double distance_m = 0.12;
  const Instrument instrument = held_at(pivot_m - distance_m * shaft, pivot_m);
  const Vector3d across_N = 2.0 * shaft.cross(Vector3d::UnitX()), along_N = 3.0 * shaft;
  for (const double from_handle_m : {0.0, 0.06, 0.12, 0.25}) {
    const Vector3d force_N = across_N + along_N;
    const Vector3d torque_N_m = (from_handle_m * shaft).cross(force_N);
    const double lever = (distance_m - from_handle_m) / distance_m;
    const Vector3d felt_N = force_at_handle_N(instrument, force_N, torque_N_m);
    CHECK((felt_N - along_N - lever * across_N).norm() < 1e-12);
  }
}

TEST_CASE("A spring at a bent tip gives back on a closed way all the work it took",
          "[instrument]") {
  const Vector3d pivot_m(0.0, 0.0, -0.1), tip_m(0.03, 0.01, -0.25), anchor_m(0.05, 0.02, -0.3);
  const auto handle_m = [](double share) {  // a figure of eight that rises and falls
    const double turn = 2.0 * std::numbers::pi * share;
    return Vector3d(0.06 * std::sin(turn) + 0.02, 0.04 * std::sin(2.0 * turn),
                    0.03 + 0.02 * std::cos(turn));
  };
  constexpr int kParts = 4000;
  double work_J = 0.0, most_J = 0.0, rolled_J = 0.0;
  for (int n = 0; n < kParts; ++n) {
    const Instrument instrument = held_at(handle_m((n + 0.5) / kParts), pivot_m);
    const Vector3d at_m = placed_m(instrument, tip_m);
    const Vector3d force_N = -200.0 * (at_m - anchor_m);
    const Vector3d torque_N_m = (at_m - instrument.handle_m).cross(force_N);
    const Vector3d moved_m = handle_m((n + 1.0) / kParts) - handle_m(double(n) / kParts);
    work_J += force_at_handle_N(instrument, force_N, torque_N_m).dot(moved_m);
    most_J = std::max(most_J, std::abs(work_J));
    rolled_J += std::abs(instrument.shaft.dot(torque_N_m));
  }
  CHECK(most_J > 0.1);
  CHECK(rolled_J > 1.0);  // the roll, too, is put to the test
  CHECK(std::abs(work_J) < 1e-6 * most_J);
}

TEST_CASE("At the pivot, under it and straight up the instrument stays whole", "[instrument]") {
  const Instrument before = held_at({0.05, 0.0, 0.1}, Vector3d::Zero());
  const Instrument at_pivot = place_instrument(before, Vector3d::Zero(), Vector3d::Zero());
  CHECK(at_pivot.shaft == before.shaft);
  for (const Instrument& instrument :
       {at_pivot, held_at({0.0, 0.0, -0.1}, Vector3d::Zero()),
        held_at({1e-9, 0.0, -0.1}, Vector3d::Zero()), held_at({0, 0, 1e-300}, Vector3d::Zero())}) {
    CHECK(orientation_of(instrument).norm() == Approx(1.0));
    const Vector3d felt_N = force_at_handle_N(instrument, {1, 2, 3}, {0.1, 0.2, 0.3});
    CHECK(felt_N.norm() < 4.0 + 1e3 / kLeastInstrument_m);
  }
}

void pivot(const Plugin& phantom, const std::string& path, const std::string& z_m = "-0.11") {
  REQUIRE(phantom.configure("path", path) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("pivot_x_m", "0") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("pivot_y_m", "0.01") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.configure("pivot_z_m", z_m) == STILLGRID_DEVICE_OK);
}

TEST_CASE("The shaft passes through the pivot in every reading, and turns without a leap",
          "[instrument]") {
  const std::string path = GENERATE("still", "press", "stroke", "tap", "circle");
  const Vector3d pivot_m(0.0, 0.01, -0.11);
  Plugin phantom("phantom");
  pivot(phantom, path);
  REQUIRE(phantom.configure("noise_m", "1e-4") == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  Quaterniond before = Quaterniond::Identity();
  Vector3d handle_before_m = Vector3d::Zero();
  for (std::uint64_t n = 0; n < 5000; ++n) {
    REQUIRE(phantom.read(n * kTick_ns) == STILLGRID_DEVICE_OK);
    REQUIRE(phantom.state.valid ==
            (STILLGRID_STATE_POSITION | STILLGRID_STATE_ORIENTATION | STILLGRID_STATE_BUTTONS));
    const Vector3d handle_m(phantom.state.position_m);
    const Quaterniond turn(Eigen::Vector4d(phantom.state.orientation_xyzw));
    REQUIRE(std::abs(turn.norm() - 1.0) < 1e-15);
    const Vector3d shaft = turn * -Vector3d::UnitZ();
    REQUIRE(shaft.cross(pivot_m - handle_m).norm() < 1e-12);
    REQUIRE(shaft.dot(pivot_m - handle_m) > 0.0);
    if (n > 0)
      REQUIRE(turn.angularDistance(before) <= 1.1 * (handle_m - handle_before_m).norm() / 0.1);
    before = turn;
    handle_before_m = handle_m;
  }
}

TEST_CASE("What moves the hand is the force at the handle, cut to what the motors can",
          "[instrument]") {
  const std::string most_N = GENERATE("0", "1");
  Plugin phantom("phantom");
  pivot(phantom, "still");
  for (const auto& [key, value] :
       std::array<std::array<std::string, 2>, 7>{{{"hand", "none"},
                                                  {"mass_kg", "0.1"},
                                                  {"damping_N_s_per_m", "0"},
                                                  {"friction_N", "0"},
                                                  {"resolution_m", "0"},
                                                  {"pivot_y_m", "0"},
                                                  {"max_force_N", most_N}}})
    REQUIRE(phantom.configure(key, value) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  REQUIRE(phantom.read(0) == STILLGRID_DEVICE_OK);
  // 2 N at 0.25 m from the handle, which is 0.14 m from the pivot.
  const std::array force_N = {2.0, 0.0, 0.0}, torque_N_m = {0.0, -0.5, 0.0};
  REQUIRE(phantom.api.write(phantom.device, 0, force_N.data(), torque_N_m.data()) == 0);
  REQUIRE(phantom.read(kTick_ns) == STILLGRID_DEVICE_OK);
  const double felt_N = most_N == "0" ? 2.0 * (0.14 - 0.25) / 0.14 : -1.0;
  CHECK(phantom.state.position_m[0] == Approx(0.5 * felt_N / 0.1 * 1e-6).epsilon(1e-9));

  const std::array nan_torque_N_m = {0.0, std::numeric_limits<double>::quiet_NaN(), 0.0};
  CHECK(phantom.api.write(phantom.device, kTick_ns, force_N.data(), nan_torque_N_m.data()) ==
        STILLGRID_DEVICE_E_ARGUMENT);
}

TEST_CASE("A pivot that no instrument could be held at is refused in one line", "[instrument]") {
  const RecordingFile low("t_s,x_m,y_m,z_m\n0,0,0,1\n1,0,0,-0.12\n2,0,0,1\n");
  const auto line = [](const std::string& path, const std::string& z_m) {
    const Plugin phantom("phantom");
    pivot(phantom, path, z_m);
    CHECK(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_E_ARGUMENT);
    return phantom.line();
  };
  const std::string start = "pivot_x_m, pivot_y_m, pivot_z_m: value '0 0.01 ";
  const std::string expected =
      "': expected a point below the handle's path and start and 0.02 m from them, not one by 0 0 ";
  CHECK(line("still", "0.06") == start + "0.06" + expected + "0.03");
  CHECK(line(low.path(), "-0.11").starts_with(start + "-0.11" + expected + "-0.09"));
  CHECK(line("press", "-0.02").starts_with(start + "-0.02" + expected + "-0.00"));
}

TEST_CASE("A pivot of two numbers is refused, and so is a start beside it", "[instrument]") {
  const Plugin part("phantom");
  REQUIRE(part.configure("pivot_x_m", "0") == STILLGRID_DEVICE_OK);
  REQUIRE(part.configure("pivot_z_m", "-0.1") == STILLGRID_DEVICE_OK);
  CHECK(part.api.activate(part.device) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(part.line() == "pivot_y_m: value '': expected a number, for all three of a pivot or none");

  const Plugin started("phantom");
  pivot(started, "press");
  REQUIRE(started.configure("start_z_m", "-0.2") == STILLGRID_DEVICE_OK);
  CHECK(started.api.activate(started.device) == STILLGRID_DEVICE_E_ARGUMENT);
  CHECK(started.line().ends_with("not one by 0 0 -0.2"));
}

TEST_CASE("An instrument's reading and writing never allocate", "[instrument]") {
  if (!allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  Plugin phantom("phantom");
  pivot(phantom, "circle");
  REQUIRE(phantom.api.activate(phantom.device) == STILLGRID_DEVICE_OK);
  const std::array force_N = {2.0, 0.0, 0.0}, torque_N_m = {0.0, -0.5, 0.1};
  const auto before = allocation_count();
  for (std::uint64_t n = 0; n < 100; ++n) {
    (void)phantom.read(n * kTick_ns);
    (void)phantom.api.write(phantom.device, n * kTick_ns, force_N.data(), torque_N_m.data());
  }
  CHECK(allocation_count() == before);
}

}  // namespace
}  // namespace stillgrid::devices::phantom_instrument_test
