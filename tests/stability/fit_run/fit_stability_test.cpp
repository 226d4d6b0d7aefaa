// Hands that press, in closed loop: which of them come to rest.

#include "tests/laboratory/fit_run/fit_stability.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/fit_run/fit_scene.hpp"
#include "tests/stability/fit_run/fit_files.hpp"

namespace stillgrid::fit_run::fit_stability_test {
namespace {

FitReference reference_of(const scene::SceneDescription& scene, const FitPath& path) {
  laboratory::LabRun run;
  return make_reference(scene, path, 1, 0.0, run);
}

/// A free sphere of 0.1 kg, drawn up against the tool by 1 N.
std::string free_scene(double rate_hz) {
  return "format = 2\nworld.gravity_m_s2 = [0.0, 0.0, 10.0]\nsimulation.rate_hz = " +
         std::to_string(rate_hz) + R"(
[[material]]
name = "stiff"
contact_stiffness_N_per_m = 3000.0
[[body]]
name = "free"
kind = "sphere"
position_m = [0.0, 0.0, -0.055]
radius_m = 0.05
mass_kg = 0.1
material = "stiff"
)";
}

TEST_CASE("A hand that presses a stiff light body swings on late snapshots, not on prompt ones",
          "[fit_stability]") {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("still.csv", trajectory_text(0.6, [](double) {
                                                  return Eigen::Vector3d(0.0, 0.0, 0.0);
                                                }))};
  const scene::SceneDescription scene =
      scene::load_scene(folder.write("free.toml", free_scene(10.0)));
  const FitReference reference = reference_of(scene, path);
  const GivenScene given = [&]() -> const scene::SceneDescription& { return scene; };
  const auto held = [&](double rate_hz, display::Transition transition, double margin) {
    const FitCandidate candidate{
        .scene = scene::load_scene(folder.write("free.toml", free_scene(rate_hz))),
        .transition = transition};
    return HeldPresses(candidate, 0.0, reference, given, "premium15").at(margin);
  };
  const FitStability late = held(10.0, display::Transition::kLinear, 1.0);
  CHECK(late.stable == false);
  CHECK(held(1000.0, display::Transition::kHold, 1.0).stable == true);
  CHECK(held(10.0, display::Transition::kLinear, 0.03).stable == true);  // 90 N/m

  const auto largest = [&](display::Transition transition) {
    const FitCandidate candidate{.scene = scene, .transition = transition};
    return HeldPresses(candidate, 0.0, reference, given, "premium15").largest_margin();
  };
  const auto margin = largest(display::Transition::kPredict);
  REQUIRE(margin);
  CHECK(held(10.0, display::Transition::kPredict, *margin).stable == true);
  CHECK_FALSE(largest(display::Transition::kLinear));
}

/// How a hand is held by a scene, each snapshot shown at once, where it pressed the reference's.
FitStability held_where(const scene::SceneDescription& reference_scene,
                        const scene::SceneDescription& scene, const std::string& trajectory,
                        double margin) {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("press.csv", trajectory)};
  const FitReference reference = reference_of(reference_scene, path);
  const FitCandidate candidate{.scene = scene, .transition = display::Transition::kHold};
  const HeldPresses presses(
      candidate, 0.0, reference,
      [&]() -> const scene::SceneDescription& { return reference_scene; }, "touch");
  return presses.at(margin);
}

/// A wall, each snapshot of which is shown at once at 1 kHz, and a press into it.
scene::SceneDescription wall(double stiffness_N_per_m, const std::string& height_m = "0") {
  return load_scene_with(find_scene("wall"), {"simulation.rate_hz=1000",
                                              "material.wall.contact_stiffness_N_per_m=" +
                                                  std::to_string(stiffness_N_per_m),
                                              "body.wall.point_m=[0, 0, " + height_m + "]"});
}
std::string press(double depth_m) {
  return trajectory_text(1.2, [=](double t_s) {
    return Eigen::Vector3d(0.0, 0.0, std::max(0.015 - 0.01 * t_s, 0.005 - depth_m));
  });
}

TEST_CASE("A wall stiffer than the device is made for is held, by the limit that it declares",
          "[fit_stability]") {
  // At 1 kHz a device of 0.1 kg and 2 N s/m bears 2 b / T = 4 kN/m; touch declares 1020 N/m.
  for (const double stiffness_N_per_m : {1000.0, 100e3}) {
    CAPTURE(stiffness_N_per_m);
    const FitStability held =
        held_where(wall(stiffness_N_per_m), wall(stiffness_N_per_m), press(0.0005), 1.0);
    CHECK(held.contact_share == 1.0);
    CHECK(held.stable == true);
  }
}

/// A stiff ball that is moved so, beside a hand that presses it by 1 mm at first.
FitStability held_by_ball(const std::string& motion) {
  const tests::TestFolder folder;
  const scene::SceneDescription ball = scene::load_scene(folder.write("ball.toml", R"(format = 2
simulation.rate_hz = 1000
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
)" + motion));
  return held_where(
      ball, ball, trajectory_text(0.1, [](double) { return Eigen::Vector3d(0.0, 0.0, 0.0); }), 1.0);
}

TEST_CASE("A hand that a scene carries along is stable", "[fit_stability]") {
  const FitStability carried = held_by_ball("velocity_m_s = [0.004, 0.0, 0.0]\n");
  CHECK(carried.stable == true);
  CHECK_FALSE(carried.reference_swing_m);  // it goes, but not to and fro
  CHECK(carried.contact_share == 1.0);

  const FitStability shaken = held_by_ball("amplitude_m = 0.001\nfrequency_hz = 4.0\n");
  CHECK(shaken.stable == true);
  CHECK(shaken.swing_m > 0.001);
  REQUIRE(shaken.reference_swing_m);
  CHECK(*shaken.reference_swing_m == Approx(shaken.swing_m).epsilon(0.1));
}

TEST_CASE("A shallow press is held in contact, in spite of the device's friction",
          "[fit_stability]") {
  const FitStability shallow = held_where(wall(1000.0), wall(1000.0), press(0.0001), 2.0);
  CHECK(shallow.contact_share == 1.0);  // 0.1 N, of which friction bears 0.26 N
  CHECK(shallow.stable == true);
}

TEST_CASE(
    "A hand that touches nothing in the end is unstable if the reference's does, else untested",
    "[fit_stability]") {
  const FitStability lost = held_where(wall(1000.0), wall(1000.0, "-0.1"), press(0.0005), 2.0);
  CHECK(lost.stable == false);
  CHECK(lost.contact_share == 0.0);

  const FitStability gone = held_by_ball("velocity_m_s = [-0.05, 0.0, 0.0]\n");
  CHECK_FALSE(gone.stable.has_value());
  CHECK(gone.contact_share == 0.0);
}

}  // namespace
}  // namespace stillgrid::fit_run::fit_stability_test
