#include "haptic_server/safety/contact_energy.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid {
namespace {

constexpr double kReturn_s = 1.0;
constexpr double kRounding = 1e-9;

}  // namespace

void ContactEnergy::observe(const Wrench& told, const DeviceMotion& motion) noexcept {
  told_J_ += work_J(told, motion);
  rendered_J_ += work_J(rendered_, motion);
  if (!std::isfinite(told_J_) || !std::isfinite(rendered_J_)) told_J_ = rendered_J_ = 0.0;
}

double ContactEnergy::share(const Wrench& rendered, const Eigen::Matrix3d& stiffness_N_m,
                            bool is_at_rest, double elapsed_s) noexcept {
  rendered_ = rendered;
  if (rendered.force_N.isZero(0.0) && rendered.torque_N_m.isZero(0.0)) {
    rendered_J_ = told_J_ = 0.0;
    return 1.0;
  }
  const double trace_N_m = stiffness_N_m.trace();
  if (!(trace_N_m > 0.0)) return 1.0;
  // Exact for contacts along one direction, else too little: the share then falls later, not less.
  const double stored_J = 0.5 * rendered.force_N.squaredNorm() / trace_N_m;
  const auto left_J = [&] { return std::max(0.0, rendered_J_ + stored_J) - told_J_; };
  if (is_at_rest && left_J() < stored_J)
    told_J_ -= std::min(stored_J - left_J(), stored_J * elapsed_s / kReturn_s);
  if (!(left_J() < stored_J * (1.0 - kRounding))) return 1.0;
  return std::max(0.0, left_J()) / stored_J;
}

}  // namespace stillgrid
