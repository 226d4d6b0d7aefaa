#include "shared/reading/displayed.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "shared/collision/sphere_history.hpp"
#include "shared/reading/snapshot.hpp"
#include "shared/rendering/renderer.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::reading::displayed_test {
namespace {

double distance_m(const std::array<float, 3>& a_m, const Eigen::Vector3d& b_m) {
  return (Eigen::Vector3f(a_m.data()).cast<double>() - b_m).norm();
}

TEST_CASE("A tick's force is that of a sphere where the tick is told to have displayed it",
          "[displayed]") {
  constexpr float kStiffness_N_per_m = 500.0F, kTool_m = 0.01F, kSphere_m = 0.02F;
  constexpr std::uint64_t kTicks = 20;  // a period
  const auto transition = static_cast<display::Transition>(
      GENERATE(range(0, static_cast<int>(display::transitions().size()))));
  rendering::PublishedScene scene(rendering::plain_scene(kStiffness_N_per_m, kTool_m), {kSphere_m},
                                  kTicks * rendering::kMillisecond_ns);
  const auto renderer = rendering::make_renderer(transition);
  rendering::ToolPose pose;
  pose.position_m = {0.002, 0.001, 0.026};
  double farthest_m = 0.0;
  for (std::uint64_t tick = 1; tick < 20 * kTicks; ++tick) {
    const std::uint64_t now_ns = tick * rendering::kMillisecond_ns;
    if (tick % kTicks == 1)
      scene.show({{1e-5 * static_cast<double>(tick), 0.0, -1e-5 * static_cast<double>(tick % 50)}},
                 {{0.01, 0.0, 0.01}}, now_ns);
    const rendering::RenderedTick rendered = renderer->render(scene.view(), pose, now_ns);
    const auto snapshot = read_snapshot(scene.view(), 1);
    REQUIRE(snapshot);
    REQUIRE(snapshot->snapshot_id == rendered.snapshot_id);
    const auto at_m = displayed_m(snapshot->spheres[0], rendering::displayed_snapshot(rendered, 0));
    const Eigen::Vector3d line_m = pose.position_m - Eigen::Vector3f(at_m.data()).cast<double>();
    const double depth_m = static_cast<double>(kTool_m) + kSphere_m - line_m.norm();
    const Eigen::Vector3d force_N = kStiffness_N_per_m * depth_m * line_m.normalized();
    REQUIRE(depth_m > 1e-3);
    CHECK((rendered.force.force_N - force_N).norm() < 5e-5);
    farthest_m = std::max(farthest_m, distance_m(snapshot->spheres[0].newest.position_m,
                                                 Eigen::Vector3f(at_m.data()).cast<double>()));
  }
  CHECK((farthest_m > 1e-4) == (transition != display::Transition::kHold));
}

TEST_CASE("A sphere that a snapshot lacks is displayed by the other, and not at all by none",
          "[displayed]") {
  proto::SphereRecord record{};
  const float nan = std::nanf("");
  record.newest.position_m = {nan, nan, nan};
  record.before.position_m = {1.0F, 2.0F, 3.0F};
  proto::DisplayedSnapshot shown{};
  shown.alpha = 0.7;
  CHECK(distance_m(displayed_m(record, shown), {1.0, 2.0, 3.0}) < 1e-6);
  shown.alpha = 1.0;
  CHECK(std::isnan(displayed_m(record, shown)[1]));
}

TEST_CASE("A later snapshot's history tells the place at the switch, as long as it holds it",
          "[displayed]") {
  proto::SphereRecord record{};
  collision::push_snapshot(record, {{0.1F, 0.2F, -0.1F}, {}});
  proto::DisplayedSnapshot shown{};
  shown.alpha = 1.0;
  const Eigen::Vector3d there_m = Eigen::Vector3f(displayed_m(record, shown).data()).cast<double>();
  collision::push_snapshot(record, {{0.5F, 0.5F, 0.5F}, {}});
  const auto told = in_later_history(shown, 1);
  REQUIRE(told);
  CHECK(distance_m(displayed_m(record, *told), there_m) == 0.0);
  CHECK_FALSE(in_later_history(shown, proto::kHistoryLength));
}

}  // namespace
}  // namespace stillgrid::reading::displayed_test
