#pragma once

#include <vector>

#include "shared/dynamics/implicit_step.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::laboratory {

/// A step of implicit Euler by Broyden's (first, "good") method [Hilde, Meseure, Chaillou 2001]:
/// the first estimate of the Jacobian is the mass matrix. Every iteration corrects the estimate by
/// a matrix of rank one, so that it costs one residual and forms no matrix.
///
/// Full steps and no safeguard, as published: it converges slowly on stiff systems, or not at all
/// (docs/algorithms/broyden.md). It ends at the iterate of least residual. The inverse is kept as a
/// product of rank-one factors in the steps themselves [Kelley 1995, section 7.3]: iteration k
/// costs k dot products and k vectors of memory.
class BroydenStep : public dynamics::ImplicitStep {
 public:
  BroydenStep(const dynamics::Description& description, double tolerance_m_s,
              int most_iterations = 200)
      : ImplicitStep(description, tolerance_m_s), most_iterations_(most_iterations) {}
  void solve(dynamics::SolveFigures& figures, const std::atomic<bool>* stop) override;

 protected:
  /// Called with the residual of each iterate, m/s.
  virtual void look(double /*residual_m_s*/) {}

 private:
  void find_step(std::size_t taken);

  int most_iterations_;
  std::vector<dynamics::Motions> steps_;  // memory is kept from one solve to the next
  std::vector<double> squares_;           // of their norms
  dynamics::Motions best_;
};

/// Implicit Euler solved by Broyden's method.
[[nodiscard]] dynamics::EngineMethod by_broyden(double tolerance_m_s);
/// As a scene names it.
inline constexpr scene::IntegratorKind kBroyden{"broyden", scene::IntegratorFamily::kImplicit,
                                                by_broyden};

}  // namespace stillgrid::laboratory
