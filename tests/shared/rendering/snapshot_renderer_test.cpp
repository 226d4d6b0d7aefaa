#include "shared/rendering/snapshot_renderer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering::snapshot_renderer_test {
namespace {

constexpr double kSpeed_m_s = 0.1;
constexpr double kStiffness_N_per_m = 500.0;
constexpr std::uint64_t kPeriod_ns = 33 * kMillisecond_ns;

/// A sphere of 100 mm moves along x into a still probe; overlap is what its centre's place says.
struct SteadyApproach {
  PublishedScene scene{plain_scene(500.0F, 0.1F), {0.1F}, kPeriod_ns};
  SnapshotRenderer renderer;
  std::uint64_t now_ns = 0, next_snapshot_ns = 0;
  // The probe is far inside, so that the contact lasts for the whole experiment.
  ToolPose probe{.position_m = {0.15, 0.0, 0.0}};

  explicit SteadyApproach(display::Transition transition) : renderer(transition) {}

  static double centre_m(std::uint64_t time_ns) {
    return kSpeed_m_s * static_cast<double>(time_ns) * 1e-9;
  }

  /// One tick of 1 ms; snapshots come every period.
  RenderedTick tick() {
    if (now_ns == next_snapshot_ns) {
      scene.show({{centre_m(now_ns), 0.0, 0.0}}, now_ns);
      next_snapshot_ns += kPeriod_ns;
    }
    const RenderedTick result = renderer.render(scene.view(), probe, now_ns);
    now_ns += kMillisecond_ns;
    return result;
  }

  /// Where the rendered force says the sphere is shown.
  [[nodiscard]] double shown_m(const RenderedTick& tick) const {
    return probe.position_m.x() - 0.2 + tick.force.force_N.norm() / kStiffness_N_per_m;
  }
};

TEST_CASE("Held snapshots jump by k v P at each switch, 1.65 N", "[snapshot_renderer]") {
  SteadyApproach approach(display::Transition::kHold);
  double previous_N = 0.0;
  int switches = 0;
  for (int i = 0; i < 330; ++i) {
    const RenderedTick tick = approach.tick();
    const double force_N = tick.force.force_N.norm();
    const bool is_switch = i > 0 && i % 33 == 0;
    if (is_switch) {
      ++switches;
      CHECK(std::abs(force_N - previous_N) == Approx(1.65).epsilon(1e-5));
      REQUIRE(tick.switch_jump_N);
      CHECK(*tick.switch_jump_N == Approx(1.65).epsilon(1e-5));
    } else if (i > 0) {
      CHECK(force_N == previous_N);
    }
    previous_N = force_N;
  }
  CHECK(switches == 9);
}

TEST_CASE("Held snapshots err by v P / sqrt 3 rms, as sampled at 1 kHz", "[snapshot_renderer]") {
  SteadyApproach approach(display::Transition::kHold);
  double squared_m2 = 0.0;
  for (int i = 0; i < 330; ++i) {
    const double error_m = approach.shown_m(approach.tick()) -
                           SteadyApproach::centre_m(approach.now_ns - kMillisecond_ns);
    squared_m2 += error_m * error_m;
  }
  // Sum over the 33 ticks of a period: v dt sqrt((n - 1)(2 n - 1) / 6); 1.9053 mm if continuous.
  CHECK(std::sqrt(squared_m2 / 330) == Approx(1e-4 * std::sqrt(32.0 * 65.0 / 6.0)).epsilon(1e-5));
}

TEST_CASE("The paper's transition lags by exactly v P and never jumps", "[snapshot_renderer]") {
  SteadyApproach approach(display::Transition::kLinear);
  double previous_m = 0.0;
  for (int i = 0; i < 330; ++i) {
    const RenderedTick tick = approach.tick();
    const double shown_m = approach.shown_m(tick);
    if (i > 33) {
      const double true_m = SteadyApproach::centre_m(approach.now_ns - kMillisecond_ns);
      CHECK(true_m - shown_m == Approx(kSpeed_m_s * 0.033).epsilon(1e-5));
      CHECK(shown_m - previous_m == Approx(kSpeed_m_s * 0.001).margin(2e-8));
    }
    if (tick.switch_jump_N && i > 33)  // the motion of a tick
      CHECK(*tick.switch_jump_N == Approx(kStiffness_N_per_m * kSpeed_m_s * 1e-3).epsilon(1e-3));
    previous_m = shown_m;
  }
}

TEST_CASE("With the print's max for min, linear would be hold and jump by v P",
          "[snapshot_renderer]") {
  // a(t) = max((t - Tn) / P, 1) = 1 for all t up to the switch: the weights of hold.
  SteadyApproach hold(display::Transition::kHold), linear(display::Transition::kLinear);
  for (int i = 0; i < 66; ++i) {
    hold.tick();
    linear.tick();
  }
  const double largest_max_N = hold.tick().switch_jump_N.value_or(0.0);
  const double largest_min_N = linear.tick().switch_jump_N.value_or(1.0);
  CHECK(largest_max_N == Approx(1.65).epsilon(1e-5));
  CHECK(largest_min_N == Approx(0.05).epsilon(1e-3));  // the motion of a tick
}

TEST_CASE("Linear cuts the corner of a curved path by a P^2 / 8", "[snapshot_renderer]") {
  PublishedScene scene(plain_scene(500.0F, 0.1F), {0.1F}, kPeriod_ns);
  SnapshotRenderer renderer(display::Transition::kLinear);
  const double acceleration_m_s2 = 2.0;
  const auto centre_m = [&](double t) { return 0.5 * acceleration_m_s2 * t * t; };
  scene.show({{centre_m(0.0), 0, 0}}, 0);
  scene.show({{centre_m(0.034), 0, 0}}, 34 * kMillisecond_ns);
  const ToolPose probe{.position_m = {0.15, 0.0, 0.0}};
  const RenderedTick middle = renderer.render(scene.view(), probe, 51 * kMillisecond_ns);
  const double shown_m = -0.05 + middle.force.force_N.norm() / kStiffness_N_per_m;
  CHECK(shown_m - centre_m(0.017) == Approx(acceleration_m_s2 * 0.034 * 0.034 / 8.0).epsilon(1e-4));
}

TEST_CASE("A row of spheres has the force, the ripple and the holes of its formula",
          "[snapshot_renderer]") {
  // A = 15 mm, depth 2 mm, k = 500 N/m; spacing s, force over a centre and in the middle of a gap.
  struct Row {
    double spacing_m, over_centre_N, in_gap_N;
  };
  const Row row = GENERATE(Row{0.010, 1.00000, 1.00018}, Row{0.0125, 1.0, 0.51879},
                           Row{0.005, 2.00018, 1.73010}, Row{0.01497, 1.0, 0.0});
  std::vector<Eigen::Vector3d> centres_m;
  for (int i = -8; i <= 8; ++i) centres_m.emplace_back(i * row.spacing_m, 0.0, 0.0);
  PublishedScene scene(plain_scene(500.0F, 0.005F), std::vector<float>(centres_m.size(), 0.010F),
                       kPeriod_ns);
  scene.show(centres_m, 0);
  SnapshotRenderer renderer(display::Transition::kHold);
  const auto lift_N = [&](double x_m) {
    return renderer.render(scene.view(), {.position_m = {x_m, 0.0, 0.013}}, 0).force.force_N.z();
  };
  CHECK(lift_N(0.0) == Approx(row.over_centre_N).margin(1e-4));
  CHECK(lift_N(0.5 * row.spacing_m) == Approx(row.in_gap_N).margin(1e-4));
}

TEST_CASE("A damped contact feels the sphere's own velocity, blended like its place",
          "[snapshot_renderer]") {
  publication::StaticScene fixed = plain_scene(0.0F, 0.1F);
  fixed.materials[0].damping_N_s_per_m = 10.0F;
  PublishedScene scene(fixed, {0.1F}, kPeriod_ns);
  scene.show({{0.0, 0.0, 0.0}}, {{0.1, 0.0, 0.0}}, 0);
  scene.show({{0.0, 0.0, 0.0}}, {{0.3, 0.0, 0.0}}, kPeriod_ns);
  SnapshotRenderer renderer(display::Transition::kLinear);
  const ToolPose probe{.position_m = {0.15, 0.0, 0.0}};
  const auto force_N = [&](std::uint64_t now_ns) {
    return renderer.render(scene.view(), probe, now_ns).force.force_N.x();
  };
  CHECK(force_N(33 * kMillisecond_ns) == Approx(1.0).epsilon(1e-5));
  CHECK(force_N(66 * kMillisecond_ns) == Approx(3.0).epsilon(1e-5));
  CHECK(force_N(44 * kMillisecond_ns) == Approx(1.0 + 2.0 / 3.0).epsilon(1e-5));
}

TEST_CASE("Before the first snapshot there is no force", "[snapshot_renderer]") {
  PublishedScene scene(plain_scene(500.0F, 0.1F), {0.1F}, kPeriod_ns);
  SnapshotRenderer renderer(display::Transition::kLinear);
  const RenderedTick tick = renderer.render(scene.view(), {}, 0);
  CHECK(tick.snapshot_id == 0);
  CHECK(tick.force.force_N.norm() == 0.0);
}

TEST_CASE("A new session's first snapshot replaces what an old one left", "[snapshot_renderer]") {
  SnapshotRenderer renderer(display::Transition::kHold);
  PublishedScene first(plain_scene(500.0F, 0.1F), {0.1F}, kPeriod_ns);
  first.show({{0.1, 0.0, 0.0}}, 0);
  CHECK(renderer.render(first.view(), {}, 0).force.contacts == 1);
  PublishedScene second(plain_scene(500.0F, 0.1F), {0.1F}, kPeriod_ns);
  CHECK(renderer.render(second.view(), {}, 0).force.contacts == 0);
}

}  // namespace
}  // namespace stillgrid::rendering::snapshot_renderer_test
