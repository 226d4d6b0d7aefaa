// What the tool feels of bodies with fields between two snapshots.

#include "shared/display/displayed_field.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "shared/rendering/snapshot_renderer.hpp"
#include "tests/shared/rendering/field_fixture.hpp"

namespace stillgrid::rendering::displayed_field_test {
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t kPeriod_ns = 30 * kMillisecond_ns;
constexpr double kPeriod_s = 30e-3, kStiffness_N_per_m = 700.0, kToolRadius_m = 0.005;

publication::StaticScene fixture() {
  publication::StaticScene scene =
      plain_scene(static_cast<float>(kStiffness_N_per_m), static_cast<float>(kToolRadius_m), 2.0F);
  scene.materials[0].friction = 0.3F;
  return scene;
}

/// Of two renderers, on one tool.
double difference_N(const RenderedTick& a, const RenderedTick& b) {
  return (a.force.force_N - b.force.force_N).norm();
}

}  // namespace

TEST_CASE("A ball with a field is displayed between snapshots as a sphere is, by every transition",
          "[displayed_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U));
  const auto transition = GENERATE(display::Transition::kHold, display::Transition::kLinear);
  constexpr double kRadius_m = 0.021;
  PublishedScene field(moving_field(fixture(), ball_field(kRadius_m)), {}, kPeriod_ns);
  PublishedScene sphere(fixture(), {static_cast<float>(kRadius_m)}, kPeriod_ns);
  field.fields.resize(1);
  SnapshotRenderer of_field(transition), of_sphere(transition);
  // It turns meanwhile, which of a ball is not felt without friction; spins are slow enough here.
  FieldPlace place{.orientation = drawn.turn()};
  double largest_N = 0.0, farthest_N = 0.0;
  for (std::uint64_t n = 1; n <= 12; ++n) {
    place.position_m = drawn.vector(0.001);
    place.velocity_m_s = drawn.vector(0.03);
    const proto::FieldState state = field_state(place);
    n == 1 ? collision::fill_history(field.fields[0], state)
           : collision::push_snapshot(field.fields[0], state);
    const std::uint64_t shown_ns = n * kPeriod_ns + drawn.engine() % (5 * kMillisecond_ns);
    field.show({}, shown_ns);
    sphere.show({place.position_m}, {place.velocity_m_s}, shown_ns);
    for (std::uint64_t ms = 5; ms < 30; ++ms) {
      const ToolPose pose{
          .position_m = (kRadius_m + kToolRadius_m - 0.0025) * Vector3d(0.6, 0.0, 0.8),
          .velocity_m_s = drawn.vector(0.02)};
      const std::uint64_t now_ns = n * kPeriod_ns + ms * kMillisecond_ns;
      const RenderedTick a = of_field.render(field.view(), pose, now_ns);
      const RenderedTick b = of_sphere.render(sphere.view(), pose, now_ns);
      largest_N = std::max(largest_N, b.force.force_N.norm());
      farthest_N = std::max(farthest_N, difference_N(a, b));
      CHECK(a.switch_jump_N.has_value() == b.switch_jump_N.has_value());
      if (a.switch_jump_N)
        CHECK(*a.switch_jump_N == Approx(*b.switch_jump_N).margin(kStiffness_N_per_m * 5e-5));
    }
  }
  CHECK(largest_N > 1.0);
  CHECK(farthest_N < kStiffness_N_per_m * 4e-5);
}

TEST_CASE("A body that turns evenly is displayed on its way, by every transition that follows it",
          "[displayed_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U));
  // How late each shows it, in periods.
  const auto [transition, late] = GENERATE(table<display::Transition, double>(
      {{display::Transition::kHold, std::numeric_limits<double>::quiet_NaN()},
       {display::Transition::kLinear, 1.0}}));
  const Vector3d half_m(0.04, 0.03, 0.008);
  PublishedScene scene(moving_field(fixture(), box_field(half_m)), {}, kPeriod_ns);
  scene.fields.resize(1);
  SnapshotRenderer renderer(transition);
  const FieldPlace start{.position_m = drawn.vector(0.1),
                         .orientation = drawn.turn(),
                         .velocity_m_s = drawn.vector(0.01),
                         .spin_rad_s = 3.0 * drawn.direction()};
  double farthest_N = 0.0;
  for (std::uint64_t n = 1; n <= 10; ++n) {
    const double time_s = static_cast<double>(n) * kPeriod_s;
    proto::FieldState state = field_state(start.after(time_s));
    if (n % 3 == 0)  // the same turn
      for (float& x : state.orientation_xyzw) x = -x;
    n == 1 ? collision::fill_history(scene.fields[0], state)
           : collision::push_snapshot(scene.fields[0], state);
    scene.show({}, n * kPeriod_ns);
    for (std::uint64_t ms = 0; ms < 30; ++ms) {
      const double since_s = static_cast<double>(ms) * 1e-3;
      const double shown_s = std::isnan(late) ? time_s : time_s + since_s - late * kPeriod_s;
      const FieldPlace shown = start.after(shown_s);
      // On the box's large face, half a radius deep, moving with it: neither damped nor dragged.
      const Vector3d at_m(0.017, -0.013, half_m.z() + kToolRadius_m - 0.0025);
      const Vector3d tool_m = shown.out_of(at_m), surface_m = tool_m - shown.position_m;
      const RenderedTick tick =
          renderer.render(scene.view(),
                          {.position_m = tool_m,
                           .velocity_m_s = shown.velocity_m_s + shown.spin_rad_s.cross(surface_m),
                           .angular_velocity_rad_s = shown.spin_rad_s},
                          n * kPeriod_ns + ms * kMillisecond_ns);
      if (n < 5) continue;
      const Vector3d expected_N =
          kStiffness_N_per_m * 0.0025 * (shown.orientation * Vector3d::UnitZ());
      farthest_N = std::max(farthest_N, (tick.force.force_N - expected_N).norm());
    }
  }
  CHECK(farthest_N < kStiffness_N_per_m * 1e-5);
}

TEST_CASE("Of two snapshots the turn is displayed by their slerp", "[displayed_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U, 4U, 5U));
  const double angle_rad = drawn.in(0.01, 1.0), share = drawn.in(0.0, 1.0);
  const FieldPlace old{.orientation = drawn.turn()};
  FieldPlace now = old;
  const Vector3d axis = drawn.direction();
  now.orientation = Eigen::AngleAxisd(angle_rad, axis) * old.orientation;
  proto::FieldRecord record{};
  collision::fill_history(record, field_state(old));
  collision::push_snapshot(record, field_state(now));
  const auto shown_turn = [&](const display::SnapshotWeights& weights) {
    const auto shown = display::displayed(record, weights);
    REQUIRE(shown);
    return Eigen::Quaterniond(shown->orientation);
  };

  const double off_rad =
      shown_turn({.alpha = share}).angularDistance(old.orientation.slerp(share, now.orientation));
  CHECK(off_rad < std::pow(angle_rad, 3) / 100.0 + 1e-6);
  CHECK(shown_turn({}).angularDistance(now.orientation) < 1e-5);
}

TEST_CASE("A tick that is overtaken shows a field where the tick before met it",
          "[displayed_field]") {
  Drawn drawn(GENERATE(1U, 2U));
  PublishedScene scene(moving_field(fixture(), ball_field(0.021)), {}, kPeriod_ns);
  collision::fill_history(scene.fields.emplace_back(), field_state({}));
  scene.show({}, kPeriod_ns);
  SnapshotRenderer renderer(display::Transition::kLinear);
  const Vector3d normal = drawn.direction(), aside = normal.unitOrthogonal();
  const auto force_N = [&](const Vector3d& tool_m, std::uint64_t ms, bool is_overtaken) {
    const RenderedTick tick =
        renderer.render(scene.view(), {.position_m = tool_m}, kPeriod_ns + ms * kMillisecond_ns);
    CHECK(tick.contended == is_overtaken);
    return tick.force.force_N;
  };
  const Vector3d before_m = 0.024 * normal, now_m = 0.0235 * normal + 0.001 * aside;
  (void)force_N(before_m, 0, false);
  // Its writer died in the midst of a snapshot.
  std::uint64_t& sequence = *scene.writer().segment().buffer().sequence[1];
  sequence -= 1;
  const Vector3d overtaken_N = force_N(now_m, 1, true);
  sequence += 1;
  const Vector3d fresh_N = force_N(now_m, 1, false);
  REQUIRE(fresh_N.norm() > 1.0);
  // As deep as a sphere is that is tangent where the tick before was: a way of 1 mm is no curve.
  CHECK((overtaken_N - fresh_N).norm() < 0.1 * fresh_N.norm());
}

}  // namespace stillgrid::rendering::displayed_field_test
