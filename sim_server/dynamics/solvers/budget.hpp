#pragma once

#include <atomic>
#include <chrono>
#include <limits>

namespace stillgrid::dynamics {

/// What a step may still cost. Lockstep sets no deadline: only counts decide there.
struct Budget {
  int iterations = std::numeric_limits<int>::max();  // of nonlinear solvers, all substeps together
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();

  const std::atomic<bool>* stop = nullptr;  // set: nobody waits for the step any more

  [[nodiscard]] bool is_stopped() const { return stop != nullptr && *stop; }
  /// Never asks the clock without a deadline.
  [[nodiscard]] bool is_late() const {
    if (is_stopped()) return true;
    return deadline != std::chrono::steady_clock::time_point::max() &&
           std::chrono::steady_clock::now() >= deadline;
  }
  [[nodiscard]] bool spent() const { return iterations <= 0 || is_late(); }
};

}  // namespace stillgrid::dynamics
