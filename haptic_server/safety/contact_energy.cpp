#include "haptic_server/safety/contact_energy.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stillgrid::safety {
namespace {

constexpr double kReturn_s = 1.0;
constexpr double kRise_s = 0.01;  // not at once: encoder noise at a turn would be felt
constexpr double kRounding = 1e-9;

}  // namespace

void ContactEnergy::observe(const Wrench& commanded, const DeviceMotion& motion,
                            double lever_m) noexcept {
  // The end of the tick before, which was not told yet when it was judged.
  const double rendered_N = norm_N(rendered_, lever_m);
  told_share_ = rendered_N > 0.0 ? norm_N(commanded, lever_m) / rendered_N : 0.0;
  commanded_J_ += has_entered_ ? told_share_ * entry_J_ : 0.5 * work_J(commanded, motion_);
  has_entered_ = false;
  commanded_ = commanded;
  motion_ = motion;
}

/// The first tick of a contact: only part of its motion was within.
double ContactEnergy::enter(double now_J, double stored_J) noexcept {
  is_touching_ = has_entered_ = true;
  entry_J_ = std::clamp(now_J, -stored_J, 0.0);
  rendered_J_ = commanded_J_ = 0.0;
  return entry_J_;
}

double ContactEnergy::share(const Wrench& rendered, const Eigen::Matrix3d& stiffness_N_per_m,
                            bool is_at_rest, double elapsed_s) noexcept {
  const double allowed = share_allowed(rendered, stiffness_N_per_m, is_at_rest, elapsed_s);
  const double now_J = work_J(rendered, motion_);
  if (now_J > 0.0) return allowed;
  return std::clamp(told_share_ + (now_J < 0.0 ? elapsed_s / kRise_s : 0.0), allowed, 1.0);
}

double ContactEnergy::share_allowed(const Wrench& rendered,
                                    const Eigen::Matrix3d& stiffness_N_per_m, bool is_at_rest,
                                    double elapsed_s) noexcept {
  const Wrench before = std::exchange(rendered_, rendered);
  if (rendered.force_N.isZero(0.0) && rendered.torque_N_m.isZero(0.0)) {
    is_touching_ = false;
    return 1.0;
  }
  const double trace_N_per_m = stiffness_N_per_m.trace();
  const bool is_known = trace_N_per_m > 0.0;
  // Exact for contacts along one direction, else too little: the share then falls later, not less.
  const double stored_J = is_known ? 0.5 * rendered.force_N.squaredNorm() / trace_N_per_m : 0.0;
  double now_J = 0.5 * work_J(rendered, motion_);
  if (is_touching_) {
    rendered_J_ += 0.5 * work_J(before, motion_) + now_J;
    commanded_J_ += 0.5 * work_J(commanded_, motion_);
  } else {
    rendered_J_ = now_J = enter(now_J, stored_J);
  }
  if (!std::isfinite(commanded_J_) || !std::isfinite(rendered_J_)) commanded_J_ = rendered_J_ = 0.0;
  if (!is_known) return 1.0;
  // A share s gives s now_J by the end of this tick and s stored_J after it.
  const double wanted_J = stored_J + now_J;
  const auto left_J = [&] { return std::max(0.0, rendered_J_ + stored_J) - commanded_J_; };
  if (is_at_rest && left_J() < wanted_J)
    commanded_J_ -= std::min(wanted_J - left_J(), stored_J * elapsed_s / kReturn_s);
  if (!(left_J() < wanted_J - kRounding * stored_J)) return 1.0;
  return left_J() > 0.0 ? left_J() / wanted_J : 0.0;
}

}  // namespace stillgrid::safety
