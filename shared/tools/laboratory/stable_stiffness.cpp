#include "shared/tools/laboratory/stable_stiffness.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace stillgrid::laboratory {
namespace {

/// As a text of four digits reads back.
double four_digits(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", number);
  return std::strtod(text.data(), nullptr);
}

}  // namespace

double swing_m(std::span<const recording::TickRow> rows, double window_s) {
  constexpr double kNowhere_m = std::numeric_limits<double>::infinity();
  if (rows.empty()) return kNowhere_m;
  const double from_s = rows.back().time_s - window_s;
  Eigen::Array3d lowest_m = rows.back().position_m, highest_m = lowest_m;
  for (auto row = rows.rbegin(); row != rows.rend() && row->time_s >= from_s; ++row) {
    lowest_m = lowest_m.min(row->position_m.array());
    highest_m = highest_m.max(row->position_m.array());
    if (!row->position_m.allFinite()) return kNowhere_m;
  }
  return (highest_m - lowest_m).maxCoeff();
}

bool oscillates(std::span<const recording::TickRow> rows, const Oscillation& oscillation) {
  return swing_m(rows, oscillation.window_s) > oscillation.limit_m;
}

std::optional<double> largest_stable_stiffness_N_per_m(
    const std::function<bool(double stiffness_N_per_m)>& is_stable, const StiffnessSearch& search) {
  const int last = static_cast<int>(
      std::floor(std::log(search.highest_N_per_m / search.lowest_N_per_m) / std::log(search.step)));
  const auto stiffness_N_per_m = [&](int i) {
    return four_digits(search.lowest_N_per_m * std::pow(search.step, i));
  };
  int lost = 0;
  while (lost <= last && is_stable(stiffness_N_per_m(lost))) ++lost;
  if (lost == 0) return std::nullopt;
  return stiffness_N_per_m(lost - 1);
}

}  // namespace stillgrid::laboratory
