// The transition `predict` on bodies with fields, whose predicted velocities and responses are
// written by hand, beside the sphere that a ball is.

#include <catch2/catch.hpp>
#include <cmath>

#include "shared/rendering/compliant_renderer.hpp"
#include "tests/shared/rendering/field_fixture.hpp"

namespace stillgrid::rendering::predicted_field_test {
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t kPeriod_ns = 32 * kMillisecond_ns;
constexpr std::uint64_t kLate_ns = 9 * kMillisecond_ns;  // of publication, behind what it shows
constexpr double kStiffness_N_per_m = 600.0, kToolRadius_m = 0.005, kRadius_m = 0.018;

publication::StaticScene fixture(float friction = 0.0F) {
  publication::StaticScene scene =
      plain_scene(static_cast<float>(kStiffness_N_per_m), static_cast<float>(kToolRadius_m), 1.5F);
  scene.materials[0].friction = friction;
  return scene;
}

/// A free rigid body: how far its frame's origin goes along each axis for a newton, and how it
/// turns for a newton metre, within a step.
struct Freedom {
  double m_per_N = 0.0, angular_per_N_m = 0.0;

  /// Modes of a step in which the hand pushes with force_N at arm_m from the origin.
  [[nodiscard]] ShownPrediction prediction(const Vector3d& force_N, const Vector3d& arm_m) const {
    ShownPrediction told;
    told.period_ns = kPeriod_ns;
    const Vector3d moment_N_m = arm_m.cross(force_N);
    for (int axis = 0; axis < 3; ++axis)
      told.modes.push_back(mode(std::sqrt(m_per_N) * force_N[axis]));
    for (int axis = 0; axis < 3 && angular_per_N_m > 0.0; ++axis)
      told.modes.push_back(mode(std::sqrt(angular_per_N_m) * moment_N_m[axis]));
    return told;
  }
  /// Of its point at arm_m.
  [[nodiscard]] proto::SphereResponse at(const Vector3d& arm_m) const {
    proto::SphereResponse response{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Vector3d unit = Vector3d::Unit(static_cast<Eigen::Index>(axis));
      response.modes[axis] = floats(std::sqrt(m_per_N) * unit);
      response.modes[3 + axis] = floats(std::sqrt(angular_per_N_m) * unit.cross(arm_m));
    }
    return response;
  }
  [[nodiscard]] proto::SphereResponse turn() const {
    proto::SphereResponse response{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      response.modes[3 + axis] =
          floats(std::sqrt(angular_per_N_m) * Vector3d::Unit(static_cast<Eigen::Index>(axis)));
    return response;
  }
  [[nodiscard]] proto::TurningBody turning(std::uint32_t body, const Vector3d& centre_m) const {
    return {body, floats(centre_m), {}, turn().modes, 0};
  }

 private:
  static proto::ResponseMode mode(double push) {
    return {1.0F, static_cast<float>(push), 0.0F, 0.0F, proto::kOneStep};
  }
};

/// The same ball, by its field and as the sphere that it is.
struct TwoBalls {
  Vector3d arm_m;  // of its middle, in the body's frame
  PublishedScene field, sphere;
  CompliantRenderer of_field = CompliantRenderer{}, of_sphere = CompliantRenderer{};

  explicit TwoBalls(const Vector3d& arm, float friction = 0.0F)
      : arm_m(arm),
        field(moving_field(fixture(friction), ball_field(kRadius_m, arm)), {}, kPeriod_ns),
        sphere(fixture(friction), {static_cast<float>(kRadius_m)}, kPeriod_ns) {
    field.fields.resize(1);
    sphere.records()[0].body = 1;
  }

  void show(const FieldPlace& place, const Vector3d& predicted_m_s, const Freedom& freedom,
            const Vector3d& pushed_N, std::uint64_t time_ns) {
    const Vector3d arm = place.orientation * arm_m;
    ShownPrediction told = freedom.prediction(pushed_N, arm);
    told.turning = {freedom.turning(1, place.position_m)};
    told.responses = {freedom.at(Vector3d::Zero()), freedom.turn()};
    told.late_ns = kLate_ns;
    proto::FieldRecord& record = field.fields[0];
    collision::push_snapshot(record, field_state(place));
    record.predicted_velocity_m_s = floats(predicted_m_s);
    record.response = 1;
    field.show({}, {}, time_ns, 0, told);
    told.responses = {freedom.at(arm)};
    told.predicted_velocity_m_s = {predicted_m_s};
    sphere.show({place.out_of(arm_m)}, {place.velocity_m_s}, time_ns, 0, told);
  }
  struct Both {
    RenderedTick field, sphere;
  };
  [[nodiscard]] Both render(const ToolPose& pose, std::uint64_t now_ns) {
    return {of_field.render(field.view(), pose, now_ns),
            of_sphere.render(sphere.view(), pose, now_ns)};
  }
};

}  // namespace

TEST_CASE("A free ball with a field gives way to the hand as its one sphere does",
          "[predicted_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U, 4U));
  const double turning = GENERATE(0.0, 1.0);
  const Freedom freedom{.m_per_N = drawn.in(5e-4, 3e-3),
                        .angular_per_N_m = turning * drawn.in(0.6, 2.0)};
  // One that turns stands else: how late it is led depends on all of its points.
  const double led = 1.0 - turning;
  TwoBalls balls(0.03 * drawn.direction());
  FieldPlace place{.position_m = drawn.vector(0.05), .orientation = drawn.turn()};
  const Vector3d normal = drawn.direction(), aside = normal.unitOrthogonal();
  const Vector3d start_m = place.out_of(balls.arm_m);
  Vector3d pushed_N = Vector3d::Zero();
  double largest_N = 0.0, farthest_N = 0.0, gave_way_m = 0.0;
  for (std::uint64_t n = 1; n <= 8; ++n) {
    // The next snapshot lies a little off from where the last one led.
    place.position_m += drawn.vector(2e-4);
    place.velocity_m_s = led * drawn.vector(0.02);
    balls.show(place, led * drawn.vector(0.02), freedom, pushed_N, n * kPeriod_ns);
    for (std::uint64_t ms = 0; ms < 32; ++ms) {
      const double time_s = 1e-3 * static_cast<double>(32 * (n - 1) + ms);
      const double depth_m = 0.003 * std::min(1.0, 20.0 * time_s) + 0.001 * std::sin(20.0 * time_s);
      const ToolPose pose{.position_m = start_m + (kRadius_m + kToolRadius_m - depth_m) * normal +
                                        0.002 * std::sin(30.0 * time_s) * aside};
      const auto [field, sphere] =
          balls.render(pose, n * kPeriod_ns + kLate_ns + ms * kMillisecond_ns);
      largest_N = std::max(largest_N, sphere.force.force_N.norm());
      farthest_N = std::max(farthest_N, (field.force.force_N - sphere.force.force_N).norm());
      gave_way_m = std::max(gave_way_m, depth_m - sphere.force.force_N.norm() / kStiffness_N_per_m);
      CHECK(field.unsolved_N < 1e-3);
      REQUIRE(field.prediction_error.has_value() == sphere.prediction_error.has_value());
      if (field.prediction_error) {
        // Of a body that turns one compares the point of contact, the other the middle.
        if (turning == 0.0)
          CHECK(field.prediction_error->distance_m ==
                Approx(sphere.prediction_error->distance_m).epsilon(0.25).margin(8e-5));
        CHECK(field.prediction_error->force_N ==
              Approx(sphere.prediction_error->force_N).epsilon(0.1).margin(0.05));
      }
      if (ms == 31) pushed_N = -sphere.force.force_N;
    }
  }
  CHECK(largest_N > 0.7);
  CHECK(gave_way_m > 3e-4);
  CHECK(farthest_N < 0.03 * largest_N);
}

TEST_CASE("A new snapshot of a body with a field brings no jump, however far off it lies",
          "[predicted_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U, 4U));
  const Vector3d half_m(0.012, 0.017, 0.009);
  PublishedScene scene(moving_field(fixture(), box_field(half_m)), {}, kPeriod_ns);
  scene.fields.resize(1);
  CompliantRenderer renderer;
  SnapshotRenderer held(display::Transition::kHold);
  const Freedom freedom{.m_per_N = 1e-3, .angular_per_N_m = 0.4};
  FieldPlace place{.position_m = drawn.vector(0.05), .orientation = drawn.turn()};
  // On a face, beside its middle.
  const Vector3d at_m(0.004, -0.005, half_m.z() + kToolRadius_m - 0.003);
  const Vector3d tool_m = place.out_of(at_m);
  double jump_N = 0.0, held_N = 0.0, last_N = 0.0, forecast_N = 0.0;
  Vector3d last_force_N = Vector3d::Zero();
  for (std::uint64_t n = 1; n <= 12; ++n) {
    place.position_m += drawn.vector(5e-4);
    place.orientation = Eigen::AngleAxisd(0.02, drawn.direction()) * place.orientation;
    place.spin_rad_s = drawn.vector(0.3);
    ShownPrediction told = freedom.prediction(-last_force_N, tool_m - place.position_m);
    told.responses = {freedom.at(Vector3d::Zero()), freedom.turn()};
    told.turning = {freedom.turning(1, place.position_m)};
    collision::push_snapshot(scene.fields[0], field_state(place));
    scene.fields[0].response = 1;
    scene.show({}, {}, n * kPeriod_ns, 0, told);
    const RenderedTick hold = held.render(scene.view(), {.position_m = tool_m}, n * kPeriod_ns);
    held_N = std::max(held_N, hold.switch_jump_N.value_or(0.0));
    for (std::uint64_t ms = 0; ms < 32; ++ms) {
      const RenderedTick tick = renderer.render(scene.view(), {.position_m = tool_m},
                                                n * kPeriod_ns + ms * kMillisecond_ns);
      if (ms == 0 && n > 1) {
        jump_N = std::max(jump_N, (tick.force.force_N - last_force_N).norm());
        REQUIRE(tick.prediction_error);
        forecast_N = std::max(forecast_N, tick.prediction_error->force_N);
      }
      last_force_N = tick.force.force_N;
      last_N = std::max(last_N, last_force_N.norm());
    }
  }
  CHECK(last_N > 0.5);
  CHECK(held_N > 0.15);
  CHECK(forecast_N > 0.1);
  CHECK(jump_N < 0.15 * held_N);
}

TEST_CASE("A field that turns is led on as it turns", "[predicted_field]") {
  Drawn drawn(GENERATE(1U, 2U, 3U));
  const Vector3d half_m(0.04, 0.03, 0.008);
  PublishedScene scene(moving_field(fixture(), box_field(half_m)), {}, kPeriod_ns);
  scene.fields.resize(1);
  CompliantRenderer renderer;
  const FieldPlace place{.position_m = drawn.vector(0.1),
                         .orientation = drawn.turn(),
                         .velocity_m_s = drawn.vector(0.02),
                         .spin_rad_s = drawn.vector(4.0)};
  collision::fill_history(scene.fields[0], field_state(place));
  ShownPrediction told;
  told.period_ns = kPeriod_ns;
  scene.show({}, {}, kPeriod_ns, 0, told);
  for (std::uint64_t ms = 0; ms < 48; ++ms) {  // from there on it comes to rest
    const FieldPlace now = place.after(1e-3 * static_cast<double>(ms));
    const Vector3d tool_m = now.out_of({0.017, -0.013, half_m.z() + kToolRadius_m - 0.0025});
    const Vector3d arm_m = tool_m - now.position_m;
    const RenderedTick tick =
        renderer.render(scene.view(),
                        {.position_m = tool_m,
                         .velocity_m_s = now.velocity_m_s + now.spin_rad_s.cross(arm_m),
                         .angular_velocity_rad_s = now.spin_rad_s},
                        kPeriod_ns + ms * kMillisecond_ns);
    const Vector3d expected_N = kStiffness_N_per_m * 0.0025 * (now.orientation * Vector3d::UnitZ());
    // The snapshot's velocity is shown, of which the direction turns meanwhile.
    CHECK((tick.force.force_N - expected_N).norm() < 0.03);
  }
}

TEST_CASE("What a hand feels of a pushed body is what pushes it", "[predicted_field]") {
  // A spring of the contact against the body's own inertia: F = K d / (1 + K c share^2).
  Drawn drawn(GENERATE(1U, 2U, 3U));
  const double m_per_N = drawn.in(5e-4, 3e-3), depth_m = drawn.in(0.001, 0.004);
  const Vector3d half_m(0.02, 0.025, 0.022);
  publication::StaticScene fixed = plain_scene(static_cast<float>(kStiffness_N_per_m), 0.005F);
  PublishedScene scene(moving_field(fixed, box_field(half_m)), {}, kPeriod_ns);
  scene.fields.resize(1);
  const FieldPlace place{.position_m = drawn.vector(0.1), .orientation = drawn.turn()};
  collision::fill_history(scene.fields[0], field_state(place));
  scene.fields[0].response = 1;
  const Freedom freedom{.m_per_N = m_per_N};
  ShownPrediction told = freedom.prediction(Vector3d::Zero(), Vector3d::Zero());
  told.responses = {freedom.at(Vector3d::Zero()), freedom.turn()};
  scene.show({}, {}, kPeriod_ns, 0, told);
  CompliantRenderer renderer;
  for (std::uint64_t ms = 0; ms <= 32; ++ms) {
    const double share = static_cast<double>(ms) / 32.0;
    const double height_m = half_m.z() + kToolRadius_m - depth_m;
    const RenderedTick tick =
        renderer.render(scene.view(), {.position_m = place.out_of({0.003, 0.002, height_m})},
                        kPeriod_ns + ms * kMillisecond_ns);
    const double expected_N =
        kStiffness_N_per_m * depth_m / (1.0 + kStiffness_N_per_m * m_per_N * share * share);
    CHECK((tick.force.force_N - expected_N * (place.orientation * Vector3d::UnitZ())).norm() <
          2e-3 * expected_N);
  }
}

}  // namespace stillgrid::rendering::predicted_field_test
