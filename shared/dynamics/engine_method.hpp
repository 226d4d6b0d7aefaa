#pragma once

#include <cmath>

namespace stillgrid::dynamics {

/// How an engine advances a tick.
enum class Method {
  kSmallSteps,     // position Verlet, contacts solved implicitly
  kImplicitEuler,  // the whole scene at once: for stiff springs
};
struct EngineMethod {
  Method kind = Method::kSmallSteps;
  double tolerance_m_s = 1e-8;  // rms residual of velocities in implicit Euler
};

/// Returns the larger residual. One that is not a number is the worst.
[[nodiscard]] inline double worse_residual_m_s(double a, double b) {
  return std::isnan(a) || a > b ? a : b;
}

/// Figures of the implicit equations of a tick.
struct SolveFigures {
  bool converged = true;
  int parts = 0;              // steps that the tick was divided into
  int passes = 0;             // parts in which a body may have passed through another
  int iterations = 0;         // Newton's method
  long products = 0;          // conjugate gradients: products with the equations' derivative
  double residual_m_s = 0.0;  // rms over nodes and rigid bodies, in the worst part

  SolveFigures& operator+=(const SolveFigures& more) {
    converged = converged && more.converged;
    parts += more.parts;
    passes += more.passes;
    iterations += more.iterations;
    products += more.products;
    residual_m_s = worse_residual_m_s(residual_m_s, more.residual_m_s);
    return *this;
  }
};

}  // namespace stillgrid::dynamics
