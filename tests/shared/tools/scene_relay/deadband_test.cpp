// A deadband on drawn hands: what it keeps back is what the receiver knows.

#include "shared/tools/scene_relay/deadband.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <vector>

namespace stillgrid::scene_relay::deadband_test {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;

Eigen::Vector3d vector(const std::array<double, 3>& v) {
  return Eigen::Vector3d(v.data());
}

/// Some seconds of a hand that moves by a few sines of up to 8 Hz, turns, and stands in between.
std::vector<proto::ToolState> drawn_hand(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.1, 1.0);
  const Eigen::Vector3d size_m =
      0.03 * Eigen::Vector3d(share(random), share(random), share(random));
  const Eigen::Array3d rate_per_s =
      50.0 * Eigen::Array3d(share(random), share(random), share(random));
  const double spin_rad_s = 2.0 * share(random);
  std::vector<proto::ToolState> hand;
  for (int i = 0; i < 3000; ++i) {
    const double time_s = i < 1500 ? 1e-3 * i : i < 2000 ? 1.5 : 1e-3 * (i - 500);
    const bool stands = i >= 1500 && i < 2000;
    const Eigen::Array3d phase = rate_per_s * time_s;
    const Eigen::Vector3d position_m = size_m.array() * phase.sin();
    const Eigen::Vector3d velocity_m_s =
        stands ? Eigen::Vector3d::Zero()
               : Eigen::Vector3d(size_m.array() * rate_per_s * phase.cos());
    const double half_rad = 0.5 * spin_rad_s * time_s;
    proto::ToolState& state = hand.emplace_back();
    state.time_ns = (static_cast<std::uint64_t>(i) + 1) * kTick_ns;
    state.position_m = {position_m.x(), position_m.y(), position_m.z()};
    state.velocity_m_s = {velocity_m_s.x(), velocity_m_s.y(), velocity_m_s.z()};
    state.orientation_xyzw = {0.0, std::sin(half_rad), 0.0, std::cos(half_rad)};
    state.buttons = i > 700 && i < 903 ? 1 : 0;
  }
  return hand;
}

Eigen::Quaterniond turn_of(const proto::ToolState& state) {
  const auto& [x, y, z, w] = state.orientation_xyzw;
  return {w, x, y, z};
}

}  // namespace

TEST_CASE("What is kept back differs from what the receiver knows by no more than the limits") {
  const DeadbandLimits limits;
  std::size_t sent = 0, samples = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Deadband deadband(limits);
    proto::ToolState last{};
    for (const proto::ToolState& sample : drawn_hand(seed)) {
      ++samples;
      if (deadband.must_send(sample)) {
        last = sample;
        ++sent;
      }
      CAPTURE(seed, sample.time_ns);
      const proto::ToolState known = led_on(last, sample.time_ns - last.time_ns);
      const double speed_m_s = std::max(vector(last.velocity_m_s).norm(), limits.slow_m_s);
      REQUIRE((vector(sample.position_m) - vector(known.position_m)).norm() <= limits.distance_m);
      REQUIRE((vector(sample.velocity_m_s) - vector(last.velocity_m_s)).norm() <=
              limits.velocity_share * speed_m_s);
      REQUIRE(turn_of(sample).angularDistance(turn_of(known)) <= limits.angle_rad + 1e-9);
      REQUIRE(sample.buttons == known.buttons);
      REQUIRE(known.time_ns == sample.time_ns);
      REQUIRE(sample.time_ns - last.time_ns < limits.silence_ns);
    }
  }
  CHECK(sent < samples / 2);  // else it would save nothing
}

TEST_CASE("A hand that stands is sent once a silence and no oftener") {
  proto::ToolState still{};
  still.orientation_xyzw = {0.0, 0.0, 0.0, 1.0};
  Deadband deadband({.silence_ns = 25 * kTick_ns});
  int sent = 0;
  for (int i = 1; i <= 1000; ++i) {
    still.time_ns = static_cast<std::uint64_t>(i) * kTick_ns;
    sent += deadband.must_send(still) ? 1 : 0;
  }
  CHECK(sent == 40);
}

TEST_CASE("A wider deadband sends no more of a hand than a narrower one") {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::size_t before = std::numeric_limits<std::size_t>::max();
    for (const double share : {0.02, 0.07, 0.15}) {
      Deadband deadband({.velocity_share = share});
      std::size_t sent = 0;
      for (const proto::ToolState& sample : drawn_hand(seed)) sent += deadband.must_send(sample);
      CAPTURE(seed, share);
      CHECK(sent < before);
      before = sent;
    }
  }
}

TEST_CASE("What is no number, comes out of order or before another receiver is sent") {
  proto::ToolState state{};
  state.orientation_xyzw = {0.0, 0.0, 0.0, 1.0};
  state.time_ns = 7 * kTick_ns;
  Deadband deadband;
  REQUIRE(deadband.must_send(state));
  state.time_ns += kTick_ns;
  REQUIRE_FALSE(deadband.must_send(state));
  SECTION("no number") {
    state.position_m[1] = std::numeric_limits<double>::quiet_NaN();
    CHECK(deadband.must_send(state));
  }
  SECTION("out of order") {
    state.time_ns -= 2 * kTick_ns;
    CHECK(deadband.must_send(state));
  }
  SECTION("another receiver") {
    deadband.begin_anew();
    CHECK(deadband.must_send(state));
  }
  SECTION("the opposite quaternion is the same turn") {
    state.orientation_xyzw = {0.0, 0.0, 0.0, -1.0};
    CHECK_FALSE(deadband.must_send(state));
  }
}

TEST_CASE("A sample is led on straight, and stands when none has come for too long") {
  const proto::ToolState sample = drawn_hand(3)[217];
  const auto way_m = [&](std::uint64_t by_ns) {
    return (vector(led_on(sample, by_ns).position_m) - vector(sample.position_m)).norm();
  };
  const double speed_m_s = vector(sample.velocity_m_s).norm();
  CHECK(way_m(0) == 0.0);
  CHECK(way_m(13 * kTick_ns) == Approx(0.013 * speed_m_s));
  CHECK(way_m(kLongestLead_ns) == Approx(1e-9 * kLongestLead_ns * speed_m_s));
  CHECK(way_m(9 * kLongestLead_ns) == Approx(way_m(kLongestLead_ns)));
  CHECK(vector(led_on(sample, kLongestLead_ns + 1).velocity_m_s).isZero());
}

}  // namespace stillgrid::scene_relay::deadband_test
