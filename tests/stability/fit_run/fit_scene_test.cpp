// Scenes with other values, as scene_fit asks for them.

#include "tests/laboratory/fit_run/fit_scene.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/fit_run/fit_candidate.hpp"
#include "tests/stability/fit_run/fit_files.hpp"

namespace stillgrid::fit_run::fit_scene_test {
namespace {

constexpr const char* kScene = R"(format = 2
[simulation]
period_s = 0.03
integrator = "implicit_euler"
tolerance_m_s = 1e-6
[[material]]
name = "felt"
contact_stiffness_N_per_m = 400.0
[[body]]
name = "cloth.fine"
kind = "sheet"
motion = "static"
nodes = [2, 2]
size_m = [0.16, 0.16]
spheres = { spacing_m = 0.01, radius_m = 0.0065 }
material = "felt"
[[body]]
name = "cloth"
kind = "sphere"
motion = "static"
position_m = [0.0, 0.0, -1.0]
radius_m = 0.1
material = "felt"
)";

scene::SceneDescription with(const std::vector<std::string>& settings) {
  return scene::read_scene(with_settings(kScene, settings), "scene.toml");
}

std::string refusal(const std::vector<std::string>& settings) {
  const tests::TestFolder folder;
  const auto file = folder.write("scene.toml", kScene);
  try {
    (void)load_scene_with(file, settings);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("A setting is a value in the file, in tables that exist or not", "[fit_scene]") {
  const scene::SceneDescription scene =
      with({"grid.voxel_ratio=2", "body.cloth.fine.spheres.spacing_m=0.02",
            "body.cloth.stiffness_scale=1.96",
            "material.felt.contact_stiffness_N_per_m=123.456789012345678",
            "world.gravity_m_s2=[0, 0, -1.5]"});
  CHECK(scene.voxel_ratio == 2.0);
  const bodies::SpherePacking spheres = std::get<bodies::SheetBody>(scene.bodies[0].shape).spheres;
  CHECK(spheres.spacing_m == 0.02);
  CHECK(spheres.radius_m == 0.0065);
  CHECK(scene.bodies[1].stiffness_scale == 1.96);
  CHECK(scene.materials[0].contact_stiffness_N_per_m == 123.456789012345678);
  CHECK(scene.gravity_m_s2.z() == -1.5);
  CHECK(scene.method.tolerance_m_s == 1e-6);  // what is not set stays
}

TEST_CASE("What a setting contradicts goes, unless it is set too", "[fit_scene]") {
  CHECK(with({"simulation.rate_hz=50"}).period_s == 0.02);
  CHECK(with({"simulation.period_s=0.04"}).period_s == 0.04);

  const scene::SceneDescription other = with({"simulation.integrator='velocity_verlet'"});
  CHECK(other.method == scene::Method{.integrator = scene::IntegratorKind::kVelocityVerlet});
  const scene::SceneDescription both =
      with({"simulation.tolerance_m_s=1e-4", "simulation.integrator='cvode_bdf'"});
  CHECK(both.method ==
        scene::Method{.integrator = scene::IntegratorKind::kCvodeBdf, .tolerance_m_s = 1e-4});

  const scene::SceneDescription chosen = with({"simulation.integrator='auto'"});
  CHECK(chosen.choose_method);
  const std::string automatic =
      "format = 2\n[simulation]\nintegrator = 'auto'\nerror_target_m = 1e-4\n";
  CHECK_FALSE(
      scene::read_scene(with_settings(automatic, {"simulation.integrator='cvode_bdf'"}), "s.toml")
          .choose_method);

  const std::string text = with_settings("[[body]]\nname = 'b'\nspheres = { file = 'b.csv' }\n",
                                         {"body.b.spheres.tolerance_m=0.01"});
  CHECK(text.find("b.csv") == std::string::npos);
  CHECK(text.find("tolerance_m = 0.01") != std::string::npos);
}

TEST_CASE("A bad setting is refused in one line that shows it", "[fit_scene]") {
  struct Bad {
    std::string setting, expected;
  };
  for (const auto& [setting, expected] : {
           Bad{"simulation.rate_hz", "--set: value 'simulation.rate_hz': expected KEY=VALUE"},
           Bad{"=3", "--set: value '=3': expected KEY=VALUE"},
           Bad{"simulation.integrator=auto",
               "--set: value 'simulation.integrator=auto': expected KEY=VALUE with a value as "
               "TOML"},
           Bad{"body.silk.stiffness_scale=2",
               "--set: value 'body.silk.stiffness_scale=2': expected body.NAME.KEY with one of the "
               "scene's: cloth.fine, cloth"},
           Bad{"material.felt=2", "--set: value 'material.felt=2': expected material.NAME.KEY"},
           Bad{"format=2", "--set: value 'format=2': expected TABLE.KEY=VALUE"},
           Bad{"body.cloth.fine.spheres=3",
               "--set: value 'body.cloth.fine.spheres=3': expected "
               "TABLE.KEY=VALUE"},
           Bad{"simulation.period_s.x=3",
               "--set: value 'simulation.period_s.x=3': expected a key of a table"},
           Bad{"simulation..x=3", "--set: value 'simulation..x=3': expected KEY=VALUE with a key"},
           Bad{"simulation.rate_hz=1\n[body]",
               "--set: value 'simulation.rate_hz=1 [body]': expected KEY=VALUE with a value as "
               "TOML"},
           Bad{"simulation.speed=3",
               "--set: value 'simulation.speed=3': simulation.speed: value 3: expected no such "
               "key"},
           Bad{"body.cloth.fine.spheres.spacing_m=-1",
               "--set: value 'body.cloth.fine.spheres.spacing_m=-1': body.spheres.spacing_m: value "
               "-1: expected a number from"},
       }) {
    const std::string line = refusal({setting});
    CHECK(line.substr(0, expected.size()) == expected);
    CHECK(line.find('\n') == std::string::npos);
  }
}

TEST_CASE("What is wrong with the file itself is told of the file", "[fit_scene]") {
  const tests::TestFolder folder;
  for (const std::string& text : std::vector<std::string>{
           "format = 2\nbody = {", "format = 2\n[simulation]\nspeed = 3\n", "format = 1\n"}) {
    const auto file = folder.write("scene.toml", text);
    CHECK_THROWS_WITH(load_scene_with(file, {"grid.voxel_ratio=2"}),
                      Catch::StartsWith(file.string() + ":"));
  }
}

TEST_CASE("A scene is a file, or one that ships", "[fit_scene]") {
  CHECK(find_scene("organ").filename() == "organ.toml");
  const tests::TestFolder folder;
  const auto file = folder.write("mine.toml", "format = 2\n");
  CHECK(find_scene(file.string()) == file);
  CHECK_THROWS_WITH(
      find_scene("nowhere"),
      "SCENE: value 'nowhere': expected a scene file, or the name of a scene that ships");
}

/// The force of a sheet, mean over a period of its spheres along both sides, times their count.
double mean_force_N(const std::vector<std::string>& settings) {
  constexpr int kPlaces = 40;
  const tests::TestFolder folder;
  FitPath path;
  path.trajectory = folder.write(
      "raster.csv", trajectory_text(1e-3 * kPlaces * kPlaces, [](double t_s) {
        const int i = static_cast<int>(std::lround(1e3 * t_s));
        const int row = i / kPlaces, along = i % kPlaces;  // to and fro, without a leap
        const int column = row % 2 == 0 ? along : kPlaces - 1 - along;
        return Eigen::Vector3d(5e-4 * column, 5e-4 * row, 0.008);
      }));
  laboratory::LabOptions options = path_options(path);
  options.transition = display::Transition::kHold;
  Eigen::Vector3d sum_N = Eigen::Vector3d::Zero();
  const laboratory::LabRun run = laboratory::run_lab(with(settings), options);
  for (const recording::TickRow& row : run.rows) sum_N += row.rendered_N;
  return sum_N.z() / static_cast<double>(run.rows.size());
}

TEST_CASE("Fewer spheres of a sheet, stiffer by the square of their distance, keep its mean force",
          "[fit_scene]") {
  const std::string coarse = "body.cloth.fine.spheres.spacing_m=0.02";
  const double given_N = mean_force_N({});
  REQUIRE(given_N > 0.1);
  CHECK(mean_force_N({coarse}) == Approx(given_N / 4.0).epsilon(2e-3));
  CHECK(mean_force_N({coarse, "body.cloth.fine.stiffness_scale=4"}) ==
        Approx(given_N).epsilon(2e-3));
}

}  // namespace
}  // namespace stillgrid::fit_run::fit_scene_test
