#include "sim_server/spheres/feel.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <random>

#include "sim_server/spheres/feel_search.hpp"
#include "sim_server/spheres/force_fit.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "tests/sim_server/spheres/generated_solids.hpp"
#include "tests/sim_server/spheres/pushed_out.hpp"

namespace stillgrid::spheres::feel_test {
namespace {

Feel feel_of_balls(const std::vector<Ball>& balls, const mesh::TriangleMesh& mesh,
                   const Press& press) {
  return feel_of(balls, mesh::MeshDistance(mesh), press);
}

TEST_CASE("A ball that is one sphere feels as its mesh does, at any stiffness", "[feel]") {
  const mesh::TriangleMesh ball = mesh::ball_mesh(1.0, 97, 47);
  const Press press = make_press(ball, 0.21, 0.037, 0.0);
  const int copies = GENERATE(1, 3);
  const Feel feel = feel_of_balls(
      std::vector<Ball>(static_cast<std::size_t>(copies), {Eigen::Vector3d::Zero(), 1.0}), ball,
      press);
  CHECK(feel.error.share < 0.02);  // the facets
  CHECK(feel.error.stiffness_scale == Approx(1.0 / copies).epsilon(0.03));
  CHECK_FALSE(is_worse_than_nearest_face(feel));
}

TEST_CASE("Moved by the fit, as few spheres feel nearer to the mesh where they were not fitted too",
          "[feel]") {
  const unsigned seed = GENERATE(1U, 2U, 3U);
  const mesh::TriangleMesh mesh =
      seed == 1 ? mesh::torus_mesh(1.0, 0.31, 47, 19) : star_mesh(seed, 0.05, 26, 13);
  const Press press = make_press(mesh, 0.0, 0.0, 0.0);
  const mesh::MeshDistance distance(mesh);
  const auto exact_at = [&](std::size_t places) {
    return press_everywhere(mesh, distance, places, press.tool_radius_m, std::array{press.depth_m});
  };
  const double size_m = MeshSolid(mesh).size_m;
  for (const auto& balls :
       {decompose(mesh, 0.021 * size_m).balls, firm_surface_balls(mesh, 0.023 * size_m)}) {
    const auto fitted = fit_force(balls, exact_at(1000 + 5 * balls.size()), press.tool_radius_m);
    CHECK(fitted.size() == balls.size());
    const double before = feel_of_balls(balls, mesh, press).error.share,
                 after = feel_of_balls(fitted, mesh, press).error.share;
    CAPTURE(seed, balls.size(), before, after);
    CHECK(after < 0.9 * before);
    for (const Ball& ball : fitted) CHECK(ball.radius_m > 0.0);
  }
}

TEST_CASE(
    "A search by feel ends at the first spheres that are near enough, and these cannot be "
    "pushed through",
    "[feel]") {
  const unsigned seed = GENERATE(4U, 5U, 6U);
  const double share = GENERATE(0.43, 0.37);
  const mesh::TriangleMesh mesh = star_mesh(seed, 0.04, 26, 13);
  const MeshSolid solid(mesh);
  const Press press = make_press(mesh, 0.061 * solid.size_m, 0.0, 0.0);
  const std::vector<FeltLevel> levels = search_by_feel(mesh, press, share);

  const FeltLevel& best = best_of(levels, share);
  CAPTURE(seed, share, best.balls.size(), best.error.share);
  CHECK(best.error.share <= share);
  CHECK(feel_of_balls(best.balls, mesh, press).error.share == Approx(best.error.share));
  CHECK(&best == &levels.back());
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) CHECK(levels[i].error.share > share);
  const PushedOut out = press_in(solid, best.balls, press.tool_radius_m, 2.0 * press.depth_m,
                                 kFirmShare, press.tool_radius_m, 1201);
  CHECK(out.presses > 1000);
  CHECK(out.least > 0.0);
}

TEST_CASE("Balls that were pushed about find back to the force that they had", "[feel]") {
  std::mt19937 random(GENERATE(1U, 2U, 3U));
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<Ball> balls;
  for (int i = 0; i < 40; ++i)
    balls.push_back({{any(random), any(random), 0.2 * any(random)}, 0.3 + 0.05 * any(random)});
  const double tool_m = 0.4;
  const BallBody body = make_ball_body(balls, tool_m);
  ExactForces exact;
  while (exact.tool_m.size() < 1500) {
    const Eigen::Vector3d at_m(1.3 * any(random), 1.3 * any(random), 0.6 + 0.3 * any(random));
    const Eigen::Vector3d force_m = unit_force_m(body, at_m);
    if (force_m.norm() == 0.0) continue;
    exact.tool_m.push_back(at_m);
    exact.force_m.push_back(force_m);
  }
  const auto share_of = [&](const std::vector<Ball>& of) {
    const BallBody moved = make_ball_body(of, tool_m);
    return felt_error(exact, [&](const Eigen::Vector3d& at_m) { return unit_force_m(moved, at_m); })
        .share;
  };
  for (Ball& ball : balls) {
    ball.centre_m += 0.02 * Eigen::Vector3d(any(random), any(random), any(random));
    ball.radius_m += 0.02 * any(random);
  }
  const double before = share_of(balls), after = share_of(fit_force(balls, exact, tool_m));
  CAPTURE(before, after);
  CHECK(before > 0.01);
  CHECK(after < 0.15 * before);
}

TEST_CASE("What cannot be reached ends with the nearest that was found", "[feel]") {
  const mesh::TriangleMesh mesh = mesh::box_mesh(Eigen::Vector3d::Zero(), {1.0, 0.7, 0.31});
  const Press press = make_press(mesh, 0.3, 0.07, 0.0);
  constexpr std::size_t kMaxBalls = 110;
  const auto levels = search_by_feel(mesh, press, 1e-3, {}, kMaxBalls);
  REQUIRE(levels.size() > 1);
  const FeltLevel& best = best_of(levels, 1e-3);
  CHECK(best.error.share > 1e-3);
  for (const FeltLevel& level : levels) {
    CHECK(level.error.share >= best.error.share);
    CHECK(level.balls.size() <= kMaxBalls);
  }
}

}  // namespace
}  // namespace stillgrid::spheres::feel_test
