#include "tests/laboratory/stable_stiffness.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>
#include <vector>

namespace stillgrid::laboratory::stable_stiffness_test {
namespace {

TEST_CASE("The search ends at the last stable stiffness before the first loss, however narrow",
          "[stable_stiffness]") {
  // Stable again above, at once or soon.
  const double again_N_per_m = GENERATE(1051.0, 1200.0, 4000.0, 1e9);
  int asked = 0;
  const auto found_N_per_m = largest_stable_stiffness_N_per_m(
      [&](double stiffness_N_per_m) {
        ++asked;
        return stiffness_N_per_m <= 1000.0 || stiffness_N_per_m > again_N_per_m;
      },
      {.lowest_N_per_m = 50.0});
  REQUIRE(found_N_per_m);
  CHECK(*found_N_per_m <= 1000.0);
  CHECK(*found_N_per_m == 980.7);  // 50 * 1.05^61, of four digits
  CHECK(asked == 63);  // ln(1000 / 50) / ln(1.05) = 61.4: 62 stable ones and the first that is not
}

TEST_CASE("A search from further up asks points of the same grid", "[stable_stiffness]") {
  std::vector<double> asked_N_per_m;
  const auto is_stable = [&](double stiffness_N_per_m) {
    asked_N_per_m.push_back(stiffness_N_per_m);
    return stiffness_N_per_m <= 1000.0;
  };
  const auto all_N_per_m = largest_stable_stiffness_N_per_m(is_stable);
  const std::vector<double> all_asked_N_per_m = std::exchange(asked_N_per_m, {});
  CHECK(largest_stable_stiffness_N_per_m(is_stable, {.from_N_per_m = 700.0}) == all_N_per_m);
  REQUIRE(asked_N_per_m.size() < all_asked_N_per_m.size());
  CHECK(std::equal(asked_N_per_m.rbegin(), asked_N_per_m.rend(), all_asked_N_per_m.rbegin()));
  CHECK(asked_N_per_m.front() >= 700.0);
  CHECK_FALSE(largest_stable_stiffness_N_per_m(is_stable, {.from_N_per_m = 1100.0}));
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
}  // namespace stillgrid::laboratory::stable_stiffness_test
