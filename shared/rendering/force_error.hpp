#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stillgrid::rendering {

/// A change of a force is noticed from this share of it on (docs/cases.md, case 1.15).
inline constexpr double kJustNoticeable = 0.07;
/// A share of a force fainter than this would be noticed by nobody.
inline constexpr double kFaint_N = 0.1;

/// How far a force is from the true one, tick by tick.
class ForceError {
 public:
  /// Counts a tick in which either is in contact.
  void add(const Eigen::Vector3d& force_N, const Eigen::Vector3d& true_N) noexcept {
    error_N2_ += (force_N - true_N).squaredNorm();
    true_N2_ += true_N.squaredNorm();
    ++ticks_;
  }

  [[nodiscard]] std::size_t ticks() const noexcept { return ticks_; }
  /// Rms of the difference over rms of the true force, or over kFaint_N where that is fainter.
  /// Pre: a tick.
  [[nodiscard]] double share() const noexcept {
    const auto ticks = static_cast<double>(ticks_);
    return std::sqrt(error_N2_ / ticks) / std::max(std::sqrt(true_N2_ / ticks), kFaint_N);
  }

 private:
  double error_N2_ = 0.0, true_N2_ = 0.0;
  std::size_t ticks_ = 0;
};

}  // namespace stillgrid::rendering
