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
  // What gives way ramps out what is left of the force before, for half a period.
  const auto transition = static_cast<display::Transition>(
      GENERATE(range(0, static_cast<int>(display::transitions().size()))));
  const std::uint64_t first = display::law_of(transition).gives_way ? kTicks / 2 + 1 : 0;
  rendering::PublishedScene scene(rendering::plain_scene(kStiffness_N_per_m, kTool_m), {kSphere_m},
                                  kTicks * rendering::kMillisecond_ns);
  const auto renderer = rendering::make_renderer(transition);
  rendering::ShownPrediction prediction;
  prediction.period_ns = kTicks * rendering::kMillisecond_ns;
  prediction.predicted_velocity_m_s = {{0.01, 0.0, -0.005}};
  rendering::add_mode(prediction, {{0.0, 0.0, -1e-3}}, {0.0, 0.0, -1.0});
  rendering::ToolPose pose;
  pose.position_m = {0.002, 0.001, 0.026};
  double farthest_m = 0.0;
  for (std::uint64_t tick = 1; tick < 20 * kTicks; ++tick) {
    const std::uint64_t now_ns = tick * rendering::kMillisecond_ns;
    if (tick % kTicks == 1)
      scene.show({{1e-5 * static_cast<double>(tick), 0.0, -1e-5 * static_cast<double>(tick % 50)}},
                 {{0.01, 0.0, 0.01}}, now_ns, 0, prediction);
    const rendering::RenderedTick rendered = renderer->render(scene.view(), pose, now_ns);
    if ((tick - 1) % kTicks < first) continue;
    const auto snapshot = read_snapshot(scene.view(), 1);
    REQUIRE(snapshot);
    REQUIRE(snapshot->snapshot_id == rendered.snapshot_id);
    const auto at_m = displayed_m(snapshot->spheres[0], snapshot->responses,
                                  rendering::displayed_snapshot(rendered, 0));
    const Eigen::Vector3d line_m = pose.position_m - Eigen::Vector3f(at_m.data()).cast<double>();
    const double depth_m = static_cast<double>(kTool_m) + kSphere_m - line_m.norm();
    const Eigen::Vector3d force_N = kStiffness_N_per_m * depth_m * line_m.normalized();
    REQUIRE(depth_m > 1e-3);
    CHECK((rendered.force.force_N - force_N).norm() < 5e-5);
    farthest_m = std::max(farthest_m, distance_m(snapshot->spheres[0].newest.position_m,
                                                 Eigen::Vector3f(at_m.data()).cast<double>()));
  }
  CHECK((farthest_m > 1e-4) ==
        (transition != display::Transition::kHold && transition != display::Transition::kLocal));
}

TEST_CASE("A sphere that a snapshot lacks is displayed by the others, and not at all by none",
          "[displayed]") {
  proto::SphereRecord record{};
  const float nan = std::nanf("");
  record.newest.position_m = {nan, nan, nan};
  record.older[0].position_m = {1.0F, 2.0F, 3.0F};
  proto::DisplayedSnapshot shown{};
  shown.position = {0.7, 0.3, 0.0, 0.0};

  CHECK(distance_m(displayed_m(record, {}, shown), {1.0, 2.0, 3.0}) < 1e-6);
  shown.position = {1.0, 0.0, 0.0, 0.0};
  CHECK(std::isnan(displayed_m(record, {}, shown)[1]));
}

TEST_CASE("A later snapshot's history tells the same place, as long as it holds the snapshot",
          "[displayed]") {
  proto::SphereRecord before{};
  for (const float x : {0.1F, -0.07F, 0.03F, 0.09F})
    collision::push_snapshot(before, {{x, 2.0F * x, -x}, {-5.0F * x, x, 0.3F}});
  proto::SphereRecord after = before;
  proto::DisplayedSnapshot shown{};
  shown.position = {0.6, 0.4, 0.0, 0.0};
  shown.velocity_s = {0.004, 0.0, 0.0};
  shown.shifts[0] = {{0.0, 0.001, 0.0}, 0};
  const Eigen::Vector3d there_m =
      Eigen::Vector3f(displayed_m(before, {}, shown).data()).cast<double>();

  collision::push_snapshot(after, {{0.5F, 0.5F, 0.5F}, {1.0F, 1.0F, 1.0F}});
  const auto one = in_later_history(shown, 1);
  REQUIRE(one);
  CHECK(distance_m(displayed_m(after, {}, *one), there_m) < 2e-8);
  collision::push_snapshot(after, {{0.7F, 0.5F, 0.5F}, {1.0F, 1.0F, 1.0F}});
  const auto two = in_later_history(shown, 2);
  REQUIRE(two);
  CHECK(distance_m(displayed_m(after, {}, *two), there_m) < 2e-8);
  CHECK_FALSE(in_later_history(shown, proto::kHistoryLength));
}

TEST_CASE("What a later snapshot cannot tell of a predicted velocity its velocity stands for",
          "[displayed]") {
  proto::DisplayedSnapshot shown{};
  shown.position = {1.0, 0.0, 0.0, 0.0};
  shown.prediction_s = 0.02;
  shown.compliance_lag_s = 0.006;
  shown.modes[0] = 3.0;
  const auto told = in_later_history(shown, 1);
  REQUIRE(told);
  CHECK(told->position == std::array{0.0, 1.0, 0.0, 0.0});
  CHECK(told->velocity_s == std::array{0.0, 0.02, 0.0});
  CHECK(told->prediction_s == 0.0);
  CHECK(told->compliance_lag_s == 0.0);
  CHECK(told->modes[0] == 0.0);
}

}  // namespace
}  // namespace stillgrid::reading::displayed_test
