// A hand that presses, in closed loop: which scenes let it come to rest.

#include "tests/laboratory/fit_run/held_press.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "sim_server/scene/scene_file.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::laboratory::held_press_test {
namespace {

using fit_run::HeldPress;
using fit_run::Loop;
using fit_run::Press;

/// A free sphere of 0.1 kg, drawn up against a tool that stays at height_m by 1 N.
Loop free_sphere(const tests::TestFolder& folder, double rate_hz, display::Transition transition,
                 double height_m = 0.0) {
  const std::string z = std::to_string(height_m);
  (void)folder.write("still.csv", "time_s,x_m,y_m,z_m\n0,0,0," + z + "\n0.6,0,0," + z + "\n");
  return {.scene = scene::load_scene(folder.write("free.toml", R"(
format = 2
world.gravity_m_s2 = [0.0, 0.0, 10.0]
hand.file = "still.csv"
simulation.rate_hz = )" + std::to_string(rate_hz) + R"(
[[material]]
name = "stiff"
contact_stiffness_N_per_m = 3000.0
contact_damping_N_s_per_m = 2.0
[[body]]
name = "free"
kind = "sphere"
position_m = [0.0, 0.0, -0.055]
radius_m = 0.05
mass_kg = 0.1
material = "stiff"
)")),
          .transition = transition};
}

TEST_CASE("A hand that presses a stiff light body rests on prompt snapshots, not on late ones",
          "[held_press]") {
  const tests::TestFolder folder;
  const auto held = [&](double rate_hz, display::Transition transition, double margin) {
    return Press(free_sphere(folder, rate_hz, transition), "premium15").at(margin).stable;
  };
  CHECK(held(10.0, display::Transition::kLinear, 1.0) == false);
  CHECK(held(1000.0, display::Transition::kHold, 1.0) == true);
  CHECK(held(10.0, display::Transition::kLinear, 0.03) == true);  // 90 N/m
  const auto margin =
      Press(free_sphere(folder, 10.0, display::Transition::kLinear), "premium15").largest_margin();
  CHECK_FALSE(margin);
}

/// A stiff ball that is moved so, beside a hand that stays and presses it by 1 mm at first.
Loop moved_ball(const tests::TestFolder& folder, const std::string& motion) {
  (void)folder.write("still.csv", "time_s,x_m,y_m,z_m\n0,0,0,0\n0.1,0,0,0\n");
  return {.scene = scene::load_scene(folder.write("ball.toml", R"(format = 2
simulation.rate_hz = 1000
hand.file = "still.csv"
[[material]]
name = "elastic"
contact_stiffness_N_per_m = 2000.0
contact_damping_N_s_per_m = 2.0
[[body]]
name = "ball"
kind = "sphere"
motion = "prescribed"
position_m = [-0.014, 0.0, 0.0]
radius_m = 0.01
material = "elastic"
)" + motion)),
          .transition = display::Transition::kHold};
}

TEST_CASE("A hand that a scene carries along or shakes is stable", "[held_press]") {
  const tests::TestFolder folder;
  CHECK(Press(moved_ball(folder, "velocity_m_s = [0.004, 0.0, 0.0]\n"), "touch").at(1.0).stable ==
        true);
  const HeldPress shaken =
      Press(moved_ball(folder, "amplitude_m = 0.001\nfrequency_hz = 4.0\n"), "touch").at(1.0);
  CHECK(shaken.stable == true);
  CHECK(shaken.swing_m > 0.001);
  CHECK(shaken.truth_swing_m == Approx(shaken.swing_m).epsilon(0.1));
}

TEST_CASE("A hand whose body has gone tests nothing", "[held_press]") {
  const tests::TestFolder folder;
  CHECK_FALSE(
      Press(moved_ball(folder, "velocity_m_s = [-0.05, 0.0, 0.0]\n"), "touch").at(1.0).stable);
}

TEST_CASE("A press that begins at once is approached from outside and ends in contact",
          "[held_press]") {
  const tests::TestFolder folder;
  for (const double margin :
       {1.0, 2.0, 100.0}) {  // the last is stiffer than the device is made for
    CAPTURE(margin);
    CHECK(
        Press(moved_ball(folder, "velocity_m_s = [0.0, 0.0, 0.0]\n"), "touch").at(margin).stable ==
        true);
  }
}

TEST_CASE("A hand that touches nothing tests nothing", "[held_press]") {
  const tests::TestFolder folder;
  const Press press(free_sphere(folder, 50.0, display::Transition::kLocal, 3.0), "touch");
  CHECK_FALSE(press.at(1.0).stable);
  CHECK_FALSE(press.largest_margin());
}

}  // namespace
}  // namespace stillgrid::laboratory::held_press_test
