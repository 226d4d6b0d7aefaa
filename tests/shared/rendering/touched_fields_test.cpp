// What the tool feels of bodies with fields in one snapshot.

#include "shared/rendering/touched_fields.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "shared/rendering/snapshot_renderer.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/shared/rendering/field_fixture.hpp"

namespace stillgrid::rendering::touched_fields_test {
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t kPeriod_ns = 30 * kMillisecond_ns;
constexpr double kStiffness_N_per_m = 700.0, kToolRadius_m = 0.005;

publication::StaticScene fixture() {
  return plain_scene(static_cast<float>(kStiffness_N_per_m), static_cast<float>(kToolRadius_m));
}

/// The force of a scene whose moving fields are at these places, on the tool there.
struct Felt {
  explicit Felt(const publication::StaticScene& fixed, const std::vector<FieldPlace>& places = {})
      : scene(fixed, {}, kPeriod_ns) {
    for (const FieldPlace& place : places)
      collision::fill_history(scene.fields.emplace_back(), field_state(place));
    scene.show({}, kPeriod_ns);
  }
  [[nodiscard]] RenderedTick render(const ToolPose& pose) {
    SnapshotRenderer fresh(display::Transition::kHold);  // no way behind it
    return fresh.render(scene.view(), pose, kPeriod_ns);
  }
  [[nodiscard]] ToolForce force(const Vector3d& tool_m) {
    return render({.position_m = tool_m}).force;
  }
  PublishedScene scene;
};

FieldPlace somewhere(Drawn& drawn) {
  return {.position_m = drawn.vector(0.3), .orientation = drawn.turn()};
}
/// As a segment tells it.
FieldPlace as_told(const FieldPlace& place) {
  const proto::FieldState told = field_state(place);
  const auto& [x, y, z, w] = told.orientation_xyzw;
  return {.position_m = Eigen::Vector3f(told.position_m.data()).cast<double>(),
          .orientation = Eigen::Quaterniond(w, x, y, z).normalized()};
}

}  // namespace

TEST_CASE("A ball is pushed out by its stiffness times the depth, at rest and moving",
          "[touched_fields]") {
  Drawn drawn(GENERATE(range(1U, tests::seeds_end(5))));
  const bool moves = GENERATE(false, true);
  const double radius_m = drawn.in(0.013, 0.031);
  const Vector3d centre_m = drawn.vector(0.01);
  const FieldPlace place = somewhere(drawn);
  const Field field = ball_field(radius_m, centre_m);
  Felt felt(moves ? moving_field(fixture(), field) : still_field(fixture(), field, place),
            moves ? std::vector{place} : std::vector<FieldPlace>{});
  int touches = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3d normal = drawn.direction();
    const double depth_m = drawn.in(-0.002, 0.004);
    const Vector3d tool_m = place.out_of(centre_m) + (radius_m + kToolRadius_m - depth_m) * normal;
    const ToolForce force = felt.force(tool_m);
    touches += force.contacts;
    const Vector3d expected_N = kStiffness_N_per_m * std::max(0.0, depth_m) * normal;
    CHECK((force.force_N - expected_N).norm() <= kStiffness_N_per_m * 3e-5);
    if (std::abs(depth_m) > 1e-4) CHECK(force.contacts == (depth_m > 0.0 ? 1 : 0));
  }
  CHECK(touches > 150);
}

TEST_CASE("A box's face is felt even, to the linear law, wherever the tool goes on it",
          "[touched_fields]") {
  Drawn drawn(GENERATE(range(1U, tests::seeds_end(4))));
  const bool moves = GENERATE(false, true);
  const Vector3d half_m(0.023, 0.017, 0.029);
  const FieldPlace place = somewhere(drawn);
  const Field field = box_field(half_m);
  Felt felt(moves ? moving_field(fixture(), field) : still_field(fixture(), field, place),
            moves ? std::vector{place} : std::vector<FieldPlace>{});
  for (int i = 0; i < 300; ++i) {
    const int axis = static_cast<int>(drawn.engine() % 3);
    const double side = drawn.engine() % 2 == 0 ? 1.0 : -1.0, depth_m = drawn.in(1e-5, 0.0045);
    Vector3d at_m = drawn.vector(0.01);  // farther from the edges than from the face
    at_m[axis] = side * (half_m[axis] + kToolRadius_m - depth_m);
    const ToolForce force = felt.force(place.out_of(at_m));
    const Vector3d expected_N =
        place.orientation * (kStiffness_N_per_m * depth_m * side * Vector3d(Vector3d::Unit(axis)));
    CHECK((force.force_N - expected_N).norm() <= kStiffness_N_per_m * 2e-6 + 1e-4 * depth_m);
  }
}

TEST_CASE("The force is the field's own where it is placed, its moment at the point of contact",
          "[touched_fields]") {
  Drawn drawn(GENERATE(range(1U, tests::seeds_end(4))));
  const Vector3d half_m(0.011, 0.017, 0.013);
  const Field field =
      box_field(half_m, 0.0013, [](const Vector3d& p) { return 2.0 + 60.0 * p.x(); });
  const FieldPlace place = as_told(somewhere(drawn));
  publication::StaticScene fixed = still_field(fixture(), field, place);
  const Vector3d tool_sphere_m(0.002, -0.031, 0.007);
  fixed.tool[0].position_m = floats(tool_sphere_m);
  Felt felt(fixed);
  int touches = 0;
  for (int i = 0; i < 400; ++i) {
    const Vector3d at_m = drawn.vector(0.02);
    const auto own = collision::field_contact(field->view(), at_m, kToolRadius_m);
    ToolPose pose{.position_m = {}, .orientation = drawn.turn()};
    pose.position_m =
        place.out_of(at_m) -
        pose.orientation * Eigen::Vector3f(fixed.tool[0].position_m.data()).cast<double>();
    const ToolForce force = felt.render(pose).force;
    const double depth_m = own ? std::max(0.0, own->depth_m) : 0.0;
    if (depth_m == 0.0) {
      CHECK(force.force_N.norm() < 1e-6);
      continue;
    }
    ++touches;
    const Vector3d normal = place.orientation * own->normal;
    const double stiffness_N_per_m = kStiffness_N_per_m * own->stiffness_scale;
    CHECK((force.force_N - stiffness_N_per_m * depth_m * normal).norm() < 1e-6);
    CHECK((force.stiffness_N_per_m - stiffness_N_per_m * normal * normal.transpose()).norm() <
          1e-4);
    CHECK(force.static_J == Approx(0.5 * kStiffness_N_per_m * own->map_scale * depth_m * depth_m)
                                .epsilon(1e-6)
                                .margin(1e-9 * kStiffness_N_per_m * depth_m));
    // Without friction the force goes through the sphere's centre.
    const Vector3d lever_m = place.out_of(at_m) - pose.position_m;
    CHECK((force.torque_N_m - lever_m.cross(force.force_N)).norm() < 1e-8);
  }
  CHECK(touches > 100);
}

TEST_CASE("Work against a field is what its spring holds, over any way, and none over a closed one",
          "[touched_fields]") {
  Drawn drawn(GENERATE(range(1U, tests::seeds_end(5))));
  const Vector3d half_m(0.012, 0.015, 0.01);
  // The band is narrower than the way is deep: fine and coarse bricks are crossed.
  const Field field = std::make_shared<collision::DistanceField>(collision::make_field(
      {-half_m, half_m}, {0.0011, 0.0015, kFieldMargin_m},
      [&](const Vector3d& p) { return to_box_m(p, half_m); },
      [](const Vector3d& p) { return 1.5 + 40.0 * p.y(); }));
  const FieldPlace place = somewhere(drawn);
  Felt felt(still_field(fixture(), field, place));
  const Vector3d a = drawn.vector(0.006), b = drawn.vector(0.006), c = drawn.vector(0.006);
  const Vector3d middle_m = 0.014 * drawn.direction();
  const auto at_m = [&](double turn) {
    return place.out_of(middle_m + std::cos(turn) * a + std::sin(turn) * b +
                        std::sin(2.0 * turn) * c);
  };
  constexpr int kSteps = 6000;
  double work_J = 0.0, moved_J = 0.0, highest_J = 0.0, farthest_J = 0.0;
  ToolForce last = felt.force(at_m(0.0));
  const double start_J = last.static_J;
  for (int i = 1; i <= kSteps; ++i) {
    const double before = 2.0 * M_PI * (i - 1) / kSteps, now = 2.0 * M_PI * i / kSteps;
    const ToolForce force = felt.force(at_m(now));
    const double step_J = 0.5 * (force.force_N + last.force_N).dot(at_m(now) - at_m(before));
    work_J += step_J;
    moved_J += std::abs(step_J);
    highest_J = std::max(highest_J, force.static_J);
    farthest_J = std::max(farthest_J, std::abs(work_J - (start_J - force.static_J)));
    last = force;
  }
  CHECK(farthest_J < 1e-5 * highest_J);
  REQUIRE(moved_J > 1e-4);
  CHECK(std::abs(work_J) < 1e-5 * moved_J);
}

TEST_CASE("The force is continuous over all borders of bricks and of the narrow band",
          "[touched_fields]") {
  Drawn drawn(GENERATE(range(1U, tests::seeds_end(4))));
  const Vector3d half_m(0.012, 0.015, 0.01);
  const Field field = std::make_shared<collision::DistanceField>(
      collision::make_field({-half_m, half_m}, {0.0011, 0.0015, kFieldMargin_m},
                            [&](const Vector3d& p) { return to_box_m(p, half_m); }));
  REQUIRE(field->shape().fine_count > 0);
  const FieldPlace place = somewhere(drawn);
  Felt felt(still_field(fixture(), field, place));
  const Vector3d from_m = drawn.vector(0.014), to_m = drawn.vector(0.014);
  double largest_N = 0.0;
  const auto steepest_N = [&](int steps) {
    Vector3d last_N = felt.force(place.out_of(from_m)).force_N;
    double steepest = 0.0;
    for (int i = 1; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      const Vector3d force_N = felt.force(place.out_of(from_m + share * (to_m - from_m))).force_N;
      steepest = std::max(steepest, (force_N - last_N).norm());
      largest_N = std::max(largest_N, force_N.norm());
      last_N = force_N;
    }
    return steepest;
  };
  // What jumps does so however short the steps are.
  const double coarse_N = steepest_N(1500), fine_N = steepest_N(30000);
  REQUIRE(largest_N > 0.5);
  CHECK(fine_N < 0.08 * coarse_N);
}

TEST_CASE("A body that spins drags the tool along as fast as it goes there", "[touched_fields]") {
  Drawn drawn(GENERATE(range(1U, tests::seeds_end(4))));
  publication::StaticScene fixed = fixture();
  constexpr double kFriction = 0.4;
  fixed.materials[0].friction = static_cast<float>(kFriction);
  fixed.tool_slip_speed_m_s = 10.0F;  // all that moves here is viscous
  constexpr double kRadius_m = 0.021;
  const Vector3d centre_m = drawn.vector(0.01);
  FieldPlace place = somewhere(drawn);
  place.velocity_m_s = drawn.vector(0.2);
  place.spin_rad_s = drawn.vector(5.0);
  Felt felt(moving_field(fixed, ball_field(kRadius_m, centre_m)), {place});
  for (int i = 0; i < 60; ++i) {
    const Vector3d normal = drawn.direction();
    const double depth_m = drawn.in(0.0005, 0.003);
    const ToolForce force =
        felt.force(place.out_of(centre_m) + (kRadius_m + kToolRadius_m - depth_m) * normal);
    const Vector3d surface_m = place.out_of(centre_m) + kRadius_m * normal;
    const Vector3d surface_m_s =
        place.velocity_m_s + place.spin_rad_s.cross(surface_m - place.position_m);
    const Vector3d drag_m_s = surface_m_s - normal * normal.dot(surface_m_s);
    const double pressing_N = kStiffness_N_per_m * depth_m;
    const Vector3d expected_N = pressing_N * normal + kFriction * pressing_N / 10.0 * drag_m_s;
    CHECK((force.force_N - expected_N).norm() < 0.025);
    CHECK((force.force_N - pressing_N * normal - (expected_N - pressing_N * normal)).norm() <
          0.02 * kFriction * pressing_N + 0.025);
  }
}

TEST_CASE("Fields push together, each by its own material", "[touched_fields]") {
  publication::StaticScene fixed = fixture();
  fixed.materials.push_back({1300.0F, 0.0F, 0.0F, 1e-3F});
  const FieldPlace left{.position_m = {-0.02, 0.0, 0.0}}, right{.position_m = {0.021, 0.0, 0.0}};
  const Field field = ball_field(0.017);
  fixed = moving_field(still_field(fixed, field, left), field);
  fixed.fields[1].body.material = 1;
  Felt felt(fixed, {right});
  const ToolForce force = felt.force(Vector3d::Zero());
  CHECK(force.contacts == 2);
  const double left_m = 0.005 + 0.017 - 0.02, right_m = 0.005 + 0.017 - 0.021;
  CHECK(force.force_N.x() ==
        Approx(kStiffness_N_per_m * left_m - 1300.0 * right_m).margin(2e3 * 2e-5));
  CHECK(force.static_J == Approx(0.5 * kStiffness_N_per_m * left_m * left_m).epsilon(0.02));
}

TEST_CASE("Points of a body with a field are not felt, however many lie at the tool",
          "[touched_fields]") {
  constexpr std::size_t kPoints = TouchedSpheres::kCapacity + 100;
  PublishedScene scene(moving_field(fixture(), ball_field(0.02)),
                       std::vector<float>(kPoints + 1, 0.001F), kPeriod_ns);
  collision::fill_history(scene.fields.emplace_back(), field_state({}));
  std::vector<Vector3d> positions_m;
  Drawn drawn(5);
  for (std::size_t i = 0; i < kPoints; ++i) {
    scene.records()[i].material = proto::kFieldPoint;
    positions_m.push_back(0.02 * (Vector3d::UnitZ() + drawn.vector(0.15)).normalized());
  }
  positions_m.emplace_back(0.0, 0.1, 0.0);  // of another body
  scene.show(positions_m, kPeriod_ns);
  const auto felt_at = [&](const Vector3d& tool_m) {
    SnapshotRenderer renderer(display::Transition::kHold);
    const RenderedTick tick = renderer.render(scene.view(), {.position_m = tool_m}, kPeriod_ns);
    CHECK_FALSE(tick.truncated);
    return tick.force.contacts;
  };
  CHECK(felt_at({0.0, 0.0, 0.023}) == 1);  // the field
  CHECK(felt_at({0.0, 0.0, 0.0255}) == 0);
  CHECK(felt_at({0.0, 0.103, 0.0}) == 1);
}

}  // namespace stillgrid::rendering::touched_fields_test
