// How the modes of a snapshot move, and how fast they show spheres: their laws, without a tool.

#include "shared/rendering/mode_response.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

#include "shared/display/response.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering::mode_response_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 32'000'000;
constexpr double kPeriod_s = 32e-3;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST_CASE("A mode of stiffness gives way as an implicit step so long does, late or early",
          "[predict]") {
  const float inertia = GENERATE(0.0F, 0.2F, 0.9F, 1.0F);
  const double step_share = GENERATE(0.1, 0.5, 1.0, 1.7, 2.0);
  const proto::ResponseMode mode{.inertia_share = inertia,
                                 .push = 0.3F,
                                 .displacement = 0.5F,
                                 .at_velocity = -0.2F,
                                 .damping_share = proto::kOneStep};
  const display::ModeLaw law = display::mode_law(mode, step_share);
  // In the mode's units a whole step resists by 1: by its inertia, and by stiffness for the rest.
  const double resists = inertia + (1.0 - inertia) * step_share * step_share;
  const double force = 0.5 - inertia * -0.2;  // that with the start's momentum leads to 0.5
  const double whole = (step_share * step_share * force + step_share * inertia * -0.2) / resists;
  CHECK(law.compliance == Approx(step_share * step_share / resists));
  CHECK(law.offset == Approx(step_share > 1.0 ? whole - step_share * 0.5 : 0.0).margin(1e-7));
  // At the step's end the two ways meet.
  CHECK(display::mode_law(mode, 1.0 + 1e-9).offset == Approx(0.0).margin(1e-7));
}

TEST_CASE("A mode that gives way by steps goes as a mass on spring and damper does", "[predict]") {
  // In the mode's units: mu w'' + delta w' + (1 - mu - delta) w = f, held, from speed v.
  const float damping = GENERATE(0.0F, 0.1F, 0.3F);
  const proto::ResponseMode mode{.inertia_share = 0.2F,
                                 .push = 0.3F,
                                 .displacement = 0.5F,
                                 .at_velocity = -0.2F,
                                 .damping_share = damping};
  constexpr double kMore = 0.4;
  constexpr int kSteps = 20000;
  display::ModeState state{0.0, mode.at_velocity};
  double displaced = 0.0;
  for (int i = 1; i <= kSteps; ++i) {
    const double from = 2.0 * (i - 1) / kSteps, to = 2.0 * i / kSteps;
    const display::ModeLaw law = display::step_law(mode, state, from, to);
    displaced = law.offset + law.compliance * kMore;
    state = display::state_after(mode, state, from, to, displaced);
  }
  const double inertia = mode.inertia_share, stiffness = 1.0 - inertia - double{damping};
  const double force = 0.5 + 0.2 * inertia + kMore, rest = force / stiffness;
  const double decay = 0.5 * double{damping} / inertia;
  const double swing = std::sqrt(stiffness / inertia - decay * decay);
  const double expected =
      rest + std::exp(-2.0 * decay) * (-rest * std::cos(2.0 * swing) +
                                       (-0.2 - decay * rest) / swing * std::sin(2.0 * swing));
  CHECK(state.way == Approx(expected).epsilon(2e-3).margin(2e-3));
  CHECK(displaced == Approx(state.way - 2.0 * 0.5));
}

TEST_CASE("A body that turns gives way on the arc, not on its tangent", "[predict]") {
  // About an axis 20 mm off, by half a radian: the sphere stays as far from it.
  display::ModeMotion motion{.rate_per_s = 0.0, .led_s = 0.0, .largest_response = 1.0};
  motion.displacements[0] = 0.5;
  motion.turning[0].body = 3;
  motion.turning[0].centre_m = {0.0F, 0.02F, 0.0F};
  motion.turning[0].turns[0] = {0.0F, 0.0F, 1.0F};
  motion.turning_count = 1;
  display::ResponseMatrix response = display::ResponseMatrix::Zero();
  response.col(0) = Eigen::Vector3f(0.02F, 0.0F, 0.0F);  // turn x arm
  const Eigen::Vector3d moved_m = motion.displacement_m(response, 3, Eigen::Vector3d::Zero());
  CHECK((moved_m - Eigen::Vector3d(0.0, 0.02, 0.0)).norm() == Approx(0.02).epsilon(1e-6));
  CHECK(moved_m.x() == Approx(0.02 * std::sin(0.5)).epsilon(1e-6));
  CHECK(motion.displacement_m(response, 2, Eigen::Vector3d::Zero()).y() == 0.0);
}

TEST_CASE("What gives way by steps is at rest where its snapshot stands", "[predict]") {
  proto::SnapshotHeader snapshot{};
  snapshot.snapshot_id = 3;
  snapshot.prediction_ns = kPeriod_ns;
  snapshot.mode_count = 1;
  snapshot.largest_response = 0.03;
  snapshot.modes[0] = {.inertia_share = 0.5F,
                       .push = 0.1F,
                       .displacement = 0.2F,
                       .at_velocity = 0.3F,
                       .damping_share = 0.1F};
  ModeResponse response;
  response.take(snapshot, {.step_share = 1.9, .pace = 0.4});
  response.motion.displacements[0] = 0.05;
  // A step a thousand times shorter than a tick, then none.
  response.take(snapshot, {.step_share = 1.9 + 1e-5, .pace = 3e-4});
  for (const double pace : {0.0, 0.0}) {
    response.take(snapshot, {.step_share = 1.9 + 1e-5, .pace = pace});
    const double velocity_per_s = response.motion.rate_per_s * response.motion.displacements[0] +
                                  response.motion.drift_per_s[0];
    // Beside that of the snapshot.
    CHECK(velocity_per_s == Approx(-0.3F / kPeriod_s));
  }
}

TEST_CASE("No mode shows a sphere as faster than a hand is", "[predict]") {
  const double drift_per_s = GENERATE(1e5, 1e30, 1e200, kInfinity, kNaN);
  display::ModeMotion motion{.rate_per_s = 1e4, .led_s = 0.0, .largest_response = 1.0};
  motion.drift_per_s[0] = drift_per_s;
  display::ResponseMatrix response = display::ResponseMatrix::Zero();
  response(2, 0) = 0.1F;
  TouchedSphere sphere;
  sphere.base_m_s = {0.0, 0.3, 0.0};
  give_way(motion, response, sphere);
  CHECK(sphere.velocity_m_s.allFinite());
  CHECK((sphere.velocity_m_s - sphere.base_m_s).norm() <= 2.0 + 1e-9);
}

}  // namespace
}  // namespace stillgrid::rendering::mode_response_test
