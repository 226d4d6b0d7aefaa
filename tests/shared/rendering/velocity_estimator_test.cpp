#include "shared/rendering/velocity_estimator.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "shared/tables/trajectory.hpp"
#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid::rendering::velocity_estimator_test {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;
constexpr double kFilter_s = 0.005;  // the contract: delay, and what an encoder's step is over

double to_s(std::uint64_t time_ns) {
  return 1e-9 * static_cast<double>(time_ns);
}

std::vector<std::uint64_t> even_stamps(std::size_t count) {
  std::vector<std::uint64_t> stamps_ns(count);
  for (std::size_t i = 0; i < count; ++i) stamps_ns[i] = i * kTick_ns;
  return stamps_ns;
}

/// From a microsecond to 3 ms apart, some of them 30 ms.
std::vector<std::uint64_t> wild_stamps(std::size_t count) {
  std::mt19937 random(20);
  std::uniform_int_distribution<std::uint64_t> step_ns(1'000, 3'000'000);
  std::vector<std::uint64_t> stamps_ns{0};
  while (stamps_ns.size() < count)
    stamps_ns.push_back(stamps_ns.back() + (random() % 50 == 0 ? 30'000'000 : step_ns(random)));
  return stamps_ns;
}

/// Estimates along x of a motion by time in seconds.
std::vector<double> estimates(const std::vector<std::uint64_t>& stamps_ns,
                              const std::function<double(double)>& position_m) {
  VelocityEstimator estimator;
  std::vector<double> found_m_s;
  found_m_s.reserve(stamps_ns.size());
  for (const std::uint64_t stamp_ns : stamps_ns)
    found_m_s.push_back(estimator.update(stamp_ns, {position_m(to_s(stamp_ns)), 0.0, 0.0}).x());
  return found_m_s;
}

TEST_CASE("On a ramp the estimate reaches the speed, along every axis and whatever the stamps",
          "[velocity_estimator]") {
  VelocityEstimator estimator;
  const Eigen::Vector3d speed_m_s(0.2, -0.1, 0.05);
  Eigen::Vector3d estimate_m_s = Eigen::Vector3d::Zero();
  for (const std::uint64_t stamp_ns : wild_stamps(100))
    estimate_m_s = estimator.update(stamp_ns, speed_m_s * to_s(stamp_ns));
  CHECK((estimate_m_s - speed_m_s).norm() < 1e-12);
}

TEST_CASE("From rest into a ramp two thirds of the speed are known after 5 ms, and so on",
          "[velocity_estimator]") {
  const auto found = estimates(even_stamps(40), [](double time_s) { return 0.3 * time_s; });
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double age = 1e-3 * static_cast<double>(i) / kFilter_s;
    CHECK(found[i] == Approx(0.3 * (1.0 - std::exp(-age))).margin(1e-12));
  }
}

TEST_CASE("A velocity that grows evenly is known 5 ms late, and a little more at a low rate",
          "[velocity_estimator]") {
  const auto step_ns = GENERATE(as<std::uint64_t>{}, 250'000, 500'000, 1'000'000, 2'000'000);
  std::vector<std::uint64_t> stamps_ns;
  for (std::uint64_t time_ns = 0; time_ns <= 200'000'000; time_ns += step_ns)
    stamps_ns.push_back(time_ns);
  const double acceleration_m_s2 = 3.0;
  const auto found = estimates(
      stamps_ns, [&](double time_s) { return 0.5 * acceleration_m_s2 * time_s * time_s; });
  const double delay_s = to_s(stamps_ns.back()) - found.back() / acceleration_m_s2;
  const double step_s = to_s(step_ns);
  // The mean age of the weights: of the geometric series, and half a step for the slope's own.
  CHECK(delay_s == Approx(step_s / std::expm1(step_s / kFilter_s) + 0.5 * step_s).epsilon(1e-9));
  CHECK(delay_s - kFilter_s == Approx(step_s * step_s / (12.0 * kFilter_s)).epsilon(0.02));
}

TEST_CASE("An encoder's steps move the estimate by no more than the step over 5 ms",
          "[velocity_estimator]") {
  const double step_m = 55e-6;
  const double speed_m_s = GENERATE(0.0002, 0.003, 0.0271, 0.11, 0.9);
  const bool is_even = GENERATE(true, false);
  const auto stamps_ns = is_even ? even_stamps(3000) : wild_stamps(3000);
  const auto exact = estimates(stamps_ns, [&](double time_s) { return speed_m_s * time_s; });
  const auto found = estimates(
      stamps_ns, [&](double time_s) { return step_m * std::round(speed_m_s * time_s / step_m); });
  for (std::size_t i = 0; i < found.size(); ++i)
    REQUIRE(std::abs(found[i] - exact[i]) <= step_m / kFilter_s * (1.0 + 1e-9));
}

TEST_CASE("One encoder step shows as nearly the step over 5 ms, and never less than nothing",
          "[velocity_estimator]") {
  const double step_m = 55e-6;
  const auto found =
      estimates(even_stamps(50), [&](double time_s) { return time_s < 0.0095 ? 0.0 : step_m; });
  const auto [least, most] = std::minmax_element(found.begin(), found.end());
  CHECK(*least == 0.0);
  CHECK(*most <= step_m / kFilter_s);
  CHECK(*most > 0.9 * step_m / kFilter_s);
}

TEST_CASE("A sample that is not later than the one before changes nothing",
          "[velocity_estimator]") {
  VelocityEstimator estimator, undisturbed;
  CHECK(estimator.update(5 * kTick_ns, {1.0, 2.0, 3.0}).norm() == 0.0);  // nor does the first
  (void)undisturbed.update(5 * kTick_ns, {1.0, 2.0, 3.0});
  for (std::uint64_t i = 6; i < 30; ++i) {
    const Eigen::Vector3d position_m(1.0, 2.0 + 1e-4 * static_cast<double>(i * i), 3.0);
    const Eigen::Vector3d expected_m_s = undisturbed.update(i * kTick_ns, position_m);
    CHECK(estimator.update(i * kTick_ns, position_m) == expected_m_s);
    CHECK(estimator.update(i * kTick_ns, position_m) == expected_m_s);  // the device repeats it
    CHECK(estimator.update(i * kTick_ns - kTick_ns / 2, {9.0, 9.0, 9.0}) == expected_m_s);
  }
}

TEST_CASE("An estimate lies among the speeds of the past, through stalls and crowded stamps",
          "[velocity_estimator]") {
  // A tap: down at 0.4 m/s, stopped at once, and up at 0.1 m/s.
  const auto tap_m = [](double time_s) {
    return time_s < 0.5 ? -0.4 * time_s : -0.2 + 0.1 * std::max(0.0, time_s - 0.6);
  };
  const bool is_even = GENERATE(true, false);
  const auto stamps_ns = is_even ? even_stamps(1000) : wild_stamps(1000);
  const auto found = estimates(stamps_ns, tap_m);
  for (std::size_t i = 1; i < found.size(); ++i) {
    REQUIRE(found[i] >= -0.4 - 1e-12);
    REQUIRE(found[i] <= 0.1 + 1e-12);
    if (to_s(stamps_ns[i]) < 0.6) REQUIRE(found[i] <= 1e-12);  // it comes to rest, not back
  }
}

TEST_CASE("A stall of 20 ms in a steady motion leaves no trace", "[velocity_estimator]") {
  auto stamps_ns = even_stamps(200);
  for (std::size_t i = 100; i < stamps_ns.size(); ++i) stamps_ns[i] += 20 * kTick_ns;
  const auto found = estimates(stamps_ns, [](double time_s) { return 0.25 * time_s; });
  for (std::size_t i = 60; i < found.size(); ++i) CHECK(found[i] == Approx(0.25).epsilon(1e-5));
}

TEST_CASE("On recorded motions an encoder's steps are felt at a third of their bound, rms",
          "[velocity_estimator][real_data]") {
  const auto folder = devices::real_recordings();
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: no recordings in " << folder);
    return;
  }
  const auto [name, map] = GENERATE(table<std::string, std::string>(
      {{"teleop_1dof_2khz/m2_question1a_spring.csv", "x_m:slave_rad*0.075"},
       {"teleop_1dof_2khz/question1a_free_motion.csv", "x_m:slave_rad*0.075"},
       {"franka_1khz/franka_20260223_162545.csv", "x_m:x_m*0.15"},
       {"ku_contour_force/demo_a_1.csv", "x_m:y_mm*0.001"}}));
  const double step_m = GENERATE(23e-6, 30e-6, 55e-6);
  tables::TrajectoryOptions options;
  options.map = tables::parse_axis_map(map);
  const tables::Trajectory motion = tables::read_trajectory((folder / name).string(), options);

  VelocityEstimator of_exact, of_rounded;
  double squares = 0.0;
  for (std::size_t i = 0; i < motion.time_s.size(); ++i) {
    const auto stamp_ns = static_cast<std::uint64_t>(std::llround(1e9 * motion.time_s[i]));
    const Eigen::Vector3d exact_m = motion.position_m[i];
    const Eigen::Vector3d rounded_m = step_m * (exact_m / step_m).array().round();
    const double off_m_s =
        (of_rounded.update(stamp_ns, rounded_m) - of_exact.update(stamp_ns, exact_m)).norm();
    REQUIRE(off_m_s <= step_m / kFilter_s);
    squares += off_m_s * off_m_s;
  }
  const double rms_m_s = std::sqrt(squares / static_cast<double>(motion.time_s.size()));
  CAPTURE(name, step_m, rms_m_s);
  CHECK(rms_m_s < step_m / kFilter_s / 3.0);
  CHECK(rms_m_s > step_m / kFilter_s / 50.0);
}

TEST_CASE("A steady rotation is estimated about its axis, whichever sign its quaternion has",
          "[velocity_estimator]") {
  AngularVelocityEstimator estimator;
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
  Eigen::Vector3d velocity_rad_s = Eigen::Vector3d::Zero();
  for (std::uint64_t ms = 0; ms <= 60; ++ms) {
    Eigen::Quaterniond turn(Eigen::AngleAxisd(0.05 * static_cast<double>(ms), axis));
    if (ms % 2 == 1) turn.coeffs() *= -1.0;
    velocity_rad_s = estimator.update(ms * kTick_ns, turn);
  }
  CHECK((velocity_rad_s - 50.0 * axis).norm() < 50.0 * 1e-4);
}

TEST_CASE("A tool that never turns has no angular velocity at all", "[velocity_estimator]") {
  AngularVelocityEstimator estimator;
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.1).normalized();
  for (std::uint64_t ms = 0; ms <= 10; ++ms)
    CHECK(estimator.update(ms * kTick_ns, turn) == Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace stillgrid::rendering::velocity_estimator_test
