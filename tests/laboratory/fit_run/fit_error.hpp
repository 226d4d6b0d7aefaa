#pragma once

#include <optional>
#include <span>

#include "tests/laboratory/lab.hpp"

namespace stillgrid::fit_run {

/// A force beside the reference's, tick by tick, over the ticks in which either is in contact.
/// None of a figure: there is no such tick, or the reference has no force.
struct FitError {
  std::optional<double> rms_N;
  std::optional<double> share;                // of the reference's rms there
  std::optional<double> rms_at_lag_share;     // likewise, the reference taken lag_s earlier
  std::optional<double> lag_s;                // at which they differ least, 0 to 100 ms
  std::optional<double> jnd_p95, felt_share;  // tick by tick: see just_noticeable_N()
};

/// Whether a tick is in contact: it has one, or a force.
[[nodiscard]] bool touches(const recording::TickRow& row);

/// What a difference from this force must exceed to be noticed: 7 % of it (docs/cases.md,
/// case 1.15), and of 0.1 N where it is less, for a share of next to nothing would be noticed by
/// nobody.
[[nodiscard]] double just_noticeable_N(const Eigen::Vector3d& force_N);

/// Of the forces as they were rendered. Rows correspond; those that only one has do not count.
[[nodiscard]] FitError fit_error(std::span<const recording::TickRow> rows,
                                 std::span<const recording::TickRow> reference, double rate_hz);

/// What a reference is by itself.
struct FitReferenceForce {
  double rms_N = 0.0;          // over the ticks in contact
  double contact_share = 0.0;  // of the ticks
};
[[nodiscard]] FitReferenceForce reference_force(std::span<const recording::TickRow> reference);

}  // namespace stillgrid::fit_run
