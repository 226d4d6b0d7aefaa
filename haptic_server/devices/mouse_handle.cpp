#include "haptic_server/devices/mouse_handle.hpp"

#include <algorithm>

namespace stillgrid::devices {

PhantomSettings mouse_settings(const Path& path, double range_m, double tick_s) {
  PhantomSettings settings;
  settings.device.workspace_m = Eigen::Vector3d::Constant(2.0 * range_m);
  settings.device.max_force_N = 8.0;
  settings.device.nominal_stiffness_N_per_m = 3000.0;
  settings.device.max_speed_m_s = 2.0;
  settings.hand = {.mass_kg = 0.1, .damping_N_s_per_m = 10.0, .stiffness_N_per_m = 400.0};
  settings.path = path;
  settings.start_m = path_at(path, 0.0).position_m;
  settings.tick_s = tick_s;
  return settings;
}

bool MouseHandle::is_held() const noexcept {
  return aim_ || (!was_taken_ && model_.settings.path.kind != PathKind::kStill);
}

/// From now on the spring's other end, as far off as it may pull.
void MouseHandle::aim_at(const Eigen::Vector3d& position_m) noexcept {
  const Eigen::Vector3d bounded_m = position_m.cwiseMax(-hand_.range_m).cwiseMin(hand_.range_m);
  const Eigen::Vector3d away_m = bounded_m - model_.position_m;
  const double most_m = hand_.pull_N / model_.settings.hand.stiffness_N_per_m;
  const double share = std::min(1.0, most_m / std::max(away_m.norm(), most_m));
  model_.settings.path.kind = PathKind::kStill;
  model_.settings.path.centre_m = model_.position_m + share * away_m;
}

void MouseHandle::follow(std::uint64_t now_ns, std::uint64_t period_ns,
                         const std::optional<MouseAim>& newest) noexcept {
  constexpr std::uint64_t kMaxSubsteps = 50 * kSubstepsPerTick;
  if (!has_started_) start_ns_ = now_ns;
  has_started_ = true;
  const std::uint64_t target =
      (now_ns - std::min(now_ns, start_ns_)) * kSubstepsPerTick / period_ns;
  const std::uint64_t due = target - std::min(target, model_.substeps_done);
  if (due > kMaxSubsteps) start_ns_ += (due - kMaxSubsteps) * period_ns / kSubstepsPerTick;
  const std::uint64_t substeps = std::min(due, kMaxSubsteps);

  const bool is_fresh =
      newest && newest->time_ns <= now_ns && now_ns - newest->time_ns < kMouseSilence_ns;
  if (is_fresh) {
    was_taken_ = true;
    aim_ = newest;
    aim_at(aim_->position_m);
    const double step_s = static_cast<double>(substeps) * model_.settings.tick_s /
                          static_cast<double>(kSubstepsPerTick);
    const double apart_rad = orientation_.angularDistance(aim_->orientation);
    const double share = std::min(1.0, hand_.turn_rad_s * step_s / std::max(apart_rad, 1e-9));
    orientation_ = orientation_.slerp(share, aim_->orientation).normalized();
  } else if (aim_) {  // fell silent
    aim_.reset();
    aim_at(model_.position_m);
  }
  buttons_ = aim_ ? aim_->buttons : 0;
  advance_phantom(model_, substeps);
}

}  // namespace stillgrid::devices
