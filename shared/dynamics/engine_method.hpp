#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>

namespace stillgrid::dynamics {

class CoupledStep;
struct Description;

/// How an engine advances a tick.
struct EngineMethod {
  /// Makes the method of a scene. Null: position Verlet in small steps, contacts solved implicitly.
  std::unique_ptr<CoupledStep> (*make)(const Description& description,
                                       double tolerance_m_s) = nullptr;
  bool has_end_forces = false;  // its impulses are the forces at the end of a step, times the step
  double tolerance_m_s = 1e-8;  // implicit Euler: rms residual of velocities; by error: error of
                                // velocities in each step, also relative
};

/// Impulse of all contacts and joints on a driven body in a tick, in the frame of the world.
struct DrivenReaction {
  Eigen::Vector3d impulse_N_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_N_m_s = Eigen::Vector3d::Zero();       // about the body's position
  Eigen::Vector3d rigid_impulse_N_s = Eigen::Vector3d::Zero();  // part of them by driven bodies
  Eigen::Vector3d rigid_moment_N_m_s = Eigen::Vector3d::Zero();
  /// Energy of contacts in which the body appeared, less those from which it disappeared.
  double brought_J = 0.0;
  /// Energy of its contacts' springs since its proxies moved. No work of the tool paid for it.
  double aimed_J = 0.0;
};

/// Returns the larger residual. One that is not a number is the worst.
[[nodiscard]] inline double worse_residual_m_s(double a, double b) {
  return std::isnan(a) || a > b ? a : b;
}

/// The most iterations and products of a tick, but for its last part. Small steps take the rest,
/// and the tick has not converged.
inline constexpr long kMaxWork = 20'000;

/// Figures of the equations of a tick.
struct SolveFigures {
  bool converged = true;
  int parts = 0;              // steps that the tick was divided into
  int passes = 0;             // parts in which a body may have passed through another
  int iterations = 0;         // Newton's method; by error: steps
  long products = 0;          // linear systems: products with the equations' derivative
  double residual_m_s = 0.0;  // rms over nodes and rigid bodies, in the worst part

  [[nodiscard]] bool is_spent() const { return iterations + products >= kMaxWork; }
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
