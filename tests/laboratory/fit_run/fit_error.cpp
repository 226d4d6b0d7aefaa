#include "tests/laboratory/fit_run/fit_error.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/realtime/percentile.hpp"
#include "tests/laboratory/metrics.hpp"

namespace stillgrid::fit_run {
namespace {

double rms(double sum, std::size_t count) {
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

bool touches(const recording::TickRow& row) {
  return row.contacts > 0 || row.rendered_N != Eigen::Vector3d::Zero();
}

double just_noticeable_N(const Eigen::Vector3d& force_N) {
  return laboratory::kJustNoticeable * std::max(force_N.norm(), laboratory::kContact_N);
}

FitError fit_error(std::span<const recording::TickRow> rows,
                   std::span<const recording::TickRow> reference, double rate_hz) {
  const std::size_t ticks = std::min(rows.size(), reference.size());
  double error_N2 = 0.0, reference_N2 = 0.0;
  std::vector<double> errors_jnd;
  for (std::size_t i = 0; i < ticks; ++i) {
    if (!touches(rows[i]) && !touches(reference[i])) continue;
    const double error_N = (rows[i].rendered_N - reference[i].rendered_N).norm();
    error_N2 += error_N * error_N;
    reference_N2 += reference[i].rendered_N.squaredNorm();
    errors_jnd.push_back(error_N / just_noticeable_N(reference[i].rendered_N));
  }
  FitError error;
  const std::size_t count = errors_jnd.size();
  if (count == 0) return error;
  error.rms_N = rms(error_N2, count);
  const auto felt =
      std::count_if(errors_jnd.begin(), errors_jnd.end(), [](double jnd) { return jnd > 1.0; });
  error.felt_share = static_cast<double>(felt) / static_cast<double>(count);
  error.jnd_p95 = realtime::percentile(std::move(errors_jnd), 0.95);
  if (!(reference_N2 > 0.0)) return error;
  error.share = *error.rms_N / rms(reference_N2, count);
  const laboratory::ForceError lagged =
      laboratory::force_error(laboratory::rendered_N(rows.first(ticks)),
                              laboratory::rendered_N(reference.first(ticks)), rate_hz);
  error.lag_s = lagged.lag_s;
  error.rms_at_lag_share =
      lagged.rms_N > 0.0 ? *error.share * lagged.rms_at_lag_N / lagged.rms_N : *error.share;
  return error;
}

FitReferenceForce reference_force(std::span<const recording::TickRow> reference) {
  double sum_N2 = 0.0;
  std::size_t touching = 0;
  for (const recording::TickRow& row : reference) {
    if (!touches(row)) continue;
    ++touching;
    sum_N2 += row.rendered_N.squaredNorm();
  }
  if (touching == 0) return {};
  return {rms(sum_N2, touching),
          static_cast<double>(touching) / static_cast<double>(reference.size())};
}

}  // namespace stillgrid::fit_run
