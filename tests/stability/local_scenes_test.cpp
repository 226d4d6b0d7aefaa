// The shipped scenes under their own hands: the force is that of 1 kHz at every rate of snapshots.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <string>

#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/lab.hpp"

namespace stillgrid::laboratory::local_scenes_test {
namespace {

LabRun run_at(scene::SceneDescription scene, double rate_hz, double latency_share, double jitter) {
  scene.period_s = 1.0 / rate_hz;
  LabOptions options;
  options.device = "replay:file=" + scene.hand->file.string();
  options.latency_s = latency_share * scene.period_s;
  options.jitter = jitter;
  options.seed = 5;
  options.duration_s = 1.5;
  return run_lab(scene, options);
}

/// Ticks of which the force differs by a bit, once the first snapshot has come.
std::size_t differing(const LabRun& a, const LabRun& b, std::size_t from) {
  std::size_t count = 0;
  for (std::size_t i = from; i < a.rows.size(); ++i)
    if (a.rows[i].rendered_N != b.rows[i].rendered_N) ++count;
  return count;
}

std::string sphere(const std::string& name, double x_m, double y_m, double z_m, const char* more) {
  return "[[body]]\nname = \"" + name +
         "\"\nkind = \"sphere\"\nradius_m = 0.01\nmaterial = \"m\"\n" + more + "position_m = [" +
         std::to_string(x_m) + ", " + std::to_string(y_m) + ", " + std::to_string(z_m) + "]\n";
}

std::uint64_t local_ticks(const std::string& bodies) {
  const std::string scene =
      "format = 2\n[simulation]\nrate_hz = 100.0\n[[material]]\nname = \"m\"\n"
      "contact_stiffness_N_per_m = 500.0\n";
  return run_lab(scene::read_scene(scene + bodies, "spheres.toml"),
                 {.device = "phantom:hand=light,path=press,depth_m=0.03", .duration_s = 0.5})
      .report.local;
}

}  // namespace

TEST_CASE(
    "Balls on thousands of spheres that never move are local, a pile of as many balls is not") {
  std::string cover, pile;  // the outer balls may reach the whole cover
  for (const double at_m : {-0.36, 0.0, 0.35})
    cover += sphere("ball" + std::to_string(at_m), at_m, at_m, 0.019, "mass_kg = 0.05\n");
  for (int i = 0; i < 5184; ++i) {
    const double x_m = 0.01 * (i % 72 - 36), y_m = 0.01 * (i / 72 - 36);
    cover += sphere("s" + std::to_string(i), x_m, y_m, 0.0, "motion = \"static\"\n");
    pile += sphere("b" + std::to_string(i), 2.0 * x_m, 2.0 * y_m, 0.0, "mass_kg = 0.004\n");
  }
  CHECK(local_ticks(cover) > 450);
  CHECK(local_ticks(pile) == 0);
}

TEST_CASE("A shipped scene's force is equal to the bit at 1 kHz and at 10, 33 and 100 Hz") {
  const std::string name = GENERATE("laparoscopy", "moving_sphere", "organ", "pendulum_chain",
                                    "sewn_ball", "threads", "tissue_and_blocks", "wall");
  CAPTURE(name);
  const scene::SceneDescription scene = scene::load_scene(
      std::string(STILLGRID_SOURCE_DIR) + "/sim_server/scene/scenes/" + name + ".toml");
  const LabRun truth = run_at(scene, 1000.0, 0.0, 0.0);
  REQUIRE(truth.rows.size() == 1500);
  double felt_N = 0.0;
  for (const recording::TickRow& row : truth.rows) felt_N = std::max(felt_N, row.rendered_N.norm());
  for (const double rate_hz : {10.0, 33.0, 100.0}) {
    CAPTURE(rate_hz);
    const LabRun run = run_at(scene, rate_hz, 1.5, 0.4);
    REQUIRE(run.rows.size() == truth.rows.size());
    CHECK(run.report.local > 1400);
    CHECK(differing(truth, run, 0) == 0);
  }
  if (name == "wall" || name == "tissue_and_blocks") CHECK(felt_N > 0.1);
}

}  // namespace stillgrid::laboratory::local_scenes_test
