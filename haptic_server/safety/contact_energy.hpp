#pragma once

#include <Eigen/Core>

#include "haptic_server/safety/energy_observer.hpp"
#include "haptic_server/safety/wrench.hpp"

namespace stillgrid {

/// Holds what a contact gives back to what it took: no limit makes energy.
///
/// A limit that was strict while the hand pressed in and is not while it leaves gives more than it
/// took: a slew limit at an impact, a fade that ends deeper than it began, a share that grows. So
/// both works are booked from the contact's first tick on, of the told force and of the rendered
/// one as if it had been told, and the told one may still give R = max(0, W + S) - G: G what it has
/// given, W what the rendered one would have, S = F^2 / (2 tr K) what that one still stores. The
/// share of the rendered force is at most R / S. Where no limit acts this is one exactly; where the
/// share is constant so is the bound. It is a two-port's time domain passivity [Hannaford and Ryu
/// 2002, cited by the handbook], with what the stored energy allows beforehand.
///
/// While the hand is at rest what is withheld comes back within a second: a held force is the
/// rendered one in the end. Thread: the haptic loop's. Realtime: yes.
class ContactEnergy {
 public:
  /// Books the motion since the last call of the two below. told: held meanwhile.
  void observe(const Wrench& told, const DeviceMotion& motion) noexcept;

  /// The share of the rendered force that may be told, 0 to 1. stiffness_N_m: of all contacts, zero
  /// where it is not known: one then. is_at_rest: the hand. elapsed_s: since the tick before. Pre:
  /// finite.
  [[nodiscard]] double share(const Wrench& rendered, const Eigen::Matrix3d& stiffness_N_m,
                             bool is_at_rest, double elapsed_s) noexcept;

  /// In place of share(), in a tick whose rendered force is not known: none is told.
  double skip() noexcept {
    rendered_ = {};
    return 0.0;
  }

 private:
  Wrench rendered_;                         // in the tick before
  double rendered_J_ = 0.0, told_J_ = 0.0;  // given since the contact began
};

}  // namespace stillgrid
