#pragma once

#include <Eigen/Core>

#include "haptic_server/safety/energy_observer.hpp"
#include "haptic_server/safety/wrench.hpp"

namespace stillgrid::safety {

/// Holds what a contact gives back to what it took: no limit makes energy.
///
/// A limit that was strict while the hand pressed in and is not while it leaves gives more than it
/// took: a slew limit at an impact, a fade that ends deeper than it began, a share that grows. So
/// both works are booked from the contact's first tick on, of the commanded force and of the
/// rendered one, and the told one may still give R = max(0, W + S) - G: G what it has given, W what
/// the rendered one would have, S = F^2 / (2 tr K) what that one still stores. The share of the
/// rendered force is at most R / S. Where no limit acts this is one exactly; where the share is
/// constant so is the bound. Works are of the mean of the forces at both ends of a tick, as springs
/// do it: what a held force leaks in a tick is not granted to a limited one as well. It is time
/// domain passivity [Hannaford and Ryu 2002; docs/cases.md, case 1.8], told beforehand by the
/// energy stored.
///
/// Only a force that gives is withheld. While the hand presses in, the share grows to one within 10
/// ms: a share that stayed would take less than the rendered force does, and so make anew what is
/// withheld, without end where a body swings with the hand. So withholding takes energy, and each
/// swing out repays. While the hand goes neither in nor out what is withheld comes back within a
/// second: a held force is the rendered one in the end. Thread: the haptic loop's. Realtime: yes.
class ContactEnergy {
 public:
  /// What the device was told in the tick before, and how it has moved since.
  void observe(const Wrench& commanded, const DeviceMotion& motion, double lever_m) noexcept;

  /// The share of the rendered force that may be told, 0 to 1. stiffness_N_per_m: of all contacts,
  /// zero where it is not known: one then. is_at_rest: the hand, along the force. elapsed_s: since
  /// the tick before. Pre: finite; observe() was called in this tick.
  [[nodiscard]] double share(const Wrench& rendered, const Eigen::Matrix3d& stiffness_N_per_m,
                             bool is_at_rest, double elapsed_s) noexcept;

  /// In place of share(), in a tick whose rendered force is not known: none is told.
  double skip() noexcept {
    rendered_ = {};
    return 0.0;
  }

 private:
  double enter(double now_J, double stored_J) noexcept;
  /// Of a force that gives.
  [[nodiscard]] double share_allowed(const Wrench& rendered,
                                     const Eigen::Matrix3d& stiffness_N_per_m, bool is_at_rest,
                                     double elapsed_s) noexcept;

  Wrench commanded_, rendered_;  // in the tick before
  DeviceMotion motion_;          // since then
  bool is_touching_ = false, has_entered_ = false;
  double told_share_ = 0.0;  // of the rendered force, in the tick before
  double entry_J_ = 0.0;     // of the rendered force in the contact's first tick
  double rendered_J_ = 0.0, commanded_J_ = 0.0;  // given since the contact began
};

}  // namespace stillgrid::safety
