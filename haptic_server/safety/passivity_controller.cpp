#include "haptic_server/safety/passivity_controller.hpp"

#include <algorithm>

namespace stillgrid::safety {

Eigen::Vector3d PassivityController::damp(HandEnergy& account, double given_by_scenes_J,
                                          const DeviceMotion& motion, double tick_s,
                                          std::uint32_t& flags) noexcept {
  account.dissipated_by_control_J -= added_N_.dot(motion.moved_m);
  added_N_.setZero();
  const double due_J = account.given_J - given_by_scenes_J;
  const double moved_squared_m2 = motion.moved_m.squaredNorm();
  if (!(due_J > 0.0 && moved_squared_m2 > 0.0)) return added_N_;

  // alpha v = E / (T v^2) v, with v = moved / T.
  const double alpha_N_s_per_m = std::min(due_J * tick_s / moved_squared_m2, mass_kg_ / tick_s);
  added_N_ = -alpha_N_s_per_m / tick_s * motion.moved_m;
  flags |= kFlagPassivity;
  return added_N_;
}

}  // namespace stillgrid::safety
