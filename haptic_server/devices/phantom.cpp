#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "haptic_server/devices/mailbox.hpp"
#include "haptic_server/devices/phantom_instrument.hpp"
#include "haptic_server/devices/phantom_model.hpp"
#include "haptic_server/devices/phantom_options.hpp"
#include "haptic_server/devices/phantom_servo.hpp"
#include "haptic_server/devices/plugin_support.hpp"

namespace stillgrid::devices {
namespace {

std::uint64_t steady_ns() noexcept {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}

/// The simulated device behind the plugin interface. Its time is the host's, from the first
/// read or write after activate().
class PhantomDriver {
 public:
  static constexpr const char* kName = "phantom";

  explicit PhantomDriver(const HostLoop& loop) : loop_(loop), options_(loop.period_ns) {}

  void configure(std::string_view key, std::string_view value) { options_.set(key, value); }

  void describe(stillgrid_device_descriptor& descriptor) const {
    const PhantomSettings set = options_.settings();
    const PhantomProfile& device = set.device;
    // Of a stylus without motors for torque, which is ignored. With a pivot the trocar bears half
    // of what the handle's force makes on the longest instrument that the workspace holds.
    descriptor.max_torque_N_m = 0.1 * device.max_force_N;
    if (const auto at_m = options_.pivot()) {
      const double longest_m = (set.start_m - *at_m).norm() + 0.5 * device.workspace_m.norm();
      descriptor.max_torque_N_m = 2.0 * device.max_force_N * longest_m;
    }
    descriptor.position_resolution_m = device.resolution_m;
    descriptor.max_force_N = device.max_force_N;
    descriptor.flags = STILLGRID_DEVICE_NO_MOTORS |
                       (options_.pace() == Pace::kDevice ? STILLGRID_DEVICE_SETS_PACE : 0U);
    descriptor.max_read_ns = 200'000;
    descriptor.button_count = kButtons;
    descriptor.dof_sensed = kTranslation | (options_.pivot() ? kRotation : 0U);
    descriptor.dof_actuated = descriptor.dof_sensed;  // the pivot's torque is of the handle's force
    if (set.gripper.open_m > 0.0) {
      descriptor.dof_sensed |= STILLGRID_DOF_GRIPPER;
      descriptor.dof_actuated |= STILLGRID_DOF_GRIPPER;
      descriptor.gripper_open_m = set.gripper.open_m;
      descriptor.max_gripper_force_N = kMaxGripperForce_N;
    }
    if (!options_.declares_limits()) return;
    Eigen::Map<Eigen::Vector3d>(descriptor.workspace_min_m) = -0.5 * device.workspace_m;
    Eigen::Map<Eigen::Vector3d>(descriptor.workspace_max_m) = 0.5 * device.workspace_m;
    descriptor.continuous_force_N = device.continuous_force_N;
    descriptor.nominal_stiffness_N_per_m = device.nominal_stiffness_N_per_m;
    descriptor.motor_time_constant_s = device.motor_time_constant_s;
    descriptor.max_speed_m_s = device.max_speed_m_s;
  }

  static void identify(stillgrid_device_identity& identity) noexcept {
    std::strncpy(identity.serial, "simulated", sizeof identity.serial - 1);
    std::strncpy(identity.driver, "stillgrid phantom " STILLGRID_VERSION,
                 sizeof identity.driver - 1);
  }

  void set_tick(HostTick tick) noexcept { tick_ = tick; }

  void activate() {
    PhantomSettings settings = options_.settings();
    const bool is_virtual = loop_.clock == STILLGRID_CLOCK_VIRTUAL;
    if (options_.pace() == Pace::kLate && is_virtual)
      settings.delay_ticks = std::min(settings.delay_ticks + 1, kMaxDelayTicks);
    model_ = make_phantom(settings);
    pivot_ = options_.pivot();
    if (pivot_) instrument_ = place_instrument({}, model_.position_m, *pivot_);
    for (std::size_t axis = 0; axis < 3; ++axis)
      push_N_[axis] = settings.push_N[static_cast<Eigen::Index>(axis)];
    grip_N_ = settings.gripper.grip_N;
    has_started_ = false;
    sequence_ = 0;
    if (!is_virtual) begin_servo();
  }

  std::int32_t read(std::uint64_t now_ns, bool is_stopped, stillgrid_device_state& state) noexcept {
    if (is_late_)
      state = sampled_.take();
    else
      sample(now_ns, is_stopped, state);
    return STILLGRID_DEVICE_OK;
  }

  std::int32_t write(std::uint64_t now_ns, bool is_stopped, const double* force_N,
                     const double* torque_N_m) noexcept {
    Wrench wrench;
    std::copy_n(force_N, 3, wrench.force_N.begin());
    if (torque_N_m != nullptr) std::copy_n(torque_N_m, 3, wrench.torque_N_m.begin());
    if (is_late_) {
      commanded_.put(wrench);
    } else {
      catch_up(now_ns, is_stopped);
      if (!is_stopped) exert(wrench);
    }
    const auto is_finite = [](const std::array<double, 3>& v) {
      return std::all_of(v.begin(), v.end(), [](double number) { return std::isfinite(number); });
    };
    const bool is_number = is_finite(wrench.force_N) && (!pivot_ || is_finite(wrench.torque_N_m));
    return is_number ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ARGUMENT;
  }

  std::int32_t write_gripper(std::uint64_t /*now_ns*/, bool is_stopped, double force_N) noexcept {
    if (!std::isfinite(force_N)) return STILLGRID_DEVICE_E_ARGUMENT;
    gripper_force_N_ =
        is_stopped ? 0.0 : std::clamp(force_N, -kMaxGripperForce_N, kMaxGripperForce_N);
    return STILLGRID_DEVICE_OK;
  }

  /// What the hand does, from now on.
  void command(std::string_view key, std::string_view value) {
    constexpr std::array<std::string_view, 3> kPush = {"push_x_N", "push_y_N", "push_z_N"};
    constexpr double kStrongest_N = 50.0;  // of a hand
    if (key == "buttons") {
      const double down = number_option(key, value, Bounds::kNotNegative);
      if (down != std::floor(down) || down >= std::exp2(kButtons))
        refuse_option(key, value, "0 to 3: a bit for each button that is down");
      buttons_ = static_cast<std::uint32_t>(down);
      return;
    }
    const auto axis = std::find(kPush.begin(), kPush.end(), key);
    if (axis == kPush.end() && key != "grip_N")
      refuse_option(key, value, "a known key: push_x_N, push_y_N, push_z_N, grip_N, buttons");
    const double force_N = number_option(key, value, Bounds::kFinite);
    if (!(std::abs(force_N) <= kStrongest_N) || (key == "grip_N" && force_N < 0.0))
      refuse_option(key, value, key == "grip_N" ? "0 to 50" : "-50 to 50");
    if (axis != kPush.end())
      push_N_[static_cast<std::size_t>(axis - kPush.begin())] = force_N;
    else
      grip_N_ = force_N;
  }

  void emergency_stop() noexcept { is_stopped_ = true; }

  void deactivate() noexcept {
    servo_.end();
    release_force(model_);
    gripper_force_N_ = 0.0;
  }

 private:
  struct Wrench {
    std::array<double, 3> force_N{}, torque_N_m{};
  };
  static constexpr std::uint32_t kTranslation = STILLGRID_DOF_X | STILLGRID_DOF_Y | STILLGRID_DOF_Z;
  static constexpr std::uint32_t kRotation =
      STILLGRID_DOF_ABOUT_X | STILLGRID_DOF_ABOUT_Y | STILLGRID_DOF_ABOUT_Z;

  void begin_servo() {
    is_stopped_ = false;
    is_late_ = options_.pace() == Pace::kLate;
    if (is_late_) {
      stillgrid_device_state state{};
      sample(steady_ns(), false, state);
      sampled_.put(state);
      servo_.begin(loop_.period_ns, [this](std::uint64_t now_ns) {
        stillgrid_device_state latest{};
        sample(now_ns, is_stopped_, latest);
        sampled_.put(latest);
        if (!is_stopped_) exert(commanded_.take());
        return true;
      });
    } else if (options_.pace() == Pace::kDevice && tick_) {
      servo_.begin(loop_.period_ns, [this](std::uint64_t /*now_ns*/) { return tick_(); });
    }
  }

  void exert(const Wrench& wrench) noexcept {
    const Eigen::Vector3d force_N(wrench.force_N.data()), torque_N_m(wrench.torque_N_m.data());
    command_force(model_, pivot_ ? force_at_handle_N(instrument_, force_N, torque_N_m) : force_N);
  }

  void sample(std::uint64_t now_ns, bool is_stopped, stillgrid_device_state& state) noexcept {
    catch_up(now_ns, is_stopped);
    state.valid = STILLGRID_STATE_POSITION | STILLGRID_STATE_BUTTONS;
    state.buttons = buttons_;
    state.time_ns = now_ns;
    state.sequence = ++sequence_;
    const Eigen::Vector3d position_m = read_encoders(model_);
    Eigen::Map<Eigen::Vector3d>(state.position_m) = position_m;
    if (pivot_) {
      instrument_ = place_instrument(instrument_, position_m, *pivot_);
      state.valid |= STILLGRID_STATE_ORIENTATION;
      Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw) = orientation_of(instrument_).coeffs();
    }
    if (model_.settings.gripper.open_m > 0.0) {
      state.valid |= STILLGRID_STATE_GRIPPER;
      state.gripper_m = model_.gripper_m;
    }
  }

  /// Moves the model to now_ns, the force held. What a stall takes beyond 50 ticks is skipped,
  /// or catching up would make the next read late in its turn.
  void catch_up(std::uint64_t now_ns, bool is_stopped) noexcept {
    constexpr std::uint64_t kMaxSubsteps = 50 * kSubstepsPerTick;
    if (is_stopped) release_force(model_);
    if (!has_started_) start_ns_ = now_ns;
    has_started_ = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      model_.settings.push_N[static_cast<Eigen::Index>(axis)] = push_N_[axis];
    model_.settings.gripper.grip_N = grip_N_;
    model_.gripper_force_N = is_stopped ? 0.0 : gripper_force_N_.load();
    const std::uint64_t free_ns = start_ns_ + options_.hold_ns();
    const std::uint64_t elapsed_ns = now_ns > free_ns ? now_ns - free_ns : 0;
    const std::uint64_t target = elapsed_ns * kSubstepsPerTick / loop_.period_ns;
    if (target <= model_.substeps_done) return;
    const std::uint64_t due = target - model_.substeps_done;
    if (due > kMaxSubsteps) start_ns_ += (due - kMaxSubsteps) * loop_.period_ns / kSubstepsPerTick;
    advance_phantom(model_, std::min(due, kMaxSubsteps));
  }

  HostLoop loop_;
  PhantomOptions options_;
  HostTick tick_;
  PhantomModel model_;
  std::optional<Eigen::Vector3d> pivot_;
  Instrument instrument_;  // as last read
  bool has_started_ = false;
  std::uint64_t start_ns_ = 0;
  std::uint64_t sequence_ = 0;

  // Of several threads: the servo's, the host's, who gives commands, who stops.
  bool is_late_ = false;
  std::atomic<bool> is_stopped_ = false;
  std::array<std::atomic<double>, 3> push_N_ = {};
  std::atomic<double> grip_N_ = 0.0, gripper_force_N_ = 0.0;
  static constexpr std::uint32_t kButtons = 2;  // of a Touch's stylus
  std::atomic<std::uint32_t> buttons_ = 0;
  Mailbox<stillgrid_device_state> sampled_;
  Mailbox<Wrench> commanded_;
  PhantomServo servo_;  // last: ended before what it uses is gone
};

}  // namespace
}  // namespace stillgrid::devices

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  return stillgrid::devices::PluginAdapter<stillgrid::devices::PhantomDriver>::negotiate(host, out);
}
