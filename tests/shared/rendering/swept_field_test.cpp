// Fields that the tool passes within a tick.

#include <catch2/catch.hpp>
#include <cmath>

#include "shared/rendering/field_sweep.hpp"
#include "shared/rendering/snapshot_renderer.hpp"
#include "tests/shared/rendering/field_fixture.hpp"

namespace stillgrid::rendering::swept_field_test {
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t kPeriod_ns = 33 * kMillisecond_ns;
constexpr double kStiffness_N_per_m = 500.0, kToolRadius_m = 0.005;

publication::StaticScene fixture() {
  return plain_scene(static_cast<float>(kStiffness_N_per_m), static_cast<float>(kToolRadius_m));
}

/// What a tool felt on a straight way in even steps, a tick each.
struct Pass {
  int contacts = 0, swept = 0;
  double pushed_on_N = 0.0;  // along the way, where it was pushed on most
  Vector3d sum_N = Vector3d::Zero();
};

Pass pass(PublishedScene& scene, const Vector3d& from_m, const Vector3d& step_m, int ticks) {
  SnapshotRenderer renderer(display::Transition::kHold);
  Pass felt;
  for (int i = 0; i <= ticks; ++i) {
    const RenderedTick tick =
        renderer.render(scene.view(), {.position_m = from_m + i * step_m}, kPeriod_ns);
    felt.contacts += tick.force.contacts > 0 ? 1 : 0;
    felt.swept += tick.swept ? 1 : 0;
    if (tick.swept)
      felt.pushed_on_N = std::max(felt.pushed_on_N, tick.force.force_N.dot(step_m.normalized()));
    felt.sum_N += tick.force.force_N;
    CHECK_FALSE(tick.truncated);
  }
  return felt;
}

}  // namespace

TEST_CASE("However fast the tool is it is held back by a thin plate that it passes",
          "[swept_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U, 4U));
  const double thickness_m = drawn.in(0.0004, 0.003);
  const Vector3d half_m(0.03, 0.03, 0.5 * thickness_m);
  const FieldPlace place{.position_m = drawn.vector(0.1), .orientation = drawn.turn()};
  PublishedScene scene(still_field(fixture(), box_field(half_m, 0.0011), place), {}, kPeriod_ns);
  scene.show({}, kPeriod_ns);
  int by_way_alone = 0;
  for (int i = 0; i < 150; ++i) {
    // Through the plate at a slant, away from its edges.
    const Vector3d through_m(drawn.in(-0.015, 0.015), drawn.in(-0.015, 0.015), 0.0);
    const double side = drawn.engine() % 2 == 0 ? 1.0 : -1.0;
    const Vector3d step_m = drawn.in(0.012, 0.05) *
                            Vector3d(drawn.in(-0.4, 0.4), drawn.in(-0.4, 0.4), side).normalized();
    const double phase = drawn.in(0.0, 1.0);
    const Pass felt = pass(scene, place.out_of(through_m - (2.0 + phase) * step_m),
                           place.orientation * step_m, 5);
    CHECK(felt.contacts > 0);
    if (felt.contacts > felt.swept) continue;
    ++by_way_alone;
    CHECK(felt.swept == 1);
    CHECK(felt.pushed_on_N == 0.0);
    // It was half of the plate deep at least, but for what the field smoothes at its middle.
    CHECK((place.orientation.conjugate() * felt.sum_N).z() * -side >
          0.9 * kStiffness_N_per_m * (kToolRadius_m - 0.0005));
  }
  CHECK(by_way_alone > 50);
}

TEST_CASE("A fast tool feels a ball's field as it feels a sphere", "[swept_field]") {
  Drawn drawn(GENERATE(range(1U, 9U)));
  constexpr double kRadius_m = 0.01;
  const Vector3d centre_m = drawn.vector(0.02);
  PublishedScene field(still_field(fixture(), ball_field(kRadius_m, centre_m), {}), {}, kPeriod_ns);
  publication::StaticScene fixed = fixture();
  fixed.spheres = {collision::static_sphere(floats(centre_m), static_cast<float>(kRadius_m))};
  PublishedScene sphere(fixed, {}, kPeriod_ns);
  field.show({}, kPeriod_ns);
  sphere.show({}, kPeriod_ns);
  int swept = 0, missed = 0;
  // Not through its middle, where a place a little off is another normal.
  for (int i = 0; i < 200; ++i) {
    const Vector3d way = drawn.direction(), aside = way.unitOrthogonal();
    const Vector3d step_m = drawn.in(0.004, 0.06) * way;
    const Vector3d from_m =
        centre_m + drawn.in(0.005, 0.0165) * aside - (3.0 + drawn.in(0.0, 1.0)) * step_m;
    const Pass by_field = pass(field, from_m, step_m, 7),
               by_sphere = pass(sphere, from_m, step_m, 7);
    swept += by_sphere.swept;
    missed += by_sphere.contacts == 0 ? 1 : 0;
    // What grazes by less than the field errs may be felt by one alone.
    if (by_sphere.sum_N.norm() > 0.05) {
      CHECK(by_field.contacts == by_sphere.contacts);
      CHECK(by_field.swept == by_sphere.swept);
    }
    const double felt_N = by_sphere.sum_N.norm();
    CHECK(std::abs(by_field.sum_N.norm() - felt_N) < 0.01 * felt_N + 0.005);
    // Where it was deepest the depth is flat along the way: 0.02 mm of it are some 0.5 mm of the
    // way.
    CHECK((by_field.sum_N - by_sphere.sum_N).norm() < 0.25 * felt_N + 0.005);
  }
  CHECK(swept > 30);
  CHECK(missed > 10);
}

TEST_CASE("A body with a field that flies past a still tool is not missed", "[swept_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U));
  const Vector3d half_m(0.001, 0.03, 0.02);
  PublishedScene scene(moving_field(fixture(), box_field(half_m, 0.0011)), {}, kPeriod_ns);
  int missed = 0, swept = 0;
  for (int i = 0; i < 60; ++i) {
    scene.fields.assign(1, {});
    SnapshotRenderer renderer(display::Transition::kHold);
    const double step_m = drawn.in(0.02, 0.2), phase = drawn.in(0.0, 1.0);
    int contacts = 0;
    for (int n = -4; n <= 4; ++n) {
      // Turned a little about the way, which it does not change.
      const FieldPlace place{
          .position_m = {(n + phase) * step_m, 0.0, 0.0},
          .orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.01 * n, Vector3d::UnitX()))};
      n == -4 ? collision::fill_history(scene.fields[0], field_state(place))
              : collision::push_snapshot(scene.fields[0], field_state(place));
      scene.show({}, static_cast<std::uint64_t>(n + 5) * kPeriod_ns);
      const RenderedTick tick =
          renderer.render(scene.view(), {}, static_cast<std::uint64_t>(n + 5) * kPeriod_ns);
      contacts += tick.force.contacts;
      swept += tick.swept ? 1 : 0;
    }
    missed += contacts == 0 ? 1 : 0;
  }
  CHECK(missed == 0);
  CHECK(swept > 20);
}

TEST_CASE("A way takes a bounded number of samples, and says so where they are too few",
          "[swept_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U));
  const Field field = box_field({0.03, 0.02, 0.01}, 0.002);
  std::uint32_t most = 0;
  for (int i = 0; i < 300; ++i) {
    constexpr std::uint32_t kBudget = 1000;
    SampleBudget budget{kBudget};
    const Vector3d from_m = drawn.vector(0.08), to_m = drawn.vector(0.08);
    const double radius_m = std::pow(10.0, drawn.in(-4.0, -2.0));
    (void)met_on_the_way(field->view(), from_m, to_m, radius_m, budget);
    most = std::max(most, kBudget - budget.left);
  }
  CHECK(most > 10);
  CHECK(most <= 64 + 8);
  SampleBudget spent{3};
  (void)met_on_the_way(field->view(), {0.0, 0.0, 0.05}, {0.0, 0.0, -0.05}, 0.001, spent);
  CHECK(spent.truncated);
}

}  // namespace stillgrid::rendering::swept_field_test
