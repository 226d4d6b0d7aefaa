#include "tests/laboratory/rivals/proxy.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "tests/laboratory/rivals/rivals.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::laboratory::proxy_test {
namespace {

constexpr double kStiffness_N_per_m = 500.0;
constexpr double kContactDistance_m = 0.015;  // 10 mm of a sphere, 5 mm of the tool
constexpr int kPeriod_ticks = 33;

/// A scene of spheres of 10 mm that stands still, a snapshot every period, and both models in it.
struct Explored {
  rendering::PublishedScene scene;
  std::vector<Eigen::Vector3d> centres_m;
  std::unique_ptr<rendering::Renderer> grid = rendering::make_renderer(display::Transition::kHold);
  std::unique_ptr<rendering::Renderer> proxy = rival_named("proxy")->make();
  int period_ticks, ticks = 0;

  explicit Explored(std::vector<Eigen::Vector3d> centres, int period = kPeriod_ticks)
      : scene(rendering::plain_scene(500.0F, 0.005F), std::vector<float>(centres.size(), 0.01F),
              kPeriod_ticks * rendering::kMillisecond_ns),
        centres_m(std::move(centres)),
        period_ticks(period) {}

  struct Forces {
    Eigen::Vector3d grid_N, proxy_N;
  };
  Forces move_to(const Eigen::Vector3d& tool_m) {
    const auto now_ns = static_cast<std::uint64_t>(ticks) * rendering::kMillisecond_ns;
    if (ticks++ % period_ticks == 0) scene.show(centres_m, now_ns);
    const rendering::ToolPose pose{.position_m = tool_m};
    return {grid->render(scene.view(), pose, now_ns).force.force_N,
            proxy->render(scene.view(), pose, now_ns).force.force_N};
  }
};

std::vector<Eigen::Vector3d> sheet_m() {
  std::vector<Eigen::Vector3d> centres_m;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) centres_m.emplace_back(0.01 * i, 0.01 * j, 0.0);
  return centres_m;
}

TEST_CASE("A god-object stays above a thin sheet that spheres' penalties push the tool out below",
          "[proxy]") {
  Explored sheet(sheet_m());
  double least_grid_N = 0.0;
  for (double height_m = 0.02; height_m > -0.03; height_m -= 1e-4) {
    const auto [grid_N, proxy_N] = sheet.move_to({0.002, 0.001, height_m});
    least_grid_N = std::min(least_grid_N, grid_N.z());
    const double place_m = height_m + proxy_N.z() / kStiffness_N_per_m;
    if (proxy_N.z() > 0.0) CHECK(place_m > 0.012);  // where no sphere reaches between
    if (height_m < 0.010) CHECK(proxy_N.z() > 0.0);
  }
  CHECK(least_grid_N < -1.0);  // popped through
}

TEST_CASE("On one sphere a god-object's force is the penalty's, sliding included", "[proxy]") {
  Explored ball({{0.0, 0.0, 0.0}});
  for (int i = 0; i < 1000; ++i) {
    const double angle = 1e-3 * i;  // 12 mm in a second
    const double distance_m = kContactDistance_m + 0.001 - std::min(0.004, 1e-4 * i);
    const auto [grid_N, proxy_N] = ball.move_to(
        distance_m * Eigen::Vector3d(std::sin(angle), 0.3, std::cos(angle)).normalized());
    CHECK((proxy_N - grid_N).norm() < 1e-3);
  }
}

TEST_CASE("However a tool wanders, its god-object is outside every sphere", "[proxy]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto vector = [&] { return Eigen::Vector3d(any(random), any(random), any(random)); };
  std::vector<Eigen::Vector3d> centres_m;
  for (int i = 0; i < 60; ++i) centres_m.emplace_back(0.05 * vector());
  Explored cloud(centres_m, 3);  // within which it goes less far than a patch reaches
  Eigen::Vector3d tool_m(0.0, 0.0, 0.08), velocity = Eigen::Vector3d::Zero();
  double deepest_m = 0.0;
  int pressed = 0;
  for (int i = 0; i < 5000; ++i) {
    velocity = 0.98 * velocity + 4e-5 * vector() - 2e-5 * tool_m / 0.05;
    tool_m += velocity;
    const Eigen::Vector3d proxy_N = cloud.move_to(tool_m).proxy_N;
    const Eigen::Vector3d place_m = tool_m + proxy_N / kStiffness_N_per_m;
    for (const Eigen::Vector3d& centre_m : centres_m)
      deepest_m = std::max(deepest_m, kContactDistance_m - (place_m - centre_m).norm());
    pressed += proxy_N.norm() > 0.0 ? 1 : 0;
  }
  CAPTURE(pressed, deepest_m);
  CHECK(pressed > 1000);
  CHECK(deepest_m < 1e-6);
}

TEST_CASE("A god-object on local spheres knows nothing of what a far move leads into", "[proxy]") {
  Explored bodies({{0.0, 0.0, 0.0}, {0.06, 0.0, 0.0}});
  CHECK(bodies.move_to({0.0, 0.0, 0.013}).proxy_N.z() > 0.5);
  for (int i = 1; i < kPeriod_ticks; ++i) {  // 60 mm within the period
    const double share = std::min(1.0, i / 30.0);
    const auto [grid_N, proxy_N] =
        bodies.move_to({0.06 * share, 0.0, 0.013 + 0.02 * share * (1.0 - share)});
    if (share < 1.0) continue;
    CHECK(grid_N.z() > 0.5);
    CHECK(proxy_N.norm() == 0.0);
  }
  CHECK(bodies.move_to({0.06, 0.0, 0.013}).proxy_N.z() > 0.5);  // with the next snapshot
}

TEST_CASE("A god-object above a plane has the plane's own force", "[proxy]") {
  publication::StaticScene fixed = rendering::plain_scene(1000.0F, 0.005F);
  fixed.materials[0] = {1000.0F, 4.0F, 0.3F, 0.02F};
  fixed.planes = {{{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0}};
  rendering::PublishedScene scene(fixed, {}, rendering::kMillisecond_ns);
  scene.show({}, 0);
  const auto grid = rendering::make_renderer(display::Transition::kHold);
  const auto proxy = rival_named("proxy")->make();
  for (const double height_m : {0.006, 0.004, -0.01, -0.08}) {
    const rendering::ToolPose pose{.position_m = {0.3 * height_m, 0.0, height_m},
                                   .velocity_m_s = {0.03, 0.0, -0.1}};
    const rendering::ToolForce by_law = grid->render(scene.view(), pose, 0).force;
    const rendering::ToolForce by_proxy = proxy->render(scene.view(), pose, 0).force;
    CHECK((by_proxy.force_N - by_law.force_N).norm() < 1e-6);
    CHECK((by_proxy.torque_N_m - by_law.torque_N_m).norm() < 1e-6);
  }
}

}  // namespace
}  // namespace stillgrid::laboratory::proxy_test
