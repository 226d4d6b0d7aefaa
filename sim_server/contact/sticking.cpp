#include "sim_server/contact/sticking.hpp"

#include <cmath>

namespace stillgrid::contact {

StickingForce sticking_force(const collision::ContactMaterial& material,
                             const Eigen::Vector3d& stretch_m, const Eigen::Vector3d& slid_m,
                             double most_N, double step_s) noexcept {
  const double damper_N_per_m = material.damping_N_s_per_m / step_s;
  const double both_N_per_m = material.stiffness_N_per_m + damper_N_per_m;
  if (!(both_N_per_m > 0.0)) return {};
  const Eigen::Vector3d damped_N = damper_N_per_m * stretch_m;
  const Eigen::Vector3d holding_N = both_N_per_m * (stretch_m + slid_m) - damped_N;
  const double squared_N2 = holding_N.squaredNorm();
  StickingForce result;
  if (squared_N2 > most_N * most_N) result.share = most_N / std::sqrt(squared_N2);
  result.force_N = -result.share * holding_N;
  result.stretch_m = (damped_N - result.force_N) / both_N_per_m;
  return result;
}

}  // namespace stillgrid::contact
