#include "haptic_server/safety/stiffness_governor.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace stillgrid::safety {
namespace {

constexpr double kFall_s = 0.01;
constexpr double kReturn_s = 0.1;

double greatest_N_per_m(const Eigen::Matrix3d& stiffness_N_per_m) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(stiffness_N_per_m, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().z();
}

}  // namespace

double StiffnessGovernor::share(const Eigen::Matrix3d& stiffness_N_per_m, bool is_felt,
                                double elapsed_s) noexcept {
  double wanted = 1.0;
  // The trace is never less than the greatest.
  if (stiffness_N_per_m.allFinite() && stiffness_N_per_m.trace() > limit_N_per_m_) {
    const double greatest = greatest_N_per_m(stiffness_N_per_m);
    if (greatest > limit_N_per_m_) wanted = limit_N_per_m_ / greatest;
  }
  const double lowest = is_felt ? share_ - elapsed_s / kFall_s : 0.0;
  share_ = std::clamp(wanted, lowest, share_ + elapsed_s / kReturn_s);
  return share_;
}

}  // namespace stillgrid::safety
