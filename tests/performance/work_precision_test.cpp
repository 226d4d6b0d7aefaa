#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "tests/performance/work_precision_bullet.hpp"
#include "tests/performance/work_precision_mujoco.hpp"
#include "tests/performance/work_precision_reference.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kNoLimit_s = 1e3;

/// Exponent of an error over the step, from the errors of a step and of one of half its length.
double order(double coarse, double fine) {
  return std::log2(coarse / fine);
}

ChartPoint point_of(scene::IntegratorKind integrator, double step_s) {
  ChartPoint point;
  point.period_s = step_s;
  point.method = {.integrator = integrator, .substeps = 1, .tolerance_m_s = 1e-12};
  return point;
}

/// Error of a method of ours on the chain whose motion is known exactly, after half a second.
double chain_error_m(scene::IntegratorKind integrator, double step_s) {
  const ChartScene scene = chain_modes_scene();
  const RunResult run = run_ours(scene, point_of(integrator, step_s), kNoLimit_s);
  return errors_of(scene, run, make_reference(scene).places_m).end_m;
}

double lowest_m(const Eigen::Matrix3Xd& places_m) {
  return places_m.row(2).minCoeff();
}

TEST_CASE("The charted cloths weigh 1 kg, span 1 m and have all the springs of theirs",
          "[work_precision]") {
  const auto [nodes, springs] =
      GENERATE(std::pair<int, std::size_t>{8, 306}, std::pair<int, std::size_t>{32, 5826});
  const bodies::World world = scene::build_world(cloth_scene(nodes, 1e4).scene);

  CHECK(world.springs.size() == springs);
  CHECK(std::count_if(world.nodes.begin(), world.nodes.end(),
                      [](const bodies::Node& node) { return node.pinned; }) == 2);
  CHECK(std::accumulate(world.nodes.begin(), world.nodes.end(), 0.0,
                        [](double sum, const bodies::Node& node) { return sum + node.mass_kg; }) ==
        Approx(1.0).epsilon(1e-12));
  CHECK((world.nodes.back().position_m - world.nodes.front().position_m).norm() ==
        Approx(std::sqrt(2.0)).epsilon(1e-12));
}

TEST_CASE("The reference follows a chain's modes and converges with order four",
          "[work_precision]") {
  const ChartScene chain = chain_modes_scene();
  const bodies::World world = scene::build_world(chain.scene);
  const auto error_m = [&](double step_s) {
    SpringReference reference(world);
    reference.advance_to(chain.end_s, step_s);
    return rms_distance_m(reference.positions_m(), chain_modes_positions_m(chain.end_s));
  };
  CHECK(order(error_m(2e-3), error_m(1e-3)) == Approx(4.0).margin(0.1));
  CHECK(error_m(1e-4) < 1e-10);

  const bodies::World cloth = scene::build_world(cloth_scene(8, 1e4).scene);
  const auto at = [&](double step_s) {
    SpringReference reference(cloth);
    reference.advance_to(0.25, step_s);
    return reference.positions_m();
  };
  const Eigen::Matrix3Xd coarse_m = at(4e-4), middle_m = at(2e-4), fine_m = at(1e-4);
  CHECK(order(rms_distance_m(coarse_m, middle_m), rms_distance_m(middle_m, fine_m)) ==
        Approx(4.0).margin(0.3));
}

TEST_CASE("Errors fall with the step as theory says", "[work_precision]") {
  using Kind = scene::IntegratorKind;
  const auto [integrator, expected] =
      GENERATE(std::pair{Kind::kSymplecticEuler, 1.0}, std::pair{Kind::kVelocityVerlet, 2.0},
               std::pair{Kind::kImplicitEuler, 1.0}, std::pair{Kind::kBdf2, 2.0},
               std::pair{Kind::kTrapezoid, 2.0});
  CAPTURE(scene::name_of(integrator));

  CHECK(order(chain_error_m(integrator, 4e-4), chain_error_m(integrator, 2e-4)) ==
        Approx(expected).margin(0.06));
}

TEST_CASE("A chain of Bullet's hangs as long as its springs say", "[work_precision]") {
  // Tip 53.955 mm below its unstretched length (docs/cases.md, case 3.4).
  const Eigen::Matrix3Xd places_m = bullet_at_rest_m(chain_modes_scene().scene, 1.0, 20);

  CHECK(-lowest_m(places_m) - 1.0 == Approx(0.053955).epsilon(1e-6));
}

TEST_CASE(
    "Bullet's implicit steps go where implicit Euler's go, its explicit ones where symplectic "
    "Euler's go",
    "[work_precision]") {
  ChartScene scene = GENERATE(chain_modes_scene(), cloth_scene(8, 1e3), cloth_scene(8, 1e5));
  scene.early_s = 0.05;
  scene.end_s = 0.1;
  const bool implicit = GENERATE(true, false);
  CAPTURE(scene.name, implicit);
  const double step_s = implicit ? 0.0025 : 0.0001;
  ChartPoint theirs;
  theirs.solver = implicit ? "implicit" : "explicit";
  theirs.period_s = step_s;

  const RunResult ours = run_ours(scene,
                                  point_of(implicit ? scene::IntegratorKind::kImplicitEuler
                                                    : scene::IntegratorKind::kSymplecticEuler,
                                           step_s),
                                  kNoLimit_s);
  const RunResult bullet = run_bullet(scene, theirs, kNoLimit_s);

  REQUIRE(ours.end == RunEnd::kDone);
  REQUIRE(bullet.end == RunEnd::kDone);
  // It solves its equations by one step of Newton's method.
  const double moved_m =
      rms_distance_m(ours.places_m[1], positions_m(scene::build_world(scene.scene)));
  CHECK(rms_distance_m(bullet.places_m[1], ours.places_m[1]) < (implicit ? 2e-3 : 1e-9) * moved_m);
}

ChartPoint mujoco_point(const std::string& solver, double step_s) {
  return {"mujoco", solver, "step_s", step_s, step_s, {}};
}

TEST_CASE("A chain of MuJoCo's hangs as long as its springs say", "[work_precision]") {
  // As Bullet's; steps are bounded by the springs.
  const Eigen::Matrix3Xd places_m = mujoco_at_rest_m(chain_modes_scene().scene, 0.007, 2000);

  CHECK(-lowest_m(places_m) - 1.0 == Approx(0.053955).epsilon(1e-6));
}

TEST_CASE("MuJoCo's Euler steps and its implicit ones go where symplectic Euler's go",
          "[work_precision]") {
  ChartScene scene = GENERATE(chain_modes_scene(), cloth_scene(8, 1e3), cloth_scene(8, 1e5));
  scene.early_s = 0.05;
  scene.end_s = 0.1;
  const std::string solver = GENERATE("euler", "implicit");
  CAPTURE(scene.name, solver);

  const RunResult ours =
      run_ours(scene, point_of(scene::IntegratorKind::kSymplecticEuler, 0.0001), kNoLimit_s);
  const RunResult mujoco = run_mujoco(scene, mujoco_point(solver, 0.0001), kNoLimit_s);

  REQUIRE(ours.end == RunEnd::kDone);
  REQUIRE(mujoco.end == RunEnd::kDone);
  const double moved_m =
      rms_distance_m(ours.places_m[1], positions_m(scene::build_world(scene.scene)));
  CHECK(rms_distance_m(mujoco.places_m[1], ours.places_m[1]) < 1e-9 * moved_m);
}

TEST_CASE("MuJoCo's errors fall with the step by the orders of its integrators",
          "[work_precision]") {
  ChartScene scene =
      GENERATE(chain_modes_scene(), cloth_scene(8, 1e3), cloth_scene(8, 1e4), cloth_scene(8, 1e5));
  scene.early_s = 0.05;
  scene.end_s = 0.1;
  const auto [solver, expected] = GENERATE(std::pair{"euler", 1.0}, std::pair{"rk4", 4.0});
  CAPTURE(scene.name, solver);
  const std::vector<Eigen::Matrix3Xd> reference_m = make_reference(scene).places_m;
  const auto error_m = [&, name = solver](double step_s) {
    const RunResult run = run_mujoco(scene, mujoco_point(name, step_s), kNoLimit_s);
    return errors_of(scene, run, reference_m).end_m;
  };
  // It divides both times.
  const double stable_s = SpringReference(scene::build_world(scene.scene)).stable_step_s();
  const double step_s = scene.early_s / std::ceil(scene.early_s / stable_s);

  CHECK(order(error_m(step_s), error_m(0.5 * step_s)) == Approx(expected).margin(0.15));
}

TEST_CASE("A run of MuJoCo's that blows up is not begun anew", "[work_precision]") {
  const std::string solver = GENERATE("euler", "rk4", "implicit");

  CHECK(run_mujoco(cloth_scene(8, 1e5), mujoco_point(solver, 0.01), kNoLimit_s).end ==
        RunEnd::kDiverged);
}

TEST_CASE("A run that blows up or takes too long has no error but infinity", "[work_precision]") {
  const ChartScene scene = cloth_scene(8, 1e5);
  const std::vector<Eigen::Matrix3Xd> reference_m(2, positions_m(scene::build_world(scene.scene)));
  const RunResult blown =
      run_ours(scene, point_of(scene::IntegratorKind::kSymplecticEuler, 0.01), 1e3);
  const RunResult slow =
      run_ours(scene, point_of(scene::IntegratorKind::kImplicitEuler, 0.01), 0.0);

  CHECK(blown.end == RunEnd::kDiverged);
  CHECK(slow.end == RunEnd::kTooSlow);
  CHECK(std::isinf(errors_of(scene, blown, reference_m).end_m));
  CHECK(std::isinf(errors_of(scene, slow, reference_m).early_m));
}

}  // namespace
}  // namespace stillgrid::performance
