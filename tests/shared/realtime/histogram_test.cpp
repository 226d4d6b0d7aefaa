#include "shared/realtime/histogram.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

namespace stillgrid::realtime::histogram_test {
namespace {

TEST_CASE("An empty histogram has nothing to tell", "[histogram]") {
  const Histogram histogram;
  CHECK(histogram.count() == 0);
  CHECK(histogram.max() == 0);
  CHECK(histogram.percentile(0.99) == 0);
  CHECK(histogram.share_above(0) == 0.0);
}

TEST_CASE("Percentiles are within 1/32 above the exact ones and the maximum is exact",
          "[histogram]") {
  const double decades = GENERATE(1.0, 4.0, 9.0, 19.0);  // spread of the values
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> exponent(0.0, decades);
  Histogram histogram;
  std::vector<std::uint64_t> values(5000);
  for (std::uint64_t& value : values) {
    value = static_cast<std::uint64_t>(std::pow(10.0, exponent(random)));
    histogram.record(value);
  }
  std::sort(values.begin(), values.end());

  REQUIRE(histogram.count() == values.size());
  CHECK(histogram.max() == values.back());
  for (const double share : {0.0, 0.001, 0.25, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank =
        static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
    const std::uint64_t exact = values[std::max<std::size_t>(rank, 1) - 1];
    CAPTURE(share);
    CHECK(histogram.percentile(share) >= exact);
    CHECK(histogram.percentile(share) - exact <= exact / 32);
  }
  CHECK(histogram.percentile(1.0) == values.back());
}

TEST_CASE("The share above a value lies between the exact ones of it and of 1/32 more",
          "[histogram]") {
  std::mt19937_64 random(GENERATE(5U, 6U, 7U));
  std::uniform_real_distribution<double> exponent(0.0, 9.0);
  Histogram histogram;
  std::vector<std::uint64_t> values(3000);
  for (std::uint64_t& value : values) {
    value = static_cast<std::uint64_t>(std::pow(10.0, exponent(random)));
    histogram.record(value);
  }
  const auto exact = [&](std::uint64_t limit) {
    return static_cast<double>(std::count_if(values.begin(), values.end(),
                                             [&](std::uint64_t value) { return value > limit; })) /
           static_cast<double>(values.size());
  };
  for (const std::uint64_t limit : {0UL, 7UL, 31UL, 32UL, 1'000UL, 98'765'432UL, 2'000'000'000UL}) {
    CAPTURE(limit);
    CHECK(histogram.share_above(limit) <= exact(limit));
    CHECK(histogram.share_above(limit) >= exact(limit + limit / 32));
  }
}

TEST_CASE("Numbers below 32 are counted exactly", "[histogram]") {
  Histogram histogram;
  for (std::uint64_t value = 0; value < 32; ++value) histogram.record(value);
  for (std::uint64_t value = 0; value < 32; ++value)
    CHECK(histogram.percentile(static_cast<double>(value + 1) / 32.0) == value);
}

TEST_CASE("The whole range of numbers has a bucket", "[histogram]") {
  Histogram histogram;
  for (unsigned bit = 0; bit < 64; ++bit) {
    histogram.record(std::uint64_t{1} << bit);
    histogram.record((std::uint64_t{1} << bit) - 1);
  }
  histogram.record(UINT64_MAX);

  CHECK(histogram.count() == 129);
  CHECK(histogram.max() == UINT64_MAX);
  CHECK(histogram.percentile(1.0) == UINT64_MAX);
}

}  // namespace
}  // namespace stillgrid::realtime::histogram_test
