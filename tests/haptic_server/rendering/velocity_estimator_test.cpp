#include "haptic_server/rendering/velocity_estimator.hpp"

#include <catch2/catch.hpp>
#include <cmath>

namespace stillgrid {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;

TEST_CASE("On a ramp the estimate reaches the speed, two thirds of it within 5 ms",
          "[velocity_estimator]") {
  VelocityEstimator estimator;
  const Eigen::Vector3d speed_m_s(0.2, -0.1, 0.05);
  Eigen::Vector3d estimate_m_s;
  for (std::uint64_t i = 0; i <= 100; ++i) {
    estimate_m_s = estimator.update(i * kTick_ns, speed_m_s * (static_cast<double>(i) * 1e-3));
    if (i == 5) CHECK(estimate_m_s.x() == Approx(0.2 * (1.0 - std::exp(-1.0))));
  }
  CHECK((estimate_m_s - speed_m_s).norm() < 1e-8);
}

TEST_CASE("One encoder step shows as at most the step over 5 ms", "[velocity_estimator]") {
  VelocityEstimator estimator;
  const double step_m = 55e-6;
  double largest_m_s = 0.0;
  for (std::uint64_t i = 0; i < 50; ++i) {
    const Eigen::Vector3d position_m(i < 10 ? 0.0 : step_m, 0.0, 0.0);
    largest_m_s = std::max(largest_m_s, estimator.update(i * kTick_ns, position_m).norm());
  }
  CHECK(largest_m_s <= step_m / 0.005);
  CHECK(largest_m_s > 0.5 * step_m / 0.005);
}

TEST_CASE("The first sample, and a stamp that stands still, tell no speed",
          "[velocity_estimator]") {
  VelocityEstimator estimator;
  CHECK(estimator.update(kTick_ns, {1.0, 2.0, 3.0}).norm() == 0.0);
  CHECK(estimator.update(kTick_ns, {9.0, 2.0, 3.0}).norm() == 0.0);
}

TEST_CASE("A steady rotation is estimated about its axis, whichever sign its quaternion has",
          "[velocity_estimator]") {
  AngularVelocityEstimator estimator;
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  Eigen::Vector3d velocity_rad_s = Eigen::Vector3d::Zero();
  for (std::uint64_t ms = 0; ms <= 60; ++ms) {
    Eigen::Quaterniond turn(Eigen::AngleAxisd(0.05 * static_cast<double>(ms), axis));
    if (ms % 2 == 1) turn.coeffs() *= -1.0;
    velocity_rad_s = estimator.update(ms * 1'000'000, turn);
  }
  CHECK((velocity_rad_s - 50.0 * axis).norm() < 50.0 * 1e-4);
}

TEST_CASE("A tool that never turns has no angular velocity at all", "[velocity_estimator]") {
  AngularVelocityEstimator estimator;
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.1).normalized();
  for (std::uint64_t ms = 0; ms <= 10; ++ms)
    CHECK(estimator.update(ms * 1'000'000, turn) == Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace stillgrid
