#pragma once

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

}  // namespace stillgrid::dynamics
