#include "tests/laboratory/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "tests/laboratory/spectrum.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr double kLongestLag_s = 0.1;
constexpr double kVibrationLow_hz = 20.0, kVibrationHigh_hz = 500.0;
constexpr double kStageWindow_s = 0.01;

/// Of forces from `first` on, the reference being `lag` ticks older.
double rms_N(std::span<const Eigen::Vector3d> forces_N,
             std::span<const Eigen::Vector3d> reference_N, std::size_t first, std::size_t lag) {
  double sum_N2 = 0.0;
  for (std::size_t i = first; i < forces_N.size(); ++i)
    sum_N2 += (forces_N[i] - reference_N[i - lag]).squaredNorm();
  return std::sqrt(sum_N2 / static_cast<double>(forces_N.size() - first));
}

}  // namespace

Extremes extremes_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(values.size())));
  return {values[rank - 1], values.back()};
}

Extremes slew_N_per_ms(std::span<const Eigen::Vector3d> forces_N, double rate_hz) {
  std::vector<double> slews;
  for (std::size_t i = 1; i < forces_N.size(); ++i)
    slews.push_back((forces_N[i] - forces_N[i - 1]).norm() * rate_hz * 1e-3);
  return extremes_of(std::move(slews));
}

ForceError force_error(std::span<const Eigen::Vector3d> forces_N,
                       std::span<const Eigen::Vector3d> reference_N, double rate_hz) {
  const auto longest = static_cast<std::size_t>(std::lround(kLongestLag_s * rate_hz));
  if (forces_N.size() <= longest) return {};
  ForceError error{.rms_N = rms_N(forces_N, reference_N, longest, 0),
                   .lag_s = 0.0,
                   .rms_at_lag_N = std::numeric_limits<double>::infinity()};
  for (std::size_t i = longest; i < forces_N.size(); ++i)
    error.max_N = std::max(error.max_N, (forces_N[i] - reference_N[i]).norm());
  for (std::size_t lag = 0; lag <= longest; ++lag) {
    const double lagged_N = rms_N(forces_N, reference_N, longest, lag);
    if (lagged_N >= error.rms_at_lag_N) continue;
    error.rms_at_lag_N = lagged_N;
    error.lag_s = static_cast<double>(lag) / rate_hz;
  }
  return error;
}

Vibration vibration(std::span<const Eigen::Vector3d> error_N, double rate_hz,
                    double simulation_rate_hz) {
  Vibration sum;
  std::vector<double> axis_N(error_N.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::transform(error_N.begin(), error_N.end(), axis_N.begin(),
                   [axis](const Eigen::Vector3d& error) { return error[axis]; });
    const Spectrum spectrum = welch(axis_N, rate_hz);
    sum.power_N2 += band_power(spectrum, kVibrationLow_hz, kVibrationHigh_hz);
    for (std::size_t i = 0; i < spectrum.density_per_hz.size(); ++i) {
      const double frequency_hz = static_cast<double>(i) * spectrum.bin_hz;
      const double harmonic_hz =
          std::max(1.0, std::round(frequency_hz / simulation_rate_hz)) * simulation_rate_hz;
      if (frequency_hz >= kVibrationLow_hz && frequency_hz <= kVibrationHigh_hz &&
          std::abs(frequency_hz - harmonic_hz) <= 2.0 * spectrum.bin_hz)
        sum.at_harmonics_N2 += spectrum.density_per_hz[i] * spectrum.bin_hz;
    }
  }
  return sum;
}

Plateau plateau(std::span<const recording::TickRow> rows, double rate_hz) {
  Plateau result;
  std::size_t shown = 0, standing = 0, run = 0, longest = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].snapshot_id == 0) continue;
    ++shown;
    if (i > 0 && rows[i - 1].snapshot_id != 0 && rows[i].snapshot_id != rows[i - 1].snapshot_id)
      result.left_over = std::max(result.left_over, 1.0 - rows[i - 1].alpha);
    const bool is_waiting = rows[i].alpha >= 1.0;
    run = is_waiting ? run + 1 : 0;
    if (is_waiting) ++standing;
    longest = std::max(longest, run);
  }
  result.share = shown > 0 ? static_cast<double>(standing) / static_cast<double>(shown) : 0.0;
  result.longest_s = static_cast<double>(longest) / rate_hz;
  return result;
}

std::vector<Eigen::Vector3d> rendered_N(std::span<const recording::TickRow> rows) {
  std::vector<Eigen::Vector3d> forces_N;
  forces_N.reserve(rows.size());
  for (const recording::TickRow& row : rows) forces_N.push_back(row.rendered_N);
  return forces_N;
}

Stages stages(std::span<const Eigen::Vector3d> forces_N, double rate_hz) {
  const auto window = static_cast<std::size_t>(std::lround(kStageWindow_s * rate_hz));
  std::vector<double> uneven_jnd;
  for (std::size_t i = 0; i + 3 * window < forces_N.size(); ++i) {
    const auto force_N = [&](std::size_t windows) { return forces_N[i + windows * window]; };
    const auto [least_N, most_N] =
        std::minmax({force_N(0).norm(), force_N(1).norm(), force_N(2).norm(), force_N(3).norm()});
    if (least_N < kContact_N) continue;
    const Eigen::Vector3d around_N = force_N(1) - force_N(0) + force_N(3) - force_N(2);
    const double uneven_N = (force_N(2) - force_N(1) - 0.5 * around_N).norm();
    uneven_jnd.push_back(uneven_N / (kJustNoticeable * most_N));
  }
  const auto felt =
      std::count_if(uneven_jnd.begin(), uneven_jnd.end(), [](double jnd) { return jnd > 1.0; });
  const double count = static_cast<double>(std::max<std::size_t>(uneven_jnd.size(), 1));
  return {extremes_of(std::move(uneven_jnd)), static_cast<double>(felt) / count};
}

SwitchMetrics switch_metrics(const LabRun& run) {
  std::vector<double> jumps_N, jumps_jnd;
  for (const SwitchJump& jump : run.jumps) {
    jumps_N.push_back(jump.jump_N);
    // Where nothing was touched before, the whole force that comes is the jump.
    const double after_N = run.rows[jump.tick].rendered_N.norm();
    const double before_N = jump.tick > 0 ? run.rows[jump.tick - 1].rendered_N.norm() : 0.0;
    const double there_N = std::max({after_N, before_N, jump.jump_N});
    jumps_jnd.push_back(there_N > 0.0 ? jump.jump_N / (kJustNoticeable * there_N) : 0.0);
  }
  return {run.jumps.size(), extremes_of(std::move(jumps_N)), extremes_of(std::move(jumps_jnd))};
}

RunMetrics metrics_of(const LabRun& run, const LabRun& reference, double simulation_rate_hz) {
  const double rate_hz = run.report.rate_hz;
  std::vector<Eigen::Vector3d> forces_N = rendered_N(run.rows);
  std::vector<Eigen::Vector3d> reference_N = rendered_N(reference.rows);
  forces_N.resize(std::min(forces_N.size(), reference_N.size()));
  reference_N.resize(forces_N.size());
  std::vector<Eigen::Vector3d> error_N(forces_N.size());
  std::transform(forces_N.begin(), forces_N.end(), reference_N.begin(), error_N.begin(),
                 std::minus<>());
  return {.switches = switch_metrics(run),
          .slew_N_per_ms = slew_N_per_ms(forces_N, rate_hz),
          .error = force_error(forces_N, reference_N, rate_hz),
          .plateau = plateau(run.rows, rate_hz),
          .vibration = vibration(error_N, rate_hz, simulation_rate_hz),
          .energy_given_J = run.report.energy.given_J};
}

}  // namespace stillgrid::laboratory
