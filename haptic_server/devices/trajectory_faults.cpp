#include "haptic_server/devices/trajectory_faults.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <vector>

namespace stillgrid::devices {
namespace {

constexpr double kGap_s = 0.1, kGapOfMedian = 20.0;
constexpr double kJump_m = 1e-3, kJump_m_s = 5.0;
constexpr std::size_t kFewRows = 10;

double median_step_s(const std::vector<double>& time_s) {
  std::vector<double> steps_s(time_s.size() - 1);
  for (std::size_t i = 0; i < steps_s.size(); ++i) steps_s[i] = time_s[i + 1] - time_s[i];
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  return *middle;
}

std::string place(const std::string& file, std::size_t line, const char* kind, double value,
                  const char* unit, double from_s) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), ":%zu: %s of %.4g %s from %.4f s on", line, kind, value,
                unit, from_s);
  return file + text.data();
}

std::string count_of(std::size_t count, const std::string& kind) {
  return std::to_string(count) + " " + kind + (count == 1 ? "" : "s");
}

}  // namespace

std::string faults_of(const std::string& file, const tables::Trajectory& trajectory) {
  const std::vector<double>& time_s = trajectory.time_s;
  const std::vector<Eigen::Vector3d>& position_m = trajectory.position_m;
  if (time_s.size() < kFewRows) return {};
  const double gap_s = std::max(kGap_s, kGapOfMedian * median_step_s(time_s));
  std::string first;
  std::size_t gaps = 0, jumps = 0, changed = 0;  // changed: the row at which the position last did
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double step_s = time_s[i] - time_s[i - 1];
    const double way_m = (position_m[i] - position_m[i - 1]).norm();
    const double since_s = time_s[i] - time_s[changed];
    if (way_m > 0.0) changed = i;
    const bool is_gap = step_s > gap_s;
    const bool is_jump = way_m > kJump_m && way_m > kJump_m_s * since_s;
    gaps += is_gap ? 1U : 0U;
    jumps += is_jump ? 1U : 0U;
    if (!first.empty() || !(is_gap || is_jump)) continue;
    first = is_gap ? place(file, trajectory.line[i], "gap", step_s, "s", time_s[i - 1])
                   : place(file, trajectory.line[i], "jump", 1e3 * way_m, "mm", time_s[i - 1]);
  }
  if (first.empty()) return {};
  return first + "; in all " + count_of(gaps, "gap") + " and " + count_of(jumps, "jump") +
         ", replayed as they are: stillgrid_import looks closer";
}

}  // namespace stillgrid::devices
