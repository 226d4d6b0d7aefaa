#include "haptic_server/safety/force_guard.hpp"

#include <catch2/catch.hpp>
#include <limits>

namespace stillgrid {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kLever_m = 0.2;
const ImageFreshness kFresh{
    .exists = true, .image_age_s = 0.0, .period_s = 0.033, .writer_alive = true};

Wrench push(double x_N, double y_N, double z_N) {
  return {{x_N, y_N, z_N}, Eigen::Vector3d::Zero()};
}

ForceGuard warmed_up(const GuardLimits& limits) {
  ForceGuard guard(limits);
  std::uint32_t flags = 0;
  for (int i = 0; i < 101; ++i)
    (void)guard.apply(push(1.0, 0.0, 0.0), kLever_m, kFresh, kTick_s, flags);
  return guard;
}

TEST_CASE("A force within the limits passes unchanged and unflagged", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  const Eigen::Vector3d force_N(1.0, -2.0, 0.5);
  CHECK(guard.apply({force_N, {}}, kLever_m, kFresh, kTick_s, flags).force_N == force_N);
  CHECK(flags == 0);
}

TEST_CASE("The norm is cut to the limit and the direction kept", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  const Eigen::Vector3d force_N =
      guard.apply(push(30.0, 40.0, 0.0), kLever_m, kFresh, kTick_s, flags).force_N;
  CHECK((force_N - Eigen::Vector3d(1.98, 2.64, 0.0)).norm() < 1e-12);
  CHECK(flags == kFlagClamped);
}

TEST_CASE("The torque is shortened, slewed and faded with its force", "[force_guard]") {
  const Wrench rendered{{30.0, 40.0, 0.0}, {1.0, -2.0, 3.0}};
  std::uint32_t flags = 0;
  ForceGuard clamping = warmed_up({.max_force_N = 2.5, .max_slew_N_per_ms = std::nullopt});
  const Wrench clamped = clamping.apply(rendered, kLever_m, kFresh, kTick_s, flags);
  CHECK((clamped.torque_N_m - 0.05 * rendered.torque_N_m).norm() < 1e-12);

  ForceGuard slewing = warmed_up({.max_force_N = 100.0, .max_slew_N_per_ms = 0.5});
  const Wrench slewed =
      slewing.apply({{6.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, kLever_m, kFresh, kTick_s, flags);
  CHECK(slewed.force_N.x() == Approx(1.5));  // a tenth of the way
  CHECK(slewed.torque_N_m.x() == Approx(0.1));

  ForceGuard fading({.max_force_N = 100.0, .max_slew_N_per_ms = std::nullopt});
  const Wrench faded = fading.apply(rendered, kLever_m, kFresh, kTick_s, flags);
  CHECK((faded.torque_N_m - 0.01 * rendered.torque_N_m).norm() < 1e-12);
}

TEST_CASE("A couple without a force is limited to what the force's limit makes at the lever",
          "[force_guard]") {
  const Wrench couple{{0.0, 0.0, 0.0}, {0.0, 50.0, 0.0}};
  ForceGuard clamping = warmed_up({.max_force_N = 5.0, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  const Wrench clamped = clamping.apply(couple, kLever_m, kFresh, kTick_s, flags);
  CHECK(clamped.torque_N_m.y() == Approx(5.0 * kLever_m));
  CHECK(flags == kFlagClamped);

  ForceGuard slewing({.max_force_N = 5.0, .max_slew_N_per_ms = 0.1});
  for (int i = 0; i < 101; ++i) (void)slewing.apply({}, kLever_m, kFresh, kTick_s, flags);
  flags = 0;
  const Wrench slewed = slewing.apply(couple, kLever_m, kFresh, kTick_s, flags);
  CHECK(slewed.torque_N_m.y() == Approx(0.1 * kLever_m));
  CHECK((flags & kFlagSlewed) != 0);
}

TEST_CASE("A torque that is no number takes the force with it", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Wrench told =
      guard.apply({{1.0, 0.0, 0.0}, {0.0, nan, 0.0}}, kLever_m, kFresh, kTick_s, flags);
  CHECK(told.force_N.norm() == 0.0);
  CHECK(told.torque_N_m.norm() == 0.0);
  CHECK(flags == kFlagRejected);
}

TEST_CASE("A force that is no number becomes zero", "[force_guard]") {
  const double bad =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  CHECK(guard.apply(push(0.0, bad, 0.0), kLever_m, kFresh, kTick_s, flags).force_N.norm() == 0.0);
  CHECK((flags & kFlagRejected) != 0);
}

TEST_CASE("The force ramps in from zero over 100 ms", "[force_guard]") {
  ForceGuard guard({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  CHECK(guard.apply(push(1.0, 0.0, 0.0), kLever_m, kFresh, kTick_s, flags).force_N.x() ==
        Approx(0.01));
  CHECK(flags == kFlagFaded);
  for (int i = 0; i < 49; ++i)
    (void)guard.apply(push(1.0, 0.0, 0.0), kLever_m, kFresh, kTick_s, flags);
  CHECK(guard.apply(push(1.0, 0.0, 0.0), kLever_m, kFresh, kTick_s, flags).force_N.x() ==
        Approx(0.51));
}

TEST_CASE("A stale image fades to zero between 1.5 periods and 100 ms later", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  ImageFreshness ageing = kFresh;
  std::uint32_t flags = 0;
  double previous_N = 1.0;
  for (int ms = 1; ms <= 160; ++ms) {
    ageing.image_age_s = ms * 1e-3;
    flags = 0;
    const double force_N =
        guard.apply(push(1.0, 0.0, 0.0), kLever_m, ageing, kTick_s, flags).force_N.x();
    CHECK(previous_N - force_N < 0.0101);
    if (ms <= 49) CHECK(force_N == 1.0);
    if (ms >= 150) CHECK(force_N == 0.0);
    previous_N = force_N;
  }
  CHECK(flags == kFlagFaded);
}

TEST_CASE("A dead simulation fades at once, whatever the image's age", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  ImageFreshness dead = kFresh;
  dead.writer_alive = false;
  std::uint32_t flags = 0;
  for (int ms = 1; ms <= 99; ++ms)
    CHECK(guard.apply(push(1.0, 0.0, 0.0), kLever_m, dead, kTick_s, flags).force_N.x() < 1.0);
  (void)guard.apply(push(1.0, 0.0, 0.0), kLever_m, dead, kTick_s, flags);
  CHECK(guard.apply(push(1.0, 0.0, 0.0), kLever_m, dead, kTick_s, flags).force_N.x() == 0.0);
}

TEST_CASE("The slew limit bounds each change, also of a jump to zero", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = 0.05});
  Eigen::Vector3d previous_N(1.0, 0.0, 0.0);
  for (int i = 0; i < 40; ++i) {
    std::uint32_t flags = 0;
    const Eigen::Vector3d force_N =
        guard.apply(push(0.0, 2.0, 0.0), kLever_m, kFresh, kTick_s, flags).force_N;
    CHECK((force_N - previous_N).norm() <= 0.05 + 1e-12);
    CHECK((flags & kFlagSlewed) != 0);
    previous_N = force_N;
  }
}

TEST_CASE("The slew limit does not hold a dead simulation's force beyond the fade",
          "[force_guard]") {
  ForceGuard guard({.max_force_N = 3.3, .max_slew_N_per_ms = 0.002});
  std::uint32_t flags = 0;
  for (int i = 0; i < 2000; ++i)
    (void)guard.apply(push(2.0, 0.0, 0.0), kLever_m, kFresh, kTick_s, flags);
  ImageFreshness dead = kFresh;
  dead.writer_alive = false;
  double force_N = 2.0;
  for (int ms = 1; ms <= 101; ++ms)
    force_N = guard.apply(push(2.0, 0.0, 0.0), kLever_m, dead, kTick_s, flags).force_N.x();
  CHECK(force_N == 0.0);
  CHECK(guard.is_silent());
}

}  // namespace
}  // namespace stillgrid
