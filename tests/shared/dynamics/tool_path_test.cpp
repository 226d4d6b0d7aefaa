#include "shared/dynamics/tool_path.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <random>

#include "shared/publication/tool_segment.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::dynamics::tool_path_test {
namespace {

static_assert(TickPath::kLength == proto::kPathLength);

Eigen::Quaterniond turn_rad(double angle_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0));
}

/// Even motion.
PathPose pose_of(std::uint64_t n) {
  const auto t = static_cast<double>(n);
  return {{{1e-3 * t, -2e-3 * t, 0.1}, turn_rad(0.01 * t), {1.0, -2.0, 1e-2 * t}}, n};
}

bool are_equal(const PathPose& a, const PathPose& b) {
  return a.number == b.number && a.position_m == b.position_m &&
         a.orientation.coeffs() == b.orientation.coeffs() && a.velocity_m_s == b.velocity_m_s;
}

proto::ToolState state_of(const PathPose& pose) {
  proto::ToolState state{};
  state.path_number = pose.number;
  Eigen::Map<Eigen::Vector3d>(state.position_m.data()) = pose.position_m;
  Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw.data()) = pose.orientation.coeffs();
  Eigen::Map<Eigen::Vector3d>(state.velocity_m_s.data()) = pose.velocity_m_s;
  return state;
}

struct PublishedPath {
  publication::TestSession session;
  publication::ToolWriter writer{session.name(), 1'000'000, proto::Clock::kVirtual, 0};
  publication::ToolView view{*publication::SegmentReader::open(
      session.name(), proto::SegmentKind::kTool, proto::kToolLayoutHash)};
};

TEST_CASE("A path has a pose from its oldest sample to its newest, and none beyond",
          "[tool_path]") {
  TickPath path;
  CHECK_FALSE(path.newest());
  CHECK_FALSE(path.oldest());
  CHECK_FALSE(path.pose_at(0));

  path.add(pose_of(0));
  CHECK(path.oldest() == 0);
  CHECK(path.newest() == 0);
  REQUIRE(path.pose_at(0));
  CHECK_FALSE(path.pose_at(1));
  for (std::uint64_t n = 1; n < 10'000; ++n) path.add(pose_of(n));
  CHECK(path.newest() == 9999);
  CHECK(path.oldest() == 10'000 - TickPath::kLength);
  CHECK_FALSE(path.pose_at(*path.oldest() - 1));
  CHECK_FALSE(path.pose_at(10'000));
  for (std::uint64_t n = *path.oldest(); n < 10'000; ++n)
    if (path.pose_at(n)->position_m != pose_of(n).position_m) FAIL_CHECK(n);
}

TEST_CASE("A sample that is not newer changes nothing", "[tool_path]") {
  TickPath path;
  path.add(pose_of(5));
  PathPose again = pose_of(5);
  again.position_m.setOnes();
  path.add(again);
  path.add(pose_of(4));
  CHECK(path.oldest() == 5);
  CHECK(path.pose_at(5)->position_m == pose_of(5).position_m);
}

TEST_CASE("A gap is filled evenly between its neighbours", "[tool_path]") {
  const std::uint64_t gap = GENERATE(2U, 3U, 7U, 100U);
  TickPath path;
  path.add(pose_of(40));
  CHECK_FALSE(path.pose_at(41));
  path.add(pose_of(40 + gap));
  path.add(pose_of(41 + gap));
  for (std::uint64_t n = 40; n <= 41 + gap; ++n) {
    const auto pose = path.pose_at(n);
    REQUIRE(pose);
    CHECK(pose->number == n);
    CHECK((pose->position_m - pose_of(n).position_m).norm() < 1e-15);
    CHECK((pose->velocity_m_s - pose_of(n).velocity_m_s).norm() < 1e-14);
    CHECK(pose->orientation.angularDistance(pose_of(n).orientation) < 1e-7);
    CHECK((pose->orientation.conjugate() * pose_of(n).orientation).vec().norm() < 1e-15);
    CHECK(std::abs(pose->orientation.norm() - 1.0) < 1e-15);
  }
}

TEST_CASE("A path's orientations are unit quaternions", "[tool_path]") {
  TickPath path;
  PathPose pose = pose_of(3);
  pose.orientation.coeffs() *= 1.0004;
  path.add(pose);
  CHECK(std::abs(path.pose_at(3)->orientation.norm() - 1.0) < 1e-15);
}

TEST_CASE("The shorter way is taken whatever the signs of the quaternions", "[tool_path]") {
  TickPath path;
  path.add({{{0.0, 0.0, 0.0}, turn_rad(0.0), {0.0, 0.0, 0.0}}, 0});
  PathPose after{{{0.0, 0.0, 0.0}, turn_rad(0.2), {0.0, 0.0, 0.0}}, 2};
  after.orientation.coeffs() *= -1.0;
  path.add(after);
  CHECK(path.pose_at(1)->orientation.angularDistance(turn_rad(0.1)) < 1e-7);
}

TEST_CASE("In a longer gap the tool was away", "[tool_path]") {
  TickPath path;
  path.add(pose_of(10));
  path.add(pose_of(11 + TickPath::kLongestGap));
  CHECK(path.pose_at(10));
  CHECK(path.pose_at(11 + TickPath::kLongestGap));
  for (std::uint64_t n = 11; n < 11 + TickPath::kLongestGap; ++n) CHECK_FALSE(path.pose_at(n));
}

TEST_CASE("A simulation that follows at its own times gets the hand's path to the bit",
          "[tool_path]") {
  std::mt19937_64 random(GENERATE(1U, 2U, 3U));
  PublishedPath published;
  TickPath own, followed;
  follow(published.view.path(), followed);
  CHECK_FALSE(followed.newest());
  std::uint64_t n = random() % 3;
  std::normal_distribution<double> drawn;
  for (int i = 0; i < 20'000; ++i, n += 1 + (random() % 50 == 0 ? random() % 120 : 0)) {
    PathPose pose{{{drawn(random), drawn(random), drawn(random)},
                   turn_rad(drawn(random)),
                   {drawn(random), drawn(random), drawn(random)}},
                  n};
    pose.orientation.coeffs() *= 1.0 + 1e-5 * drawn(random);
    published.writer.publish(state_of(pose));
    own.add(pose);
    if (random() % 100 == 0) follow(published.view.path(), followed);
  }
  follow(published.view.path(), followed);
  REQUIRE(followed.newest() == own.newest());
  int filled = 0, away = 0;
  for (std::uint64_t k = std::max(*own.oldest(), *followed.oldest()); k <= *own.newest(); ++k) {
    const auto a = own.pose_at(k), b = followed.pose_at(k);
    REQUIRE(a.has_value() == b.has_value());
    away += a ? 0 : 1;
    if (!a) continue;
    if (!are_equal(*a, *b)) FAIL_CHECK(k);
    filled += published.view.path().sample(k) ? 0 : 1;
  }
  CHECK(filled > 100);
  CHECK(away > 100);
}

TEST_CASE("Of a path that was not read for long its last samples are followed", "[tool_path]") {
  PublishedPath published;
  TickPath followed;
  for (std::uint64_t n = 0; n < 50; ++n) published.writer.publish(state_of(pose_of(n)));
  follow(published.view.path(), followed);
  CHECK(followed.oldest() == 0);
  for (std::uint64_t n = 50; n < 6000; ++n) published.writer.publish(state_of(pose_of(n)));
  follow(published.view.path(), followed);
  const std::uint64_t kept = 6000 - TickPath::kLength;
  CHECK(followed.newest() == 5999);
  CHECK(followed.oldest() == kept);
}

/// A writer that claims any newest number.
struct HostileView {
  std::uint64_t claimed;
  std::size_t* asked;
  [[nodiscard]] std::optional<std::uint64_t> newest() const { return claimed; }
  [[nodiscard]] std::optional<proto::PathSample> sample(std::uint64_t n) const {
    ++*asked;
    if (n % 3 != 0) return std::nullopt;
    return proto::PathSample{n, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}};
  }
};

TEST_CASE("A hostile newest number costs a bounded number of looks", "[tool_path]") {
  TickPath path;
  std::size_t asked = 0;
  for (const std::uint64_t claimed : {std::uint64_t{0}, std::uint64_t{77}, std::uint64_t{5},
                                      std::uint64_t{1} << 40, proto::kNever - 1}) {
    asked = 0;
    follow(HostileView{claimed, &asked}, path);
    CHECK(asked <= TickPath::kLength);
  }
  CHECK(path.newest() == proto::kNever - 1 - (proto::kNever - 1) % 3);
}

}  // namespace
}  // namespace stillgrid::dynamics::tool_path_test
