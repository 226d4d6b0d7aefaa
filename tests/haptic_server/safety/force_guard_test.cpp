#include "haptic_server/safety/force_guard.hpp"

#include <catch2/catch.hpp>
#include <limits>

namespace stillgrid {
namespace {

constexpr double kTick_s = 1e-3;
const ImageFreshness kFresh{
    .exists = true, .image_age_s = 0.0, .period_s = 0.033, .writer_alive = true};

ForceGuard warmed_up(const GuardLimits& limits) {
  ForceGuard guard(limits);
  std::uint32_t flags = 0;
  for (int i = 0; i < 101; ++i) (void)guard.apply({1.0, 0.0, 0.0}, kFresh, kTick_s, flags);
  return guard;
}

TEST_CASE("A force within the limits passes unchanged and unflagged", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  const Eigen::Vector3d force_N(1.0, -2.0, 0.5);
  CHECK(guard.apply(force_N, kFresh, kTick_s, flags) == force_N);
  CHECK(flags == 0);
}

TEST_CASE("The norm is cut to the limit and the direction kept", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  const Eigen::Vector3d force_N = guard.apply({30.0, 40.0, 0.0}, kFresh, kTick_s, flags);
  CHECK((force_N - Eigen::Vector3d(1.98, 2.64, 0.0)).norm() < 1e-12);
  CHECK(flags == kFlagClamped);
}

TEST_CASE("A force that is no number becomes zero", "[force_guard]") {
  const double bad =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  CHECK(guard.apply({0.0, bad, 0.0}, kFresh, kTick_s, flags).norm() == 0.0);
  CHECK((flags & kFlagRejected) != 0);
}

TEST_CASE("The force ramps in from zero over 100 ms", "[force_guard]") {
  ForceGuard guard({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  std::uint32_t flags = 0;
  CHECK(guard.apply({1.0, 0.0, 0.0}, kFresh, kTick_s, flags).x() == Approx(0.01));
  CHECK(flags == kFlagFaded);
  for (int i = 0; i < 49; ++i) (void)guard.apply({1.0, 0.0, 0.0}, kFresh, kTick_s, flags);
  CHECK(guard.apply({1.0, 0.0, 0.0}, kFresh, kTick_s, flags).x() == Approx(0.51));
}

TEST_CASE("A stale image fades to zero between 1.5 periods and 100 ms later", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = std::nullopt});
  ImageFreshness ageing = kFresh;
  std::uint32_t flags = 0;
  double previous_N = 1.0;
  for (int ms = 1; ms <= 160; ++ms) {
    ageing.image_age_s = ms * 1e-3;
    flags = 0;
    const double force_N = guard.apply({1.0, 0.0, 0.0}, ageing, kTick_s, flags).x();
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
    CHECK(guard.apply({1.0, 0.0, 0.0}, dead, kTick_s, flags).x() < 1.0);
  (void)guard.apply({1.0, 0.0, 0.0}, dead, kTick_s, flags);
  CHECK(guard.apply({1.0, 0.0, 0.0}, dead, kTick_s, flags).x() == 0.0);
}

TEST_CASE("The slew limit bounds each change, also of a jump to zero", "[force_guard]") {
  ForceGuard guard = warmed_up({.max_force_N = 3.3, .max_slew_N_per_ms = 0.05});
  Eigen::Vector3d previous_N(1.0, 0.0, 0.0);
  for (int i = 0; i < 40; ++i) {
    std::uint32_t flags = 0;
    const Eigen::Vector3d force_N = guard.apply({0.0, 2.0, 0.0}, kFresh, kTick_s, flags);
    CHECK((force_N - previous_N).norm() <= 0.05 + 1e-12);
    CHECK((flags & kFlagSlewed) != 0);
    previous_N = force_N;
  }
}

TEST_CASE("The slew limit does not hold a dead simulation's force beyond the fade",
          "[force_guard]") {
  ForceGuard guard({.max_force_N = 3.3, .max_slew_N_per_ms = 0.002});
  std::uint32_t flags = 0;
  for (int i = 0; i < 2000; ++i) (void)guard.apply({2.0, 0.0, 0.0}, kFresh, kTick_s, flags);
  ImageFreshness dead = kFresh;
  dead.writer_alive = false;
  double force_N = 2.0;
  for (int ms = 1; ms <= 101; ++ms)
    force_N = guard.apply({2.0, 0.0, 0.0}, dead, kTick_s, flags).x();
  CHECK(force_N == 0.0);
  CHECK(guard.is_silent());
}

}  // namespace
}  // namespace stillgrid
