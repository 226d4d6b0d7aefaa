#include "shared/tools/laboratory/stable_stiffness.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

namespace stillgrid::laboratory {
namespace {

/// A second of a tool that swings at 7 Hz along x, `late_m` peak to peak in its second half.
std::vector<recording::TickRow> swinging(double early_m, double late_m) {
  std::vector<recording::TickRow> rows(1001);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].time_s = static_cast<double>(i) * 1e-3;
    const double half_m = 0.5 * (i < 500 ? early_m : late_m);
    rows[i].position_m.x() = half_m * std::sin(2.0 * 3.14159265358979 * 7.0 * rows[i].time_s);
  }
  return rows;
}

TEST_CASE("A run oscillates when its last half second swings by more than four encoder steps",
          "[stable_stiffness]") {
  CHECK(oscillates(swinging(0.01, 121e-6)));
  CHECK_FALSE(oscillates(swinging(0.01, 119e-6)));
}

TEST_CASE("A run that ends nowhere is not stable", "[stable_stiffness]") {
  CHECK(oscillates({}));
  std::vector<recording::TickRow> rows = swinging(0.0, 0.0);
  rows[900].position_m.y() = std::numeric_limits<double>::quiet_NaN();
  CHECK(oscillates(rows));
}

TEST_CASE("The search ends at the last stable stiffness before the first loss, however narrow",
          "[stable_stiffness]") {
  // Stable again above, at once or soon.
  const double again_N_per_m = GENERATE(1051.0, 1200.0, 4000.0, 1e9);
  int asked = 0;
  const auto found_N_per_m = largest_stable_stiffness_N_per_m([&](double stiffness_N_per_m) {
    ++asked;
    return stiffness_N_per_m <= 1000.0 || stiffness_N_per_m > again_N_per_m;
  });
  REQUIRE(found_N_per_m);
  CHECK(*found_N_per_m <= 1000.0);
  CHECK(*found_N_per_m == 980.7);  // 50 * 1.05^61, of four digits
  CHECK(asked == 63);  // ln(1000 / 50) / ln(1.05) = 61.4: 62 stable ones and the first that is not
}

TEST_CASE("The search says when all is stable, and when nothing is", "[stable_stiffness]") {
  const StiffnessSearch search{.lowest_N_per_m = 100.0, .highest_N_per_m = 1000.0};
  CHECK_FALSE(largest_stable_stiffness_N_per_m([](double) { return false; }, search));
  const auto all_N_per_m = largest_stable_stiffness_N_per_m([](double) { return true; }, search);
  REQUIRE(all_N_per_m);
  CHECK(*all_N_per_m > 950.0);
  CHECK(*all_N_per_m <= 1000.0);
}

}  // namespace
}  // namespace stillgrid::laboratory
