#include "haptic_server/devices/mouse_handle.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <optional>

#include "tests/haptic_server/devices/allocation_counter.hpp"

namespace stillgrid::devices::mouse_handle_test {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;

Path path_at_origin(PathKind kind) {
  Path path;
  path.kind = kind;
  path.centre_m.setZero();
  return path;
}

/// A handle in virtual time, and a wall: a spring in the half space x > wall_m, by the loop's
/// reading of this tick, felt until the next.
struct Bench {
  explicit Bench(const MouseHand& hand = {}, const Path& path = path_at_origin(PathKind::kStill))
      : handle(mouse_settings(path, hand.range_m, 1e-3), hand) {}

  void tick() {
    now_ns += kTick_ns;
    if (aim && is_heard) aim->time_ns = now_ns;
    handle.follow(now_ns, kTick_ns, aim);
    force_N = -stiffness_N_per_m * std::max(handle.position_m().x() - wall_m, 0.0);
    handle.exert({force_N, 0.0, 0.0});
    fastest_m_s = std::max(fastest_m_s, handle.velocity_m_s().norm());
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick();
  }
  void point_at(double x_m) { aim = {.time_ns = now_ns, .position_m = {x_m, 0.0, 0.0}}; }

  MouseHandle handle;
  std::optional<MouseAim> aim;
  bool is_heard = true;
  std::uint64_t now_ns = 5'000 * kTick_ns;
  double wall_m = 1.0, stiffness_N_per_m = 0.0, force_N = 0.0, fastest_m_s = 0.0;
};

TEST_CASE("The handle goes to where the mouse points, no faster than its damper lets it",
          "[mouse_handle]") {
  Bench bench;
  bench.run(10);
  CHECK_FALSE(bench.handle.is_held());
  CHECK(bench.handle.position_m().isZero());
  bench.point_at(0.2);
  bench.run(1500);
  CHECK(bench.handle.is_held());
  CHECK(bench.handle.position_m().x() == Approx(0.2).margin(1e-6));
  CHECK(bench.fastest_m_s < 0.5);  // 5 N over 10 N s/m
  CHECK(bench.fastest_m_s > 0.45);
}

TEST_CASE("At a wall the handle rests, with the force that its spring and the wall's agree on",
          "[mouse_handle]") {
  for (const double stiffness_N_per_m : {100.0, 1000.0, 3000.0}) {
    Bench bench;
    bench.wall_m = 0.05;
    bench.stiffness_N_per_m = stiffness_N_per_m;
    bench.point_at(0.058);  // 8 mm beyond: 3.2 N of its 5 N
    bench.run(3000);
    const double share = stiffness_N_per_m / (stiffness_N_per_m + 400.0);
    CHECK(bench.force_N == Approx(-400.0 * 0.008 * share).epsilon(1e-6));
    CHECK(bench.handle.velocity_m_s().norm() < 1e-9);
    bench.point_at(0.0);
    bench.run(1000);
    CHECK(bench.force_N == 0.0);
  }
}

TEST_CASE("However deep the mouse points, the hand pulls with 5 N", "[mouse_handle]") {
  Bench bench;
  bench.wall_m = 0.05;
  bench.stiffness_N_per_m = 3000.0;
  bench.point_at(0.4);
  bench.run(3000);
  CHECK(bench.force_N == Approx(-5.0).epsilon(1e-6));
  CHECK(bench.handle.velocity_m_s().norm() < 1e-9);
}

TEST_CASE("A mouse that falls silent leaves the handle where it is, its buttons up",
          "[mouse_handle]") {
  Bench bench;
  bench.point_at(0.2);
  bench.aim->buttons = 1;
  bench.run(200);  // on its way
  bench.is_heard = false;
  bench.run(499);
  CHECK(bench.handle.is_held());
  CHECK(bench.handle.buttons() == 1);
  bench.point_at(0.3);
  bench.is_heard = true;
  bench.run(100);
  bench.is_heard = false;
  bench.run(500);
  CHECK_FALSE(bench.handle.is_held());
  CHECK(bench.handle.buttons() == 0);
  const double left_m = bench.handle.position_m().x();
  bench.run(2000);
  CHECK(bench.handle.position_m().x() == Approx(left_m).margin(1e-3));
  CHECK(bench.handle.velocity_m_s().norm() < 1e-9);
}

TEST_CASE("What the mouse said in the future, or long ago, is not followed", "[mouse_handle]") {
  Bench bench;
  bench.is_heard = false;
  for (const std::uint64_t time_ns : {UINT64_MAX, bench.now_ns + 1'000'000'000, std::uint64_t{0},
                                      bench.now_ns - kMouseSilence_ns}) {
    bench.aim = {.time_ns = time_ns, .position_m = {0.1, 0.0, 0.0}, .buttons = 1};
    bench.run(100);
    CHECK_FALSE(bench.handle.is_held());
    CHECK(bench.handle.position_m().isZero());
    CHECK(bench.handle.buttons() == 0);
  }
}

TEST_CASE("Until a mouse takes it the handle follows its path, and not after", "[mouse_handle]") {
  Path path = path_at_origin(PathKind::kPress);
  path.depth_m = 0.05;
  path.period_s = 2.0;
  Bench bench({}, path);
  bench.run(1000);
  CHECK(bench.handle.is_held());
  CHECK(bench.handle.position_m().z() < -0.04);
  bench.point_at(0.0);
  bench.run(1000);
  CHECK(bench.handle.position_m().norm() < 1e-3);
  bench.aim.reset();
  bench.run(1000);
  CHECK_FALSE(bench.handle.is_held());
  CHECK(bench.handle.position_m().norm() < 1e-3);
}

TEST_CASE("The handle stays within its range and turns at its rate", "[mouse_handle]") {
  Bench bench({.pull_N = 5.0, .range_m = 0.1, .turn_rad_s = 2.0});
  bench.aim = {.time_ns = 0,
               .position_m = {9.0, -9.0, 0.0},
               .orientation = Eigen::Quaterniond(std::cos(0.5), 0.0, 0.0, std::sin(0.5))};
  bench.run(250);
  const auto turned = bench.handle.orientation().angularDistance(Eigen::Quaterniond::Identity());
  CHECK(turned == Approx(0.5).epsilon(0.01));  // of one radian
  bench.run(2000);
  CHECK(bench.handle.position_m().x() == Approx(0.1));
  CHECK(bench.handle.position_m().y() == Approx(-0.1));
  CHECK(bench.handle.orientation().angularDistance(bench.aim->orientation) < 1e-9);
}

TEST_CASE("A stall of a minute is no leap", "[mouse_handle]") {
  Bench bench;
  bench.point_at(0.2);
  bench.run(10);
  const double before_m = bench.handle.position_m().x();
  bench.now_ns += 60'000 * kTick_ns;
  bench.tick();
  CHECK(bench.handle.position_m().x() - before_m < 0.026);  // 50 ms at 0.5 m/s
}

TEST_CASE("Following a mouse never allocates", "[mouse_handle]") {
  if (!allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  Bench bench;
  bench.point_at(0.2);
  const auto before = allocation_count();
  bench.run(1000);
  const auto after = allocation_count();
  CHECK(after == before);
}

}  // namespace
}  // namespace stillgrid::devices::mouse_handle_test
