// What a hand feels of a scene, and how it is judged.

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <sstream>
#include <string>

#include "shared/rendering/force_error.hpp"
#include "sim_server/judge.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "sim_server/try_files.hpp"
#include "tests/laboratory/lab.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/sim_server/scene_builders.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::sim_server::chooser_test {
namespace {

/// A ball goes to and fro below a hand that presses it, on a path of its own: nothing but the rate
/// makes the force err.
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
rate_hz = 100
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
};

TEST_CASE("What is felt is what both servers in lockstep let a replayed hand feel", "[chooser]") {
  Case one(3.1);
  one.scene.period_s = 1.0 / 47.0;
  const HandPath hand(one.scene.hand->file, one.scene.device);
  const HandRun felt = run_hand(one.scene, {scene::build_world(one.scene)}, hand,
                                {.latency_s = 0.3 / 47.0, .duration_s = 0.9});
  laboratory::LabOptions options;
  options.device = "replay:file=" + one.scene.hand->file.string();
  options.transition = display::Transition::kLocal;
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

TEST_CASE("Scene files are judged line by line, and a bad one is refused in its record",
          "[chooser]") {
  const Case one(4.3);
  const std::string ball = one.folder
                               .write("half.toml",
                                      [&] {
                                        std::string text = R"(
format = 2
simulation.rate_hz = 500
[device]
position_m = [0.01, 0.0, 0.002]
[[material]]
name = "ball"
contact_stiffness_N_per_m = 155.0
[[body]]
name = "ball"
kind = "sphere"
motion = "prescribed"
direction = [0.0, 0.0, 1.0]
amplitude_m = 0.004
frequency_hz = 4.3
radius_m = 0.013
material = "ball"
)";
                                        return text;
                                      }())
                               .string();
  std::istringstream lines(ball + " hold\n" + ball + " nowhere\n\nmissing.toml hold\n");
  std::ostringstream records;
  try_files(one.scene, lines, records);
  std::istringstream read(records.str());
  std::string half, bad, missing, more;
  std::getline(read, half);
  std::getline(read, bad);
  std::getline(read, missing);
  CHECK_FALSE(std::getline(read, more));
  // Half the stiffness, with no spring below it: half the force.
  const std::size_t at = half.find("\"error_share\":");
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(half.substr(at + 14)) == Approx(0.5).margin(0.03));
  CHECK(half.find("\"refusal\":\"\"") != std::string::npos);
  CHECK(bad.find("expected FILE TRANSITION") != std::string::npos);
  CHECK(missing.find("missing.toml") != std::string::npos);
}

TEST_CASE("On its own hand each scene that ships errs by what is noticed at most", "[chooser]") {
  const std::string name = GENERATE(as<std::string>{}, "tissue_and_blocks", "threads", "organ",
                                    "laparoscopy", "moving_sphere", "wall");
  CAPTURE(name);
  const scene::SceneDescription scene =
      scene::load_scene(std::string(STILLGRID_SCENES "/") + name + ".toml");
  REQUIRE(scene.hand);
  const Judge judge(scene);
  CHECK(std::ranges::count(judge.truth().run.touches, true) > 250);
  const bool is_chaotic = name == "tissue_and_blocks";  // where its blocks come to rest
  CHECK(judge.truth().error_share < (is_chaotic ? 0.06 : 0.02));
  const Record record = judge.judge({.record = {}, .scene = scene});
  CHECK(record.refusal.empty());
  REQUIRE(record.error_share);
  CHECK(*record.error_share <= (is_chaotic ? 1.2 : 1.0) * rendering::kJustNoticeable);
}

TEST_CASE("A hand is followed evenly from row to row, in the scene's frame", "[chooser]") {
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

TEST_CASE("A hand in millimetres is the same as in metres", "[chooser]") {
  const tests::TestFolder folder;
  const HandPath metres(folder.write("m.csv", "time_s,x_m,y_m,z_m\n0,0.1,0,0.02\n1,0.2,0,0\n"), {});
  const HandPath other(
      folder.write("mm.csv", "\xEF\xBB\xBFt_s,x_mm,y_m,z_mm\n0,100,0,20\n1,200,0,0\n"), {});
  for (const double time_s : {0.0, 0.3, 1.0})
    CHECK(other.at(time_s).position_m.isApprox(metres.at(time_s).position_m));
}

TEST_CASE("What is no path of a hand is refused in a line that names file, line and column",
          "[chooser]") {
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
}  // namespace stillgrid::sim_server::chooser_test
