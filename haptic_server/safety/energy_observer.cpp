#include "haptic_server/safety/energy_observer.hpp"

#include <algorithm>

namespace stillgrid::safety {

double work_J(const Wrench& held, const DeviceMotion& motion) noexcept {
  return held.force_N.dot(motion.moved_m) + held.torque_N_m.dot(motion.turned_rad);
}

void observe(HandEnergy& account, const Wrench& held, const DeviceMotion& motion) noexcept {
  account.given_J += work_J(held, motion);
  account.most_given_J = std::max(account.most_given_J, account.given_J);
}

}  // namespace stillgrid::safety
