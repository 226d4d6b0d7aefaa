#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Velocities or impulses: of nodes, then of centres of rigid bodies, then of their rotations.
using Motions = std::vector<Vector4>;

/// Motions that are awake, as runs: first, end. All others are zero.
using AwakeRuns = std::vector<std::pair<std::size_t, std::size_t>>;

template <class Visit>
void each_awake(const AwakeRuns& runs, const Visit& visit) {
  for (const auto& [first, end] : runs)
    for (std::size_t i = first; i < end; ++i) visit(i);
}

[[nodiscard]] inline double dot(const Motions& a, const Motions& b, const AwakeRuns& awake) {
  Vector4 sum;
  each_awake(awake, [&](std::size_t i) {
    sum.x += a[i].x * b[i].x;
    sum.y += a[i].y * b[i].y;
    sum.z += a[i].z * b[i].z;
  });
  return sum.x + sum.y + sum.z;
}

/// Solves A x = b for a symmetric positive definite A that only multiplies.
///
/// Source: Shewchuk, An Introduction to the Conjugate Gradient Method Without the Agonizing Pain,
/// 1994.
class ConjugateGradients {
 public:
  /// Pre: awake outlives this.
  ConjugateGradients(std::size_t count, const AwakeRuns& awake)
      : awake_(awake),
        residual_(count),
        direction_(count),
        product_(count),
        preconditioned_(count) {}

  /// Forgets all motions, where others are awake than before.
  void clear() {
    for (Motions* all : {&direction_, &preconditioned_})
      std::fill(all->begin(), all->end(), Vector4());
  }

  /// Writes x, from zero. multiply(p, out) computes out = A p; precondition(r, out) computes an
  /// approximate solution of A out = r. Stops where sqrt(r . out) is at most `share` of its first
  /// value or at most `smallest`, or after most_products. Returns the products.
  /// Realtime: never allocates, locks or throws, if multiply and precondition do not.
  template <class Multiply, class Precondition>
  int solve(const Motions& b, double share, double smallest, int most_products,
            const Multiply& multiply, const Precondition& precondition, Motions& x) {
    each_awake(awake_, [&](std::size_t i) {
      x[i] = Vector4();
      residual_[i] = b[i];
    });
    precondition(residual_, preconditioned_);
    each_awake(awake_, [&](std::size_t i) { direction_[i] = preconditioned_[i]; });
    double error = dot(residual_, preconditioned_, awake_);
    const double enough = std::max(share * share * error, smallest * smallest);
    int products = 0;
    while (products < most_products && error > enough) {
      multiply(direction_, product_);
      ++products;
      const double curvature = dot(direction_, product_, awake_);
      if (!(curvature > 0.0)) break;  // rounding: x is as good as it gets
      const double length = error / curvature;
      each_awake(awake_, [&](std::size_t i) {
        x[i] = x[i] + length * direction_[i];
        residual_[i] = residual_[i] - length * product_[i];
      });
      precondition(residual_, preconditioned_);
      const double before = error;
      error = dot(residual_, preconditioned_, awake_);
      each_awake(awake_, [&](std::size_t i) {
        direction_[i] = preconditioned_[i] + (error / before) * direction_[i];
      });
    }
    return products;
  }

 private:
  const AwakeRuns& awake_;
  Motions residual_, direction_, product_, preconditioned_;
};

}  // namespace stillgrid::dynamics
