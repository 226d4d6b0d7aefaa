#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering::swept_contact_test {
namespace {

constexpr double kStiffness_N_per_m = 500.0;
constexpr double kContactDistance_m = 0.015;  // 10 mm of the sphere, 5 mm of the tool: case 2.12
constexpr std::uint64_t kPeriod_ns = 33 * kMillisecond_ns;

/// What one pass of the sphere through the tool's place was felt as.
struct Pass {
  int contacts = 0;  // ticks in which anything was felt
  int swept = 0;     // of them, by the way alone
  double force_max_N = 0.0;

  void add(const RenderedTick& tick) {
    contacts += tick.force.contacts > 0 ? 1 : 0;
    swept += tick.swept ? 1 : 0;
    force_max_N = std::max(force_max_N, tick.force.force_N.norm());
  }
};

/// A body at speed_m_s along x past a still tool, at `offset_m` beside it; `phase` of a period
/// decides where its snapshots fall. Snapshots are held, as in the lockstep of docs/protocol.md.
Pass body_passes(display::Transition transition, double speed_m_s, double phase, double offset_m) {
  static PublishedScene scene(plain_scene(500.0F, 0.005F), {0.010F}, kPeriod_ns);
  static std::uint64_t now_ns = 0;
  SnapshotRenderer renderer(transition);
  Pass pass;
  const double step_m = speed_m_s * static_cast<double>(kPeriod_ns) * 1e-9;
  const int snapshots = 6 + static_cast<int>(0.2 / step_m);
  for (int snapshot = -snapshots; snapshot <= snapshots; ++snapshot) {
    scene.show({{(snapshot + phase) * step_m, offset_m, 0.0}}, now_ns);
    // The first snapshots of a pass still remember the end of the pass before.
    for (int tick = 0; tick < 33; tick += 4, now_ns += 4 * kMillisecond_ns)
      if (snapshot > 4 - snapshots) pass.add(renderer.render(scene.view(), {}, now_ns));
    now_ns -= 3 * kMillisecond_ns;
  }
  return pass;
}

TEST_CASE("Held snapshots alone miss a fast body as often as 1 - 2A/(vP), the way misses none",
          "[swept_contact]") {
  const double speed_m_s = GENERATE(0.5, 1.0, 2.0, 8.0);
  constexpr int kTrials = 200;
  const double period_s = static_cast<double>(kPeriod_ns) * 1e-9;
  const double expected = std::max(0.0, 1.0 - 2.0 * kContactDistance_m / (speed_m_s * period_s));
  int missed_without_sweep = 0, missed = 0, felt_twice = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Pass pass = body_passes(display::Transition::kHold, speed_m_s, (i + 0.5) / kTrials, 1e-4);
    missed_without_sweep += pass.contacts == pass.swept ? 1 : 0;
    missed += pass.contacts == 0 ? 1 : 0;
    felt_twice += pass.swept > 1 || (pass.swept == 1 && pass.contacts > 1) ? 1 : 0;
  }
  CHECK(missed == 0);
  CHECK(felt_twice == 0);
  CHECK(static_cast<double>(missed_without_sweep) / kTrials == Approx(expected).margin(0.011));
}

TEST_CASE("A body that crosses while it is faded from snapshot to snapshot is not missed either",
          "[swept_contact]") {
  // 30 m/s: 4 ticks of 1 ms move the body by 120 mm.
  const double offset_m = GENERATE(0.0, 0.007, 0.0149);
  int missed = 0;
  for (int i = 0; i < 40; ++i)
    missed +=
        body_passes(display::Transition::kLinear, 30.0, (i + 0.5) / 40, offset_m).contacts == 0 ? 1
                                                                                                : 0;
  CHECK(missed == 0);
}

/// A tool that moves `step_m` a tick through a static sphere at the origin.
Pass tool_passes(double step_m, double phase, double offset_m) {
  publication::StaticScene fixed = plain_scene(500.0F, 0.005F);
  fixed.spheres = {collision::static_sphere({0.0F, 0.0F, 0.0F}, 0.010F)};
  static PublishedScene scene(fixed, {}, kPeriod_ns);
  static const bool shown = (scene.show({}, 0), true);
  REQUIRE(shown);
  SnapshotRenderer renderer(display::Transition::kLinear);
  Pass pass;
  const int steps = 2 + static_cast<int>(0.1 / step_m);
  for (int i = -steps; i <= steps; ++i)
    pass.add(renderer.render(scene.view(), {.position_m = {(i + phase) * step_m, offset_m, 0.0}},
                             static_cast<std::uint64_t>(i + steps) * kMillisecond_ns));
  return pass;
}

TEST_CASE("A tool faster than a diameter a tick misses nothing and feels each pass once",
          "[swept_contact]") {
  const double step_m = GENERATE(0.02, 0.04, 0.2, 1.5);
  constexpr int kTrials = 300;
  int missed_without_sweep = 0, missed = 0, felt_twice = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Pass pass = tool_passes(step_m, (i + 0.5) / kTrials, 1e-4);
    missed_without_sweep += pass.contacts == pass.swept ? 1 : 0;
    missed += pass.contacts == 0 ? 1 : 0;
    felt_twice += pass.swept > 1 || (pass.swept == 1 && pass.contacts > 1) ? 1 : 0;
  }
  CHECK(missed == 0);
  CHECK(felt_twice == 0);
  CHECK(static_cast<double>(missed_without_sweep) / kTrials ==
        Approx(std::max(0.0, 1.0 - 2.0 * kContactDistance_m / step_m)).margin(0.011));
}

TEST_CASE("A contact on the way has the law's force where the two were closest",
          "[swept_contact]") {
  const double offset_m = GENERATE(0.0, 0.003, 0.01, 0.0149, 0.0151);
  const double depth_m = std::max(0.0, kContactDistance_m - offset_m);
  const Pass pass = tool_passes(0.2, 0.5, offset_m);
  CHECK(pass.swept == (depth_m > 0.0 ? 1 : 0));
  CHECK(pass.force_max_N == Approx(kStiffness_N_per_m * depth_m).epsilon(1e-5).margin(1e-9));
}

TEST_CASE("A tool that goes through the very centre is pushed back where it came from",
          "[swept_contact]") {
  publication::StaticScene fixed = plain_scene(500.0F, 0.005F);
  fixed.spheres = {collision::static_sphere({0.0F, 0.0F, 0.0F}, 0.010F)};
  PublishedScene scene(fixed, {}, kPeriod_ns);
  scene.show({}, 0);
  SnapshotRenderer renderer(display::Transition::kHold);
  (void)renderer.render(scene.view(), {.position_m = {-0.1, 0.0, 0.0}}, 0);
  const RenderedTick tick = renderer.render(scene.view(), {.position_m = {0.1, 0.0, 0.0}}, 1);
  CHECK(tick.swept);
  CHECK(tick.force.force_N.x() == Approx(-kStiffness_N_per_m * kContactDistance_m).epsilon(1e-5));
}

TEST_CASE("Slow motion is never swept, and felt as without the way", "[swept_contact]") {
  std::mt19937_64 random(5);
  std::normal_distribution<double> step_m(0.0, 4e-4);
  std::uniform_real_distribution<double> place_m(-0.04, 0.04);
  publication::StaticScene fixed = plain_scene(500.0F, 0.005F);
  for (int i = 0; i < 60; ++i)
    fixed.spheres.push_back(collision::static_sphere(
        {static_cast<float>(place_m(random)), static_cast<float>(place_m(random)),
         static_cast<float>(place_m(random))},
        0.008F));
  PublishedScene scene(fixed, {}, kPeriod_ns);
  scene.show({}, 0);
  SnapshotRenderer renderer(display::Transition::kLinear);
  ToolPose pose;
  int contacts = 0, swept = 0, different = 0;
  for (int tick = 0; tick < 3000; ++tick) {
    pose.position_m += Eigen::Vector3d(step_m(random), step_m(random), step_m(random));
    pose.position_m = pose.position_m.cwiseMax(-0.04).cwiseMin(0.04);
    const RenderedTick on_the_way = renderer.render(scene.view(), pose, 0);
    SnapshotRenderer without_sweep(display::Transition::kLinear);  // knows no tick before
    const RenderedTick alone = without_sweep.render(scene.view(), pose, 0);
    contacts += on_the_way.force.contacts;
    swept += on_the_way.swept ? 1 : 0;
    different += on_the_way.force.force_N == alone.force.force_N ? 0 : 1;
  }
  CHECK(contacts > 1000);
  CHECK(swept == 0);
  CHECK(different == 0);
}

TEST_CASE("A contact on the way is not shown again by a tick without a fresh read",
          "[swept_contact]") {
  TouchedSpheres touched;
  for (std::size_t i = 0; i < 5; ++i)
    touched.spheres[touched.count++] = {
        {static_cast<double>(i), 0, 0}, {0, 0, 0}, 0.01, 0, 0, i % 2 == 1};
  touched.drop_swept();
  REQUIRE(touched.count == 3);
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(touched.spheres[i].position_m.x() == 2.0 * static_cast<double>(i));
}

TEST_CASE("A tool has no way from one scene into another", "[swept_contact]") {
  publication::StaticScene fixed = plain_scene(500.0F, 0.005F);
  fixed.spheres = {collision::static_sphere({0.0F, 0.0F, 0.0F}, 0.010F)};
  PublishedScene first(fixed, {}, kPeriod_ns), second(fixed, {}, kPeriod_ns);
  first.show({}, 0);
  second.show({}, 0);
  SnapshotRenderer renderer(display::Transition::kHold);
  (void)renderer.render(first.view(), {.position_m = {-0.1, 0.0, 0.0}}, 0);
  CHECK_FALSE(renderer.render(second.view(), {.position_m = {0.1, 0.0, 0.0}}, 0).swept);
}

}  // namespace
}  // namespace stillgrid::rendering::swept_contact_test
