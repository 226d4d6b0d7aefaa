#include "tests/laboratory/verdict.hpp"

#include <array>
#include <cmath>
#include <limits>

namespace stillgrid::laboratory {
namespace {

/// Far beyond any scene of the laboratory, m.
constexpr double kRoom_m = 1.0;
constexpr double kRounding_s = 1e-9;
/// Of the window before, that a swing which dies away has left at most.
constexpr double kDying = 0.9;

bool is_nowhere(const recording::TickRow& row) {
  return !(row.position_m.cwiseAbs().maxCoeff() < kRoom_m);
}

}  // namespace

std::string_view name_of(Verdict verdict) noexcept {
  constexpr std::array<std::string_view, 4> kNames = {"stable", "swings", "parted", "nowhere"};
  return kNames[static_cast<std::size_t>(verdict)];
}

void VerdictWatch::Window::take(const recording::TickRow& row) {
  if (ticks == 0) lowest_m = highest_m = row.position_m;
  lowest_m = lowest_m.min(row.position_m.array());
  highest_m = highest_m.max(row.position_m.array());
  ++ticks;
  touching += row.contacts > 0 ? 1 : 0;
}

bool VerdictWatch::take(const recording::TickRow& row) {
  is_nowhere_ = is_nowhere_ || is_nowhere(row);
  if (is_nowhere_) return false;
  if (windows_ == 0 && window_.ticks == 0) window_end_s_ = row.time_s + rule_.window_s;
  window_.take(row);
  if (row.time_s < window_end_s_ - kRounding_s) return true;
  window_end_s_ += rule_.window_s;
  swing_before_m_ = windows_ > 0 ? last_.swing_m() : std::numeric_limits<double>::infinity();
  last_ = window_;
  window_ = {};
  ++windows_;
  if (row.time_s < rule_.least_s - kRounding_s) return true;
  return last_.swing_m() > rule_.limit_m && dies_away() && row.time_s < rule_.most_s;
}

bool VerdictWatch::dies_away() const {
  return windows_ > 1 && last_.swing_m() < kDying * swing_before_m_;
}

Verdict VerdictWatch::verdict() const {
  if (is_nowhere_ || (windows_ == 0 && window_.ticks == 0)) return Verdict::kNowhere;
  const Window& judged = windows_ > 0 ? last_ : window_;
  if (judged.swing_m() > rule_.limit_m && !dies_away()) return Verdict::kSwings;
  return rule_.must_touch && !judged.touches() ? Verdict::kParted : Verdict::kStable;
}

Verdict verdict_of(std::span<const recording::TickRow> rows, const VerdictRule& rule) {
  VerdictRule all = rule;
  all.least_s = all.most_s = std::numeric_limits<double>::infinity();
  VerdictWatch watch(all);
  // Whole windows up to the end: what is left over is at the beginning.
  const double whole_s = rows.empty() ? 0.0 : rows.back().time_s - rows.front().time_s;
  const double left_over_s =
      whole_s - rule.window_s * std::floor((whole_s + kRounding_s) / rule.window_s);
  for (const recording::TickRow& row : rows)
    if (row.time_s >= rows.front().time_s + left_over_s - kRounding_s && !watch.take(row)) break;
  return watch.verdict();
}

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

}  // namespace stillgrid::laboratory
