#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>

#include "haptic_server/safety/contact_energy.hpp"
#include "haptic_server/safety/energy_observer.hpp"
#include "haptic_server/safety/force_budget.hpp"
#include "haptic_server/safety/gripper_spring.hpp"
#include "haptic_server/safety/motion_limits.hpp"
#include "haptic_server/safety/passivity_controller.hpp"
#include "haptic_server/safety/safety_flag.hpp"
#include "haptic_server/safety/stiffness_governor.hpp"
#include "haptic_server/safety/wrench.hpp"

namespace stillgrid::safety {

/// The limits of a device. Infinite is no limit; max_force_N always is one.
struct SafetyLimits {
  double max_force_N = 40.0;  // finite, > 0: norm of the force
  double lever_m = 0.1;       // > 0: the torque is limited to that of max_force_N at its end
  double max_slew_N_per_ms = std::numeric_limits<double>::infinity();
  double stiffness_N_per_m = std::numeric_limits<double>::infinity();
  double continuous_force_N = std::numeric_limits<double>::infinity();
  double continuous_torque_N_m = std::numeric_limits<double>::infinity();
  double motor_time_constant_s = 10.0;  // > 0
  double max_speed_m_s = std::numeric_limits<double>::infinity();
  Workspace workspace = {};  // device frame
  double period_s = 1e-3;    // > 0, of the loop: no growth is granted for more in one tick
  // No tick for so long is a stall; longer than the stalls of a shared machine, shorter than a hand
  // takes to react.
  double stall_s = 0.05;
  std::optional<double> passivity_mass_kg = {};  // no control of the energy
  GripperLimits gripper = {};                    // beside the chain
};

/// How fresh the snapshot is that a force was rendered from.
struct SnapshotFreshness {
  bool exists = false;
  double snapshot_age_s = 0.0;  // since its publication
  double period_s = 0.0;        // declared by the simulation
  bool writer_alive = false;
  bool goes_on = false;  // the scene goes on here without it
};

/// A rendered force, and all that decides how much of it a device is told. Scene's axes but where
/// said; lengths of the device's own scale.
struct SafetyInput {
  Wrench rendered = {};
  Eigen::Matrix3d stiffness_N_per_m = Eigen::Matrix3d::Zero();  // of its contacts: sum of k n n^T
  SnapshotFreshness snapshot = {};
  bool device_believed = true;                         // in this tick
  bool device_ready = true;                            // to take a force, as it says
  Eigen::Vector3d device_m = Eigen::Vector3d::Zero();  // device frame
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  DeviceMotion motion = {};        // since the tick before
  double given_by_scenes_J = 0.0;  // to the hand in the run, by what moves (InterfaceAccount)
  double elapsed_s = 1e-3;         // since the tick before
  double since_command_s = 1e-3;   // since the device was told the last force
};

/// All that stands between a rendered force and a hand, in this order: readings that are not
/// believed, forces that are no number, the snapshot's age, the ramp at the start and after any
/// gap, the stiffness governor, the motors' budget, the edge of the workspace, the speed limit, the
/// limit of the norm, what the contact took, control of the energy, the limit of growth and turn.
/// docs/safety.md has the reasons.
///
/// Each stage but the damper of the energy's control shortens the wrench, the speed limit one
/// component of its force; what it shortens by shortens the limit of the norm too: so a force far
/// above the limit fades as smoothly as one below it, and what the energy's control adds fades with
/// them. No stage makes energy: a contact gives the hand no more than it took or the rendered force
/// would have given, but for what comes back within a second where the hand goes neither in nor
/// out (contact_energy.hpp). A stall of 50 ms or more cuts to zero at once, and so does a device
/// that takes no force. Nothing switches the
/// limit of the norm off. Thread: the haptic loop's. Realtime: yes.
class SafetyChain {
 public:
  explicit SafetyChain(const SafetyLimits& limits);

  /// Returns the wrench for the device, and remembers it as held until the next call. Sets the
  /// flags of the stages that changed anything.
  [[nodiscard]] Wrench apply(const SafetyInput& input, std::uint32_t& flags) noexcept;

  /// Zero at once; a ramp follows. For a device that was stopped by somebody else.
  void cut() noexcept;

  /// Whether no force is felt and none may come in this tick: a change of scene cannot be felt.
  [[nodiscard]] bool is_silent() const noexcept;

  /// Of the force really told.
  [[nodiscard]] const HandEnergy& energy() const noexcept { return energy_; }

 private:
  void ramp(const SafetyInput& input, std::uint32_t& flags) noexcept;
  [[nodiscard]] Wrench limited(const SafetyInput& input, double energy_share,
                               std::uint32_t& flags) noexcept;

  SafetyLimits limits_;
  StiffnessGovernor governor_;
  ForceBudget budget_, torque_budget_;
  std::optional<PassivityController> passivity_control_;
  HandEnergy energy_;
  ContactEnergy contact_;
  double freshness_share_ = 1.0;  // falls while no snapshot comes
  double ramp_share_ = 0.0;       // from the start, and from any gap on
  Wrench commanded_;
};

}  // namespace stillgrid::safety
