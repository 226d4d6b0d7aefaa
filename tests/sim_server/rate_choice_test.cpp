// The rate that a scene's own hand asks for: what is felt, and what is chosen, with prices in place
// of a clock.

#include "sim_server/rate_choice.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "shared/rendering/force_error.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/lab.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::sim_server::rate_choice_test {
namespace {

/// A ball goes to and fro below a hand that presses it: on a path of its own, so that nothing but
/// the rate makes the force err.
scene::SceneDescription ball_below(const tests::TestFolder& folder, double frequency_hz) {
  std::string hand = "time_s,x_m,y_m,z_m\n";
  for (int i = 0; i <= 130; ++i) {
    std::array<char, 100> row{};
    const double t_s = 0.007 * i;
    std::snprintf(row.data(), row.size(), "%.6g,%.6g,0,%.6g\n", t_s, -0.01 + 0.001 * t_s,
                  0.0115 - 0.001 * std::sin(5.1 * t_s));
    hand += row.data();
  }
  (void)folder.write("hand.csv", hand);
  return scene::load_scene(folder.write("ball.toml", R"(
format = 2
[simulation]
rate_hz = "auto"
[device]
position_m = [0.01, 0.0, 0.002]
[hand]
file = "hand.csv"
settle_s = 0.13
[[material]]
name = "ball"
contact_stiffness_N_per_m = 310.0
[[body]]
name = "ball"
kind = "sphere"
motion = "prescribed"
direction = [0.0, 0.0, 1.0]
amplitude_m = 0.004
frequency_hz = )" + std::to_string(frequency_hz) + R"(
radius_m = 0.013
material = "ball"
)"));
}

struct Case {
  tests::TestFolder folder;
  scene::SceneDescription scene;

  explicit Case(double frequency_hz) : scene(ball_below(folder, frequency_hz)) {}

  /// On a clock on which a step takes step_s: it is asked four times a step, and once a tick.
  [[nodiscard]] RateChoice choose(double step_s, double budget_s = 1e9) const {
    double clock_s = 0.0;
    return choose_rate(
        scene, scene::build_world(scene), budget_s, [&] { return clock_s += 0.5 * step_s; },
        [](const std::string&) {});
  }
};

const RateTrial& trial_at(const RateChoice& choice, double rate_hz) {
  const auto found = std::ranges::find(choice.trials, rate_hz, &RateTrial::rate_hz);
  REQUIRE(found != choice.trials.end());
  return *found;
}

TEST_CASE("What is felt is what both servers in lockstep let a replayed hand feel", "[rate]") {
  Case one(3.1);
  one.scene.period_s = 1.0 / 47.0;
  const HandPath hand(one.scene.hand->file, one.scene.device);
  const FeltForce felt = felt_force(one.scene, {scene::build_world(one.scene)}, hand,
                                    {.latency_s = 0.3 / 47.0, .duration_s = 0.9, .deadline_s = 1.0},
                                    [] { return 0.0; });
  laboratory::LabOptions options;
  options.device = "replay:file=" + one.scene.hand->file.string();
  options.latency_s = 0.3 / 47.0;
  options.duration_s = 0.9;
  const laboratory::LabRun lab = laboratory::run_lab(one.scene, options);
  REQUIRE(felt.force_N.size() == lab.rows.size());
  double most_N = 0.0;
  for (std::size_t i = 0; i < lab.rows.size(); ++i) {
    most_N = std::max(most_N, lab.rows[i].rendered_N.norm());
    REQUIRE((felt.force_N[i] - lab.rows[i].rendered_N).norm() < 1e-7);
  }
  CHECK(most_N > 0.3);
}

TEST_CASE("The rate is the lowest of which all above err by less than is noticed", "[rate]") {
  const Case one(4.3);
  const RateChoice choice = one.choose(1e-9);
  REQUIRE(choice.keeps_force);
  CHECK(choice.keeps_share);
  CHECK(choice.watched_s == Approx(0.91).margin(2e-3));
  bool is_below = false;
  for (const RateTrial& trial : choice.trials) {
    CAPTURE(trial.rate_hz);
    CHECK(trial.runs == 8);
    REQUIRE(trial.error_share);
    if (trial.rate_hz >= choice.rate_hz) CHECK(*trial.error_share <= rendering::kJustNoticeable);
    if (trial.rate_hz < choice.rate_hz && !std::exchange(is_below, true))
      CHECK(*trial.error_share > rendering::kJustNoticeable);
    CHECK(trial.refusal.empty() == (trial.rate_hz == choice.rate_hz));
  }
  CHECK(is_below);
}

TEST_CASE("A faster ball asks for a higher rate", "[rate]") {
  CHECK(Case(9.7).choose(1e-9).rate_hz > Case(1.3).choose(1e-9).rate_hz);
}

TEST_CASE("A rate that costs more than its share of a processor is not taken", "[rate]") {
  Case one(1.3);
  one.scene.processor_share = 0.031;  // a step takes 2 ms: 15 Hz
  const RateChoice choice = one.choose(2e-3);
  CHECK(choice.keeps_share);
  CHECK(choice.rate_hz < 15.5);
  CHECK(trial_at(choice, 33.0).refusal == "costs more than its share");
  CHECK(*trial_at(choice, 33.0).processor_share == Approx(0.066).epsilon(0.05));
  CHECK(trial_at(choice, 1000.0).refusal == "cannot keep its rate");

  one.scene.processor_share = 0.001;
  const RateChoice cheapest = one.choose(2e-3);
  CHECK_FALSE(cheapest.keeps_share);
  CHECK(cheapest.rate_hz == 10.0);
}

TEST_CASE("A choice ends with its budget, with what is known by then", "[rate]") {
  const Case one(4.3);
  for (const double budget_s : {1e-3, 1.0, 30.0}) {
    const RateChoice choice = one.choose(1e-2, budget_s);
    CAPTURE(budget_s, choice.watched_s);
    CHECK(choice.watched_s < 0.9);
    CHECK(choice.rate_hz >= 10.0);
    CHECK_FALSE(choice.keeps_force);
  }
}

TEST_CASE("On its own hand each scene that ships errs by less than is noticed", "[rate]") {
  const std::string name = GENERATE(as<std::string>{}, "tissue_and_blocks", "threads", "organ",
                                    "laparoscopy", "moving_sphere", "wall");
  CAPTURE(name);
  const scene::SceneDescription scene =
      scene::load_scene(std::string(STILLGRID_SCENES "/") + name + ".toml");
  REQUIRE(scene.hand);
  const HandPath hand(scene.hand->file, scene.device);
  const CostClock stopped = [] { return 0.0; };
  const TrueForce truth = true_force(scene, scene::build_world(scene), hand, 1.0, stopped);
  CHECK(std::ranges::count(truth.felt.touches, true) > 250);
  for (int run = 0; run < (tests::kIsSanitized ? 1 : 8); ++run) {
    const double first_share = 1.0 - run / 8.0;
    CAPTURE(first_share);
    const FeltForce felt = felt_force(
        scene, truth.start, hand,
        {.first_share = first_share, .duration_s = hand.duration_s(), .deadline_s = 1.0}, stopped);
    CHECK(force_error_share(felt, truth.felt) <= rendering::kJustNoticeable);
  }
}

TEST_CASE("A hand is followed evenly from row to row, in the scene's frame", "[rate]") {
  const tests::TestFolder folder;
  const auto file = folder.write("hand.csv",
                                 "# somebody's\nx_m, time_s,y_m,z_m,qx,qy,qz,qw,more\n"
                                 "0.1,3.5,0,0,0,0,0,1,7\n0.3,3.9,0,0.2,0,0,0.6,0.8,7\n");
  scene::DeviceFrame device;
  device.position_m = {0.0, 0.0, 1.0};
  device.scale = 2.0;
  device.orientation = Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ());
  const HandPath hand(file, device);
  CHECK(hand.duration_s() == Approx(0.4));
  CHECK((hand.at(0.1).position_m - Eigen::Vector3d(0.0, 0.3, 1.1)).norm() < 1e-12);
  CHECK((hand.at(-1.0).position_m - Eigen::Vector3d(0.0, 0.2, 1.0)).norm() < 1e-12);
  CHECK((hand.at(9.0).position_m - Eigen::Vector3d(0.0, 0.6, 1.4)).norm() < 1e-12);
  const double turn_rad = std::numbers::pi / 2.0 + 0.5 * 2.0 * std::atan2(0.6, 0.8);
  CHECK(Eigen::AngleAxisd(hand.at(0.2).orientation).angle() == Approx(turn_rad));
}

TEST_CASE("A hand in millimetres is the same as in metres", "[rate]") {
  const tests::TestFolder folder;
  const HandPath metres(folder.write("m.csv", "time_s,x_m,y_m,z_m\n0,0.1,0,0.02\n1,0.2,0,0\n"), {});
  const HandPath other(
      folder.write("mm.csv", "\xEF\xBB\xBFt_s,x_mm,y_m,z_mm\n0,100,0,20\n1,200,0,0\n"), {});
  for (const double time_s : {0.0, 0.3, 1.0})
    CHECK(other.at(time_s).position_m.isApprox(metres.at(time_s).position_m));
}

TEST_CASE("What is no path of a hand is refused in a line that names file, line and column",
          "[rate]") {
  const tests::TestFolder folder;
  const std::string header = "time_s,x_m,y_m,z_m\n";
  const std::pair<std::string, std::string> cases[] = {
      {"", ": no whole header line"},
      {"time_s,x_m,y_m\n", ":1: column z_m"},
      {"time_s,x_m,y_m,z_m,qx\n", ":1: column qy"},
      {header + "0,0,0,0\n", ": one row: expected two at least"},
      {header + "1,0,0,0\n0,0,0,0\n", ":3: column time_s"},
      {header + "0,0,0,0\n1,0,nan,0\n", ":3: column y_m"},
      {header + "0,0,0,0\n1,0,0\n", ":3: column time_s: value '1': expected a row of 4 fields"},
      {header + "0,0,0,2e6\n", ":2: column z_m"},
      {"time_s,x_m,y_m,z_m,qx,qy,qz,qw\n0,0,0,0,0,0,0,2\n", ":2: column qw"},
      {header + "0,0,0,0,7\n1,0,0,0\n", ":2: column time_s: value '0': expected a row of 4"},
      {"time_s,x_m,x_m,y_m,z_m\n0,0,0,0,0\n1,0,0,0,0\n", ":1: column x_m: given twice"},
      {"# scene: x\n" + header + "0,0,0,0\n1,0,0,0\n", ": a recording of haptic_server"},
      {"time_s,x_m,y_m,z_m,rendered_fx_N\n0,0,0,0,0\n", ": a recording of haptic_server"}};
  for (const auto& [text, words] : cases) {
    CAPTURE(text);
    const auto file = folder.write("hand.csv", text);
    CHECK_THROWS_WITH(HandPath(file, {}), Catch::Contains("hand.csv" + words));
  }
  for (const auto& path : {folder.path / "none.csv", folder.path})
    CHECK_THROWS_WITH(HandPath(path, {}), Catch::Contains("cannot be read"));
}

}  // namespace
}  // namespace stillgrid::sim_server::rate_choice_test
