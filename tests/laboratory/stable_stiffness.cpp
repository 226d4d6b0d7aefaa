#include "tests/laboratory/stable_stiffness.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace stillgrid::laboratory {
namespace {

/// As a text of four digits reads back.
double four_digits(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", number);
  return std::strtod(text.data(), nullptr);
}

}  // namespace

std::optional<double> largest_stable_stiffness_N_per_m(
    const std::function<bool(double stiffness_N_per_m)>& is_stable, const StiffnessSearch& search) {
  const int last = static_cast<int>(
      std::floor(std::log(search.highest_N_per_m / search.lowest_N_per_m) / std::log(search.step)));
  const auto stiffness_N_per_m = [&](int i) {
    return four_digits(search.lowest_N_per_m * std::pow(search.step, i));
  };
  int first = 0;
  while (first < last && stiffness_N_per_m(first) < search.from_N_per_m) ++first;
  int lost = first;
  while (lost <= last && is_stable(stiffness_N_per_m(lost))) ++lost;
  if (lost == first) return std::nullopt;
  return stiffness_N_per_m(lost - 1);
}

}  // namespace stillgrid::laboratory
