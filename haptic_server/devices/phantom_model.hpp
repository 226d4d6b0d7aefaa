#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "haptic_server/devices/path.hpp"

namespace stillgrid::devices {

/// What a device is. Its motors are taken to compensate gravity.
struct PhantomProfile {
  Eigen::Vector3d workspace_m = Eigen::Vector3d::Zero();  // edge lengths, about the origin
  double resolution_m = 0.0;                              // of the encoders; 0 exact
  double max_force_N = 0.0;                               // norm; 0 no limit
  // Declared, not enforced; 0 unknown.
  double continuous_force_N = 0.0;
  double motor_time_constant_s = 0.0;  // thermal
  double nominal_stiffness_N_per_m = 0.0;
  double max_speed_m_s = 0.0;
  double mass_kg = 0.0;  // apparent, at the tip
  double damping_N_s_per_m = 0.0;
  double friction_N = 0.0;  // Coulomb's, norm
};

/// A hand: a mass held to the device, and a spring and damper that draw it along its path.
struct HandProfile {
  double mass_kg = 0.0;
  double damping_N_s_per_m = 0.0;
  double stiffness_N_per_m = 0.0;
};

/// Two fingers and what closes them; as light as their damper lets them seem.
struct Gripper {
  double open_m = 0.0;  // widest opening; 0 no gripper
  double grip_N = 0.0;  // with which the hand closes it
};
inline constexpr double kMaxGripperForce_N = 8.0;  // of the motor, either way

/// The devices touch, touchx and premium15. Their figures come from secondary sources, and
/// some are assumptions, marked in the implementation: the motors' time constant and the
/// greatest speed are for all three.
[[nodiscard]] std::optional<PhantomProfile> phantom_profile(std::string_view name) noexcept;

/// The hands none, light and measured; the last is one trial of one subject [van Beek et
/// al., Sci Rep 5:18004, 2015].
[[nodiscard]] std::optional<HandProfile> hand_profile(std::string_view name) noexcept;

/// Everything that decides how a simulated device moves, in the device's frame.
struct PhantomSettings {
  PhantomProfile device;
  HandProfile hand;
  Gripper gripper;
  Path path;                                         // of the hand
  Eigen::Vector3d push_N = Eigen::Vector3d::Zero();  // a constant force of the user's
  Eigen::Vector3d start_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d start_velocity_m_s = Eigen::Vector3d::Zero();
  int delay_ticks = 0;   // between a command and its force, <= kMaxDelayTicks
  double noise_m = 0.0;  // the position read is off by up to this, uniformly, per axis
  std::uint64_t seed = 1;
  double tick_s = 1e-3;
};

/// Motion is integrated this many times a tick.
inline constexpr std::uint64_t kSubstepsPerTick = 20;
inline constexpr int kMaxDelayTicks = 127;

/// A device and the hand that holds it, rigidly coupled.
struct PhantomModel {
  PhantomSettings settings;

  // One substep of one axis from (position, velocity), exact for a force held over it.
  Eigen::Matrix2d transition = Eigen::Matrix2d::Identity();
  Eigen::Vector2d force_gain = Eigen::Vector2d::Zero();

  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d held_force_N = Eigen::Vector3d::Zero();  // what the motors exert now
  double gripper_m = 0.0, gripper_force_N = 0.0;           // opening, and the motor's force on it
  std::uint64_t substeps_done = 0;

  std::array<Eigen::Vector3d, kMaxDelayTicks + 1> delayed_N;  // ring, the last delay_ticks + 1
  std::size_t next_delayed = 0;
  std::uint64_t noise_state = 0;
};

/// A model at its start, with no force.
/// Pre: masses sum to more than zero; the rest is not negative; 0 <= delay_ticks <=
/// kMaxDelayTicks; tick_s > 0.
[[nodiscard]] PhantomModel make_phantom(const PhantomSettings& settings);

/// Hands the amplifiers a force, once a tick. It is cut to max_force_N and held from
/// delay_ticks commands later until the next one takes its place. One that is not finite
/// counts as zero.
///
/// Realtime: never allocates, locks or throws.
void command_force(PhantomModel& model, const Eigen::Vector3d& force_N) noexcept;

/// Zero force at once, and none on its way.
///
/// Realtime: as command_force().
void release_force(PhantomModel& model) noexcept;

/// Moves the model on by so many substeps of tick_s / kSubstepsPerTick.
///
/// Without friction and with a still path this agrees with the exact zero-order hold; a
/// moving path is held at the middle of each substep, which costs second order. Friction
/// opposes the velocity at the end of the substep as a vector of constant norm, or as much
/// of it as brings the tip to rest: a tip at rest that friction can hold does not move at
/// all.
/// Realtime: never allocates, locks or throws; some 100 ns a substep.
void advance_phantom(PhantomModel& model, std::uint64_t substeps) noexcept;

/// The position as the encoders show it, with noise. Draws from the noise generator.
///
/// Realtime: as command_force().
[[nodiscard]] Eigen::Vector3d read_encoders(PhantomModel& model) noexcept;

}  // namespace stillgrid::devices
