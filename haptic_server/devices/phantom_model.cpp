#include "haptic_server/devices/phantom_model.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace stillgrid::devices {
namespace {

/// exp(rate * duration) for the motion of one axis under a held force:
///   d/dt (x, v, F) = ((0, 1, 0), (-k/m, -b/m, 1/m), (0, 0, 0)) (x, v, F).
/// A Taylor series of the halved argument, squared back: exact to rounding.
Eigen::Matrix3d held_force_motion(double mass_kg, double damping_N_s_per_m,
                                  double stiffness_N_per_m, double duration_s) {
  Eigen::Matrix3d rate;
  rate << 0.0, 1.0, 0.0,                                                          //
      -stiffness_N_per_m / mass_kg, -damping_N_s_per_m / mass_kg, 1.0 / mass_kg,  //
      0.0, 0.0, 0.0;
  Eigen::Matrix3d argument = rate * duration_s;
  int halvings = 0;
  for (; argument.lpNorm<Eigen::Infinity>() > 0.5 && halvings < 60; ++halvings) argument *= 0.5;

  constexpr int kTerms = 16;  // 0.5^16 / 16! < 1e-18
  Eigen::Matrix3d term = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d sum = term;
  for (int n = 1; n <= kTerms; ++n) {
    term = term * argument / static_cast<double>(n);
    sum += term;
  }
  for (int n = 0; n < halvings; ++n) sum = sum * sum;
  return sum;
}

/// A number from -1 to 1, from the generator SplitMix64 [Steele, Lea and Flood 2014]: the
/// standard library's distributions differ between implementations.
double draw(std::uint64_t& state) noexcept {
  state += 0x9E3779B97F4A7C15ULL;
  std::uint64_t bits = state;
  bits = (bits ^ (bits >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  bits = (bits ^ (bits >> 27U)) * 0x94D049BB133111EBULL;
  bits ^= bits >> 31U;
  return static_cast<double>(bits >> 11U) * 0x1p-52 - 1.0;
}

/// What pushes the device beside the motors, friction and the hand's pull towards the
/// origin, which the transition holds already.
Eigen::Vector3d outer_force(const PhantomModel& model, double time_s) noexcept {
  const HandProfile& hand = model.settings.hand;
  if (hand.stiffness_N_per_m == 0.0 && hand.damping_N_s_per_m == 0.0) return model.settings.push_N;
  const MotionPoint aim = path_at(model.settings.path, time_s);
  return model.settings.push_N + hand.stiffness_N_per_m * aim.position_m +
         hand.damping_N_s_per_m * aim.velocity_m_s;
}

void advance_substep(PhantomModel& model, double substep_s) noexcept {
  const double middle_s = (static_cast<double>(model.substeps_done) + 0.5) * substep_s;
  ++model.substeps_done;
  Eigen::Vector3d force_N = model.held_force_N + outer_force(model, middle_s);
  const double friction_N = model.settings.device.friction_N;

  const bool is_at_rest = model.velocity_m_s.isZero(0.0);
  const double pull_N = (force_N - model.settings.hand.stiffness_N_per_m * model.position_m).norm();
  if (friction_N > 0.0 && is_at_rest && pull_N <= friction_N) return;

  const Eigen::Vector3d start_m = model.position_m;
  const Eigen::Vector3d start_m_s = model.velocity_m_s;
  Eigen::Vector3d end_m_s = model.transition(1, 0) * start_m + model.transition(1, 1) * start_m_s +
                            model.force_gain[1] * force_N;
  if (friction_N > 0.0) {
    const double free_m_s = end_m_s.norm();
    const double lost_m_s = model.force_gain[1] * friction_N;
    if (free_m_s <= lost_m_s) {
      force_N -= end_m_s / model.force_gain[1];
      end_m_s.setZero();
    } else {
      force_N -= friction_N * end_m_s / free_m_s;
      end_m_s *= 1.0 - lost_m_s / free_m_s;
    }
  }
  model.velocity_m_s = end_m_s;
  model.position_m = model.transition(0, 0) * start_m + model.transition(0, 1) * start_m_s +
                     model.force_gain[0] * force_N;
}

}  // namespace

std::optional<PhantomProfile> phantom_profile(std::string_view name) noexcept {
  // Workspace (x width, z height, y depth), resolution, forces, and what is not marked
  // below are secondary-source figures; a stiffness is the least of the maker's three axes,
  // as a contact's direction is not known beforehand. Assumptions, for want of a source: of
  // all three the viscous damping, the motors' time constant and the greatest speed, which a
  // hand at work stays well below; of touchx and premium15 the mass and the friction.
  constexpr double kAssumedDamping_N_s_per_m = 0.005;
  constexpr double kAssumedMotorTimeConstant_s = 10.0;
  constexpr double kAssumedMaxSpeed_m_s = 2.0;
  PhantomProfile touch;
  touch.workspace_m = {0.160, 0.070, 0.120};
  touch.resolution_m = 0.055e-3;
  touch.max_force_N = 3.3;
  touch.continuous_force_N = 0.88;
  touch.motor_time_constant_s = kAssumedMotorTimeConstant_s;
  touch.nominal_stiffness_N_per_m = 1020.0;
  touch.max_speed_m_s = kAssumedMaxSpeed_m_s;
  touch.mass_kg = 0.045;
  touch.damping_N_s_per_m = kAssumedDamping_N_s_per_m;
  touch.friction_N = 0.26;
  if (name == "touch") return touch;

  PhantomProfile touchx = touch;
  touchx.workspace_m = {0.160, 0.120, 0.120};
  touchx.resolution_m = 0.023e-3;
  touchx.max_force_N = 7.9;
  touchx.continuous_force_N = 1.75;
  touchx.nominal_stiffness_N_per_m = 1480.0;
  touchx.friction_N = 0.06;  // assumed, as is the mass taken over from touch
  if (name == "touchx") return touchx;

  PhantomProfile premium15 = touch;
  premium15.workspace_m = {0.381, 0.191, 0.267};
  premium15.resolution_m = 0.03e-3;
  premium15.max_force_N = 8.5;
  premium15.continuous_force_N = 1.4;
  premium15.nominal_stiffness_N_per_m = 3500.0;
  premium15.mass_kg = 0.075;    // assumed
  premium15.friction_N = 0.04;  // assumed
  if (name == "premium15") return premium15;
  return std::nullopt;
}

std::optional<HandProfile> hand_profile(std::string_view name) noexcept {
  if (name == "none") return HandProfile{};
  if (name == "light") return HandProfile{0.1, 2.0, 300.0};
  if (name == "measured") return HandProfile{0.554, 6.45, 135.0};
  return std::nullopt;
}

PhantomModel make_phantom(const PhantomSettings& settings) {
  const double mass_kg = settings.device.mass_kg + settings.hand.mass_kg;
  assert(mass_kg > 0.0 && settings.tick_s > 0.0);
  assert(settings.delay_ticks >= 0 && settings.delay_ticks <= kMaxDelayTicks);
  PhantomModel model;
  model.settings = settings;
  const Eigen::Matrix3d motion = held_force_motion(
      mass_kg, settings.device.damping_N_s_per_m + settings.hand.damping_N_s_per_m,
      settings.hand.stiffness_N_per_m, settings.tick_s / static_cast<double>(kSubstepsPerTick));
  model.transition = motion.topLeftCorner<2, 2>();
  model.force_gain = motion.topRightCorner<2, 1>();
  model.position_m = settings.start_m;
  model.gripper_m = settings.gripper.open_m;
  model.velocity_m_s = settings.start_velocity_m_s;
  model.delayed_N.fill(Eigen::Vector3d::Zero());
  model.noise_state = settings.seed;
  return model;
}

void command_force(PhantomModel& model, const Eigen::Vector3d& force_N) noexcept {
  Eigen::Vector3d cut_N = force_N.allFinite() ? force_N : Eigen::Vector3d(Eigen::Vector3d::Zero());
  const double limit_N = model.settings.device.max_force_N;
  const double norm_N = cut_N.stableNorm();  // the plain norm of a huge force overflows
  if (limit_N > 0.0 && norm_N > limit_N) cut_N *= limit_N / norm_N;

  const std::size_t length = static_cast<std::size_t>(model.settings.delay_ticks) + 1;
  model.delayed_N[model.next_delayed] = cut_N;
  model.next_delayed = (model.next_delayed + 1) % length;
  model.held_force_N = model.delayed_N[model.next_delayed];
}

void release_force(PhantomModel& model) noexcept {
  model.delayed_N.fill(Eigen::Vector3d::Zero());
  model.held_force_N.setZero();
}

void advance_phantom(PhantomModel& model, std::uint64_t substeps) noexcept {
  const double substep_s = model.settings.tick_s / static_cast<double>(kSubstepsPerTick);
  for (std::uint64_t n = 0; n < substeps; ++n) advance_substep(model, substep_s);
  constexpr double kFingers_N_s_per_m = 20.0;
  const Gripper& gripper = model.settings.gripper;
  const double opened_m = (model.gripper_force_N - gripper.grip_N) / kFingers_N_s_per_m *
                          static_cast<double>(substeps) * substep_s;
  model.gripper_m = std::clamp(model.gripper_m + opened_m, 0.0, gripper.open_m);
}

Eigen::Vector3d read_encoders(PhantomModel& model) noexcept {
  Eigen::Vector3d read_m = model.position_m;
  if (model.settings.noise_m > 0.0) {
    for (double& coordinate_m : read_m)
      coordinate_m += model.settings.noise_m * draw(model.noise_state);
  }
  const double step_m = model.settings.device.resolution_m;
  if (step_m > 0.0) read_m = step_m * (read_m / step_m).array().round().matrix();
  return read_m;
}

}  // namespace stillgrid::devices
