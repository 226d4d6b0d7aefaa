#include "tests/laboratory/rivals/crossfade.hpp"

#include <catch2/catch.hpp>

#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::laboratory::crossfade_test {
namespace {

constexpr double kSpeed_m_s = 0.1, kStiffness_N_per_m = 500.0;

/// A sphere of 100 mm comes towards a still probe; its snapshots come at the given times in ms.
struct Approach {
  rendering::PublishedScene scene{
      rendering::plain_scene(500.0F, 0.1F), {0.1F}, 33 * rendering::kMillisecond_ns};
  CrossfadeRenderer renderer;

  static double force_at_N(std::uint64_t ms) {  // by the snapshot of that time, held
    return kStiffness_N_per_m * (0.05 + kSpeed_m_s * 1e-3 * static_cast<double>(ms));
  }
  void show(std::uint64_t ms) {
    scene.show({{kSpeed_m_s * 1e-3 * static_cast<double>(ms), 0.0, 0.0}},
               ms * rendering::kMillisecond_ns);
  }
  rendering::RenderedTick tick(std::uint64_t ms) {
    return renderer.render(scene.view(), {.position_m = {0.15, 0.0, 0.0}},
                           ms * rendering::kMillisecond_ns);
  }
};

TEST_CASE(
    "Crossfaded forces do not jump at a switch and have passed to the new snapshot in a period",
    "[crossfade]") {
  Approach approach;
  double previous_N = Approach::force_at_N(0);
  for (std::uint64_t ms = 0; ms <= 330; ++ms) {
    if (ms % 33 == 0) approach.show(ms);
    const rendering::RenderedTick tick = approach.tick(ms);
    const double force_N = tick.force.force_N.x();
    // As slow as the force itself grows, from the first switch on.
    if (ms > 33)
      CHECK(force_N - previous_N == Approx(kStiffness_N_per_m * kSpeed_m_s * 1e-3).margin(1e-4));
    if (ms > 0 && ms % 33 == 0) CHECK(tick.switch_jump_N.value_or(1.0) < 0.051);  // a tick's motion
    previous_N = force_N;
  }
  for (std::uint64_t ms = 331; ms < 370; ++ms) {  // no more snapshots
    const rendering::RenderedTick tick = approach.tick(ms);
    if (ms < 363) continue;
    CHECK(tick.weights.alpha == 1.0);
    CHECK(tick.force.force_N.x() == Approx(Approach::force_at_N(330)).margin(1e-4));
  }
}

TEST_CASE("An early snapshot drops what of the fade was left, and jumps by it", "[crossfade]") {
  Approach approach;
  for (const std::uint64_t ms : {0U, 33U, 66U}) {
    approach.show(ms);
    static_cast<void>(approach.tick(ms));
  }
  const double late_N = approach.tick(88).force.force_N.x();  // two thirds of the way
  const double third_N = (Approach::force_at_N(66) - Approach::force_at_N(33)) / 3.0;
  CHECK(late_N == Approx(Approach::force_at_N(66) - third_N).margin(1e-4));
  approach.show(88);
  const rendering::RenderedTick early = approach.tick(88);
  CHECK(early.force.force_N.x() == Approx(Approach::force_at_N(66)).margin(1e-4));
  REQUIRE(early.switch_jump_N);
  CHECK(*early.switch_jump_N == Approx(third_N).margin(1e-4));
}

TEST_CASE("Each snapshot is felt where the tool now is", "[crossfade]") {
  Approach approach;
  approach.show(0);
  approach.show(33);
  const auto force_N = [&](double probe_m) {
    return approach.renderer
        .render(approach.scene.view(), {.position_m = {probe_m, 0.0, 0.0}}, 49'500'000)
        .force.force_N.x();
  };
  CHECK(force_N(0.15) - force_N(0.16) == Approx(kStiffness_N_per_m * 0.01).epsilon(1e-5));
  // Out of reach of the snapshot before, it is the newest one's share alone.
  CHECK(force_N(0.202) == Approx(0.5 * kStiffness_N_per_m * 0.0013).epsilon(1e-3));
}

}  // namespace
}  // namespace stillgrid::laboratory::crossfade_test
