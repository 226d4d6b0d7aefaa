// Candidates against their reference: errors with closed answers, and where they start.

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/fit_run/fit_candidate.hpp"
#include "tests/laboratory/fit_run/fit_scene.hpp"
#include "tests/stability/fit_run/fit_files.hpp"

namespace stillgrid::fit_run::fit_run_test {
namespace {

constexpr double kDepth_m = 0.012, kSpeed_m_s = 0.1;

/// Rides with the sphere of moving_sphere, pressed by kDepth_m, or more and less at 1 Hz.
std::string ride(double duration_s, double amplitude_m = 0.0) {
  return trajectory_text(duration_s, [=](double t_s) {
    const double depth_m = kDepth_m + amplitude_m * std::sin(2.0 * std::numbers::pi * t_s);
    return Eigen::Vector3d(-0.05 + kSpeed_m_s * t_s + 0.015 - depth_m, 0.0, 0.0);
  });
}

scene::SceneDescription moving_sphere(const std::vector<std::string>& settings = {}) {
  return load_scene_with(find_scene("moving_sphere"), settings);
}

FitReference reference_of(const scene::SceneDescription& scene, const FitPath& path,
                          double settle_s = 0.0, int steps_per_tick = 1) {
  laboratory::LabRun run;
  return make_reference(scene, path, steps_per_tick, settle_s, run);
}

TEST_CASE("A candidate that is the reference errs by nothing, to the bit", "[fit_run]") {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("ride.csv", ride(0.5, 0.002))};
  const FitReference reference = reference_of(moving_sphere(), path);
  const FitResult result = run_candidate({.scene = moving_sphere({"simulation.rate_hz=1000"}),
                                          .transition = display::Transition::kHold,
                                          .latency_share = 0.0,
                                          .repeats = 2},
                                         path, reference);
  CHECK(result.error.rms_N == 0.0);
  CHECK(result.error.share == 0.0);
  CHECK(result.error.rms_at_lag_share == 0.0);
  CHECK(result.error.jnd_p95 == 0.0);
  CHECK(result.error.felt_share == 0.0);
  CHECK(result.simulation.steps == 499);
  REQUIRE(result.cost);
  CHECK(result.cost->processor_us_per_ms > result.cost->simulation_us_per_ms);
  CHECK(result.cost->simulation_us_per_ms > 0.0);
}

TEST_CASE("Of a body in steady motion, snapshots held at 10 Hz err by v times their age",
          "[fit_run]") {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("ride.csv", ride(2.0))};
  const FitReference reference = reference_of(moving_sphere(), path);
  CHECK(reference_force(reference.rows).rms_N == Approx(500.0 * kDepth_m).epsilon(1e-4));
  CHECK(reference_force(reference.rows).contact_share == 1.0);
  const FitResult result = run_candidate({.scene = moving_sphere({"simulation.rate_hz=10"}),
                                          .transition = display::Transition::kHold,
                                          .latency_share = 0.0},
                                         path, reference);
  // Ages of 0 to 99 ms, each as often: the mean of their squares is (n - 1)(2 n - 1) / 6.
  const double rms_age_s = 1e-3 * std::sqrt(99.0 * 199.0 / 6.0);
  CHECK(*result.error.share == Approx(kSpeed_m_s * rms_age_s / kDepth_m).epsilon(1e-3));
  CHECK(*result.error.rms_N == Approx(500.0 * kSpeed_m_s * rms_age_s).epsilon(1e-3));
  // 7 % of the force is v times 8.4 ms: beyond it are ages of 9 to 99 ms; 95 % are up to 94 ms.
  CHECK(*result.error.felt_share == Approx(0.91));
  CHECK(*result.error.jnd_p95 == Approx(kSpeed_m_s * 0.094 / (0.07 * kDepth_m)).epsilon(1e-3));
  // A jump of 5 N, to 6 N.
  CHECK(*result.switch_jump_jnd_max == Approx(5.0 / 6.0 / 0.07).epsilon(1e-3));
}

TEST_CASE("A difference is noticed from 7 % of the force on, and from 7 mN on", "[fit_run]") {
  CHECK(just_noticeable_N({0.0, 2.0, 0.0}) == Approx(0.14));
  CHECK(just_noticeable_N({0.0, 0.0, 0.01}) == Approx(0.007));
}

TEST_CASE("A step's share is imitated in tenths, rounded up", "[fit_run]") {
  CHECK(latency_share_of(0.04) == 0.0);
  CHECK(latency_share_of(0.06) == Approx(0.1));
  CHECK(latency_share_of(0.31) == Approx(0.4));
  CHECK(latency_share_of(0.95) == Approx(1.0));
}

TEST_CASE("Snapshots are late by the share of a period that was given", "[fit_run]") {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("ride.csv", ride(1.0))};
  const FitReference reference = reference_of(moving_sphere(), path);
  const auto share = [&](double latency_share) {
    return *run_candidate({.scene = moving_sphere({"simulation.rate_hz=50"}),
                           .transition = display::Transition::kHold,
                           .latency_share = latency_share},
                          path, reference)
                .error.share;
  };
  CHECK(share(0.5) > 1.5 * share(0.0));  // ages of 10 to 30 ms, not 0 to 20
}

TEST_CASE("A run with settings is to the bit that of the file with those values", "[fit_run]") {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("ride.csv", ride(0.4, 0.002))};
  const auto given = find_scene("moving_sphere");
  const FitReference reference = reference_of(scene::load_scene(given), path);
  std::string text = text_of(given);
  text.replace(text.find("period_s = 0.033"), 16, "rate_hz = 70.3");
  text.replace(text.find("radius_m = 0.01"), 15, "radius_m = 0.0101");
  text += "stiffness_scale = 1.7\n";
  const auto edited = folder.write("moving_sphere.toml", text);
  const auto error_of = [&](const scene::SceneDescription& scene) {
    return run_candidate({.scene = scene, .latency_share = 0.1}, path, reference).error;
  };
  const FitError by_file = error_of(scene::load_scene(edited));
  const FitError by_settings =
      error_of(load_scene_with(given, {"simulation.rate_hz=70.3", "body.sphere.radius_m=0.0101",
                                       "body.sphere.stiffness_scale=1.7"}));
  CHECK(*by_file.share > 0.5);  // 70 % too stiff
  CHECK(by_file.share == by_settings.share);
  CHECK(by_file.rms_at_lag_share == by_settings.rms_at_lag_share);
  CHECK(by_file.jnd_p95 == by_settings.jnd_p95);
}

constexpr const char* kFalling = R"(format = 2
[simulation]
rate_hz = 50.0
[[material]]
name = "m"
contact_stiffness_N_per_m = 500.0
contact_damping_N_s_per_m = 1.0
friction = 0.3
[[body]]
name = "floor"
kind = "plane"
normal = [0.1, 0.0, 1.0]
material = "m"
[[body]]
name = "block"
kind = "rigid_box"
position_m = [0.0, 0.0, 0.03]
size_m = [0.03, 0.03, 0.02]
mass_kg = 0.02
angular_velocity_rad_s = [3.0, 1.0, 0.0]
spheres = { spacing_m = 0.01, radius_m = 0.005 }
material = "m"
[[body]]
name = "thread"
kind = "thread"
nodes = 4
from_m = [0.1, 0.0, 0.1]
to_m = [0.2, 0.0, 0.1]
mass_kg = 0.01
pinned = "start"
spring_stiffness_N_per_m = { structural = 100.0 }
material = "m"
)";

bool same_state(const laboratory::WorldState& a, const laboratory::WorldState& b) {
  bool same = a.time_s == b.time_s && a.nodes.size() == b.nodes.size() &&
              a.rigid_bodies.size() == b.rigid_bodies.size();
  for (std::size_t i = 0; same && i < a.nodes.size(); ++i)
    same = a.nodes[i].position_m == b.nodes[i].position_m &&
           a.nodes[i].velocity_m_s == b.nodes[i].velocity_m_s;
  for (std::size_t i = 0; same && i < a.rigid_bodies.size(); ++i)
    same = a.rigid_bodies[i].position_m == b.rigid_bodies[i].position_m &&
           a.rigid_bodies[i].velocity_m_s == b.rigid_bodies[i].velocity_m_s &&
           a.rigid_bodies[i].orientation.coeffs() == b.rigid_bodies[i].orientation.coeffs() &&
           a.rigid_bodies[i].angular_velocity_rad_s == b.rigid_bodies[i].angular_velocity_rad_s;
  return same;
}

TEST_CASE("Every candidate starts from the world that the reference settled, to the bit",
          "[fit_run]") {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("press.csv", trajectory_text(0.6, [](double t_s) {
                                                  return Eigen::Vector3d(0.0, 0.0,
                                                                         0.05 - 0.07 * t_s);
                                                }))};
  const scene::SceneDescription scene = scene::load_scene(folder.write("falling.toml", kFalling));
  const FitReference made = reference_of(scene, path, 0.15);
  CHECK(made.start.time_s == Approx(0.15));
  CHECK(made.start.rigid_bodies[0].position_m.z() < 0.025);  // it fell
  CHECK(made.start.rigid_bodies[0].angular_velocity_rad_s.norm() > 0.1);
  write_reference(folder.path / "ref.csv", scene, made);

  const scene::SceneDescription other =
      load_scene_with(folder.path / "falling.toml",
                      {"simulation.rate_hz=20", "simulation.integrator='velocity_verlet'",
                       "body.block.spheres.spacing_m=0.02"});
  const FitReference read = read_reference(folder.path / "ref.csv", other);
  CHECK(same_state(read.start, made.start));
  REQUIRE(read.rows.size() == made.rows.size());
  for (std::size_t i = 0; i < read.rows.size(); ++i)
    REQUIRE(read.rows[i].rendered_N == made.rows[i].rendered_N);
  REQUIRE(read.presses.size() == made.presses.size());
  REQUIRE_FALSE(read.presses.empty());
  CHECK(read.presses[0].press_s == made.presses[0].press_s);
  CHECK(same_state(read.presses[0].world, made.presses[0].world));

  laboratory::LabOptions options = path_options(path);
  options.start = &read.start;
  options.state_interval_s = 0.05;
  const laboratory::LabRun run = laboratory::run_lab(other, options);
  CHECK(same_state(run.states.at(0), made.start));
  CHECK(run.states.at(1).time_s == Approx(made.start.time_s + 0.05));
}

TEST_CASE("Prescribed bodies go on from the time at which a run starts", "[fit_run]") {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("still.csv", trajectory_text(0.1, [](double) {
                                                  return Eigen::Vector3d(0.0, 0.0, 0.0);
                                                }))};
  const FitReference reference = reference_of(moving_sphere(), path, 0.4);  // 5 mm deep by then
  CHECK(reference.start.rigid_bodies[0].position_m.x() == Approx(-0.01));
  CHECK(reference.rows[0].rendered_N.x() == Approx(500.0 * 0.005).epsilon(1e-3));
  CHECK(reference.rows[50].rendered_N.x() == Approx(500.0 * 0.01).epsilon(1e-3));
}

TEST_CASE("The strongest presses are peaks half a second apart", "[fit_run]") {
  std::vector<recording::TickRow> rows(3000);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].time_s = 1e-3 * static_cast<double>(i);
    const auto peak = [&](double at, double force_N) {
      return std::max(0.0, force_N * (1.0 - std::abs(static_cast<double>(i) - at) / 150.0));
    };
    rows[i].rendered_N.z() = std::max(
        {peak(400, 2.0), peak(700, 1.9), peak(1300, 3.0), peak(2200, 1.0), peak(2800, 0.2)});
  }
  CHECK(strongest_presses(rows) == std::vector<std::size_t>{1300, 400, 2200});
  CHECK(strongest_presses(std::vector<recording::TickRow>(10)).empty());
}

TEST_CASE("A reference of something else is refused in one line", "[fit_run]") {
  const tests::TestFolder folder;
  const FitPath path{.trajectory = folder.write("ride.csv", ride(0.1))};
  const scene::SceneDescription scene = moving_sphere();
  const auto file = folder.path / "ref.csv";
  const auto state = folder.path / "ref.state.csv";
  write_reference(file, scene, reference_of(scene, path));
  const std::string rows = text_of(file), worlds = text_of(state);
  const auto refusal = [&](const scene::SceneDescription& of) -> std::string {
    try {
      (void)read_reference(file, of);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  CHECK(refusal(scene).empty());
  const scene::SceneDescription falling = scene::load_scene(folder.write("falling.toml", kFalling));
  CHECK(refusal(falling) ==
        state.string() +
            ":2: value 'start,sphere,0': expected node 0 of body 'block' of the "
            "scene, at moment 'start'");
  folder.write("ref.state.csv", worlds.substr(0, worlds.rfind(',')) + ",nan\n");
  CHECK(refusal(scene).find("value 'nan': expected a number") != std::string::npos);
  folder.write("ref.state.csv", "body,node\n");
  CHECK(refusal(scene).find(":1: value 'body,node': expected the columns moment,") !=
        std::string::npos);
  folder.write("ref.state.csv", worlds);
  folder.write("ref.csv", rows.substr(0, rows.size() - 20));
  CHECK(refusal(scene).find("expected 8 values") != std::string::npos);
  folder.write("ref.csv", rows.substr(rows.find("time_s")));
  CHECK(refusal(scene).find("expected a line '# settle_s: NUMBER'") != std::string::npos);
  struct Slip {
    std::string of, by, expected;
  };
  const std::string first = rows.substr(rows.find("contacts\n") + 9);
  const std::string row = first.substr(0, first.find('\n'));
  for (const auto& [of, by, expected] : {
           Slip{"# settle_s: 0", "# settle_s: -1", ":2: value '-1': expected a line '# settle_s: "},
           Slip{"# settle_s: 0", "# settle_s: 1e9", "a number from 0 to 600"},
           Slip{first, "", "ref.csv: expected rows"},
           Slip{"\n" + row, "\n" + row + "\n" + row, "a time after that of the row before"},
           Slip{"\n" + row, "\n-1" + row.substr(1), "value '-1': expected a number from 0"},
           Slip{row, row.substr(0, row.rfind(',')) + ",1e300",
                "value '1e300': expected a number from 0"},
           Slip{row, row.substr(0, row.rfind(',')) + ",-1", "value '-1': expected a number from 0"},
           Slip{row, row.substr(0, row.rfind(',')) + ",0.5", "expected a number of contacts"},
           Slip{row, "0,1e308" + row.substr(row.find(',', 2)),
                "value '1e308': expected a number from"},
           Slip{row, "0,0,0,0,1e308,0,0,1", "value '1e308': expected a number from"},
           Slip{"_begin_s: ", "_begin_s: 1", "expected a line '# press_1_begin_s: "},
           Slip{"_begin_s: ", "_begin_s: -3", "expected a line '# press_1_begin_s: "},
           Slip{"# press_1_s: ", "# press_1_s: 9", "expected a line '# press_1_s: "},
           Slip{"# press_1_s: ", "# press_1_s: -5", "expected a line '# press_1_s: "},
       }) {
    std::string slipped = rows;
    const std::size_t at = slipped.find(of);
    REQUIRE(at != std::string::npos);
    folder.write("ref.csv", slipped.replace(at, of.size(), by));
    INFO(of << " -> " << by);
    CHECK_THAT(refusal(scene), Catch::Contains(expected));
  }
  folder.write("ref.csv", rows);
  CHECK_THROWS_WITH(read_reference(folder.path / ".", scene), Catch::EndsWith("expected a file"));

  const FitPath slower{.trajectory = folder.write("other.csv", ride(0.1, 0.001))};
  CHECK_THROWS_WITH(
      run_candidate({.scene = scene, .latency_share = 0.0}, slower, read_reference(file, scene)),
      Catch::StartsWith("--reference: at 0.001 s the tool is elsewhere"));
}

}  // namespace
}  // namespace stillgrid::fit_run::fit_run_test
