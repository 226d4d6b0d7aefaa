#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"

#include <cmath>

namespace stillgrid::dynamics {

double scaled_rms(const NonlinearSystem& system, const Eigen::VectorXd& residual) {
  if (residual.size() == 0) return 0.0;
  return residual.cwiseProduct(system.residual_scale()).norm() /
         std::sqrt(static_cast<double>(residual.size()));
}

}  // namespace stillgrid::dynamics
