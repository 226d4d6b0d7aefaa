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

}  // namespace
}  // namespace stillgrid
