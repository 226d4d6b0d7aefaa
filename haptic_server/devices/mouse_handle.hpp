#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "haptic_server/devices/phantom_model.hpp"

namespace stillgrid::devices {

/// Pose of the handle that a mouse asks for, in the device frame.
struct MouseAim {
  std::uint64_t time_ns = 0;  // the host's clock
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  std::uint32_t buttons = 0;
};

/// How the hand of a mouse draws the handle.
struct MouseHand {
  double pull_N = 5.0;   // its spring pulls no harder
  double range_m = 0.5;  // the aim stays within this of the origin, per axis
  double turn_rad_s = 3.0;
};

/// A mouse that is silent for so long does not hold the handle any more.
inline constexpr std::uint64_t kMouseSilence_ns = 500'000'000;

/// Returns the model of the handle. Its mass is 0.1 kg. Its hand is a spring of 400 N/m to the aim
/// and a damper of 10 N s/m to the ground. The free handle moves at most at pull_N / (10 N s/m).
/// Its force is limited to 8 N. Its hand follows `path` until a mouse takes it.
[[nodiscard]] PhantomSettings mouse_settings(const Path& path, double range_m, double tick_s);

/// A simulated handle. A spring and a damper pull its mass to the aim of a mouse, and the force of
/// the scene pushes it out. Once its mouse is silent the handle is pulled to its own place, and its
/// buttons are up.
///
/// Thread: one. Realtime: follow() and the const functions never allocate, lock or throw.
class MouseHandle {
 public:
  /// Pre: as make_phantom(); the hand's figures are positive.
  MouseHandle(const PhantomSettings& settings, const MouseHand& hand)
      : model_(make_phantom(settings)), hand_(hand) {}

  /// Advances the handle to now_ns under the force of exert(). newest: the last aim of a mouse, if
  /// there is one. Ignores an aim of the future and one older than kMouseSilence_ns. Skips time
  /// beyond 50 ticks, as after a stall. Pre: newest is finite, its orientation has unit norm.
  void follow(std::uint64_t now_ns, std::uint64_t period_ns,
              const std::optional<MouseAim>& newest) noexcept;

  /// Sets the force on the handle, N. Clamps it to its limit; a force that is not finite is zero.
  void exert(const Eigen::Vector3d& force_N) noexcept { command_force(model_, force_N); }
  void release() noexcept { release_force(model_); }

  /// Whether a mouse holds the handle, or it still follows its path.
  [[nodiscard]] bool is_held() const noexcept;
  [[nodiscard]] std::uint32_t buttons() const noexcept { return buttons_; }
  [[nodiscard]] const Eigen::Vector3d& position_m() const noexcept { return model_.position_m; }
  [[nodiscard]] const Eigen::Vector3d& velocity_m_s() const noexcept { return model_.velocity_m_s; }
  [[nodiscard]] const Eigen::Quaterniond& orientation() const noexcept { return orientation_; }

 private:
  void aim_at(const Eigen::Vector3d& position_m) noexcept;

  PhantomModel model_;
  MouseHand hand_;
  std::optional<MouseAim> aim_;  // the holding mouse's
  Eigen::Quaterniond orientation_ = Eigen::Quaterniond::Identity();
  std::uint32_t buttons_ = 0;
  bool was_taken_ = false, has_started_ = false;
  std::uint64_t start_ns_ = 0;
};

}  // namespace stillgrid::devices
