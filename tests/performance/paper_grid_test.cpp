#include "tests/performance/paper_grid.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/sim_server/contact/sphere_clouds.hpp"

namespace stillgrid::performance {
namespace {

using Pairs = std::vector<contact::SpherePair>;

TEST_CASE("The paper's grid finds the pairs that overlap, each once", "[paper_grid]") {
  contact::DriftingCloud spheres(GENERATE(contact::Cloud::kEqual, contact::Cloud::kTwoDecades),
                                 contact::Drift::kFast, 500, 1);
  PaperGrid<std::uint32_t> grid(0.01F, {16, 16, 16});
  Pairs pairs;
  for (int step = 0; step < 5; ++step, spheres.step()) {
    grid.find(spheres.balls(), pairs);
    CHECK(contact::ascending(pairs) == contact::tested_pairs(spheres.balls()));
  }
}

TEST_CASE("Motionless spheres, entered once, are found as if they had been entered at each step",
          "[paper_grid]") {
  contact::DriftingCloud moving(contact::Cloud::kEqual, contact::Drift::kSlow, 200, 2),
      still(contact::Cloud::kEqual, contact::Drift::kNone, 200, 3);
  PaperGrid<std::uint32_t> grid(0.01F, {16, 16, 16});
  grid.enter_static(still.balls());
  std::vector<collision::SweptBound> all(moving.balls().begin(), moving.balls().end());
  all.insert(all.end(), still.balls().begin(), still.balls().end());
  Pairs pairs;
  for (int step = 0; step < 5; ++step, moving.step()) {
    std::copy(moving.balls().begin(), moving.balls().end(), all.begin());
    Pairs expected = contact::tested_pairs(all);
    std::erase_if(expected, [](const contact::SpherePair& pair) { return pair.a >= 200; });
    grid.find(moving.balls(), pairs);
    CHECK(contact::ascending(pairs) == expected);
  }
}

/// Two spheres that overlap, apart for a while, and overlap again, among `others` far away from
/// each other: how often the pair is missed.
template <class Stamp>
int missed(std::uint32_t others, int steps_apart, Stamp first_stamp = 0) {
  std::vector<collision::SweptBound> balls{{{0.0F, 0.0F, 0.0F}, 0.5F}, {{0.6F, 0.0F, 0.0F}, 0.5F}};
  for (std::uint32_t i = 0; i < others; ++i)
    balls.push_back({{4.0F + 4.0F * static_cast<float>(i), 4.0F, 0.0F}, 0.5F});
  PaperGrid<Stamp> grid(1.0F, {1024, 16, 16}, first_stamp);
  Pairs pairs;
  int count = 0;
  for (int step = 0; step <= steps_apart + 1; ++step) {
    const bool together = step == 0 || step == steps_apart + 1;
    balls[1].centre_m[2] = together ? 0.0F : 8.0F;
    grid.find(balls, pairs);
    count += static_cast<int>(together ? 1 : 0) - static_cast<int>(pairs.size());
  }
  return count;
}

TEST_CASE("A stamp of 16 bits wraps and misses a contact, wider ones and ours do not",
          "[paper_grid]") {
  // 256 checks a step: the 256th step after the first gives the same stamp to the same sphere.
  CHECK(missed<std::uint16_t>(254, 255) == 1);
  CHECK(missed<std::uint32_t>(254, 255) == 0);
  CHECK(missed<std::uint64_t>(254, 255) == 0);
  CHECK(missed<std::uint16_t>(254, 254) == 0);
  // Near the maximum the stamp becomes that of a sphere that was never tested.
  CHECK(missed<std::uint16_t>(0, 0, 65534) == 1);
  CHECK(missed<std::uint32_t>(0, 0, 65534) == 0);
  CHECK(missed<std::uint32_t>(0, 0, 4294967294U) == 1);
}

/// What must be counted for N spheres of radius R in the unit cube, which repeats; voxel edge h.
struct Expected {
  double entries, visits, tests;
  Expected(double n, double radius, double h)
      : entries(n * std::pow(1.0 + 2.0 * radius / h, 3)),
        visits(0.5 * n * (n - 1.0) * std::pow(h + 2.0 * radius, 6) / std::pow(h, 3)),
        tests(0.5 * n * (n - 1.0) * std::pow(4.0 * radius + h, 3)) {}
};

TEST_CASE("Entries, visits and tests follow their formulas within 3 %", "[paper_grid]") {
  const std::uint32_t cells = GENERATE(6U, 8U, 12U, 16U, 24U);
  constexpr float kRadius = 1.0F / 24.0F;
  const float h = 1.0F / static_cast<float>(cells);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> place(0.0F, 1.0F);
  PaperGrid<std::uint64_t> grid(h, {cells, cells, cells});
  PaperCounts sum;
  Pairs pairs;
  constexpr int kDraws = 40;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<collision::SweptBound> balls;
    for (int i = 0; i < 400; ++i)
      balls.push_back({{place(random), place(random), place(random)}, kRadius});
    const PaperCounts counts = grid.find(balls, pairs);
    sum.entries += counts.entries;
    sum.visits += counts.visits;
    sum.tests += counts.tests;
  }
  const Expected expected(400, double{kRadius}, double{h});
  CHECK(static_cast<double>(sum.entries) / kDraws == Approx(expected.entries).epsilon(0.03));
  CHECK(static_cast<double>(sum.visits) / kDraws == Approx(expected.visits).epsilon(0.03));
  CHECK(static_cast<double>(sum.tests) / kDraws == Approx(expected.tests).epsilon(0.03));
}

}  // namespace
}  // namespace stillgrid::performance
