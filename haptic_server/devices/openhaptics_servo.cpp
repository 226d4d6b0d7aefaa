#include "haptic_server/devices/openhaptics_servo.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "haptic_server/devices/openhaptics_state.hpp"

namespace stillgrid::devices {
namespace {

constexpr std::uint64_t kForceHeld_ns = 20'000'000;
constexpr std::uint64_t kLongestPause_ns = 100'000'000;
constexpr std::uint64_t kErrorShown = 100;         // frames
constexpr std::uint64_t kCalibrationChecked = 64;  // frames
constexpr double kWarm = 1.0;

std::uint64_t monotonic_ns() noexcept {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

bool comes_within(const std::atomic<bool>& flag, std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!flag && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return flag;
}

}  // namespace

OpenHapticsServo::OpenHapticsServo(const OpenHapticsLibrary& hd, unsigned device, HostTick tick,
                                   const std::atomic<bool>& is_stopped)
    : hd_(hd), device_(device), tick_(tick), is_stopped_(is_stopped) {}

void OpenHapticsServo::start() {
  std::array<double, 6> temperatures{};
  hd_.make_current_device(device_);
  hd_.get_doublev(kHdMotorTemperature, temperatures.data());
  tells_temperature_ = hd_.take_error().code == kHdSuccess;
  is_calibrated_ = hd_.check_calibration() == kHdCalibrationOk;
  hd_.enable(kHdForceOutput);
  is_started_ = true;
  handle_ = hd_.schedule_asynchronous(on_frame, this, kHdMaxSchedulerPriority);
  hd_.start_scheduler();
  const HdError error = hd_.take_error();
  const bool has_begun =
      error.code == kHdSuccess && comes_within(has_begun_, std::chrono::seconds(1));
  if (has_begun) return;
  stop();
  throw DriverError(STILLGRID_DEVICE_E_IO,
                    error.code == kHdSuccess
                        ? std::string("the vendor's scheduler did not call back within 1 s")
                        : std::string("the vendor's scheduler does not start: ") +
                              hd_.get_error_string(error.code));
}

void OpenHapticsServo::stop() noexcept {
  if (!is_started_) return;
  is_started_ = false;
  is_ending_ = true;
  const bool has_ended = comes_within(has_ended_, std::chrono::milliseconds(200));
  hd_.stop_scheduler();
  hd_.make_current_device(device_);
  if (!has_ended) {  // no callback has come to send it
    static constexpr std::array<double, 3> kZero{};
    hd_.unschedule(handle_);
    hd_.begin_frame(device_);
    hd_.set_doublev(kHdCurrentForce, kZero.data());
    hd_.end_frame(device_);
  }
  hd_.disable(kHdForceOutput);
  (void)hd_.take_error();
}

unsigned OpenHapticsServo::on_frame(void* servo) noexcept {
  return static_cast<OpenHapticsServo*>(servo)->frame();
}

unsigned OpenHapticsServo::frame() noexcept {
  const bool is_last = is_ending_;
  const std::uint64_t now_ns = monotonic_ns();
  ++frames_;
  hd_.make_current_device(device_);
  hd_.begin_frame(device_);
  Sample sample;
  sense(sample, now_ns);
  samples_.put(sample);
  has_begun_ = true;
  if (tick_ && is_ticking_ && !is_last) is_ticking_ = tick_();
  const std::array<double, 3> force_N =
      is_last || is_lost_ ? std::array<double, 3>{} : allowed_N(now_ns);
  hd_.set_doublev(kHdCurrentForce, force_N.data());
  hd_.end_frame(device_);
  note_error();
  if (is_last) has_ended_ = true;
  return is_last ? kHdCallbackDone : kHdCallbackContinue;
}

void OpenHapticsServo::sense(Sample& sample, std::uint64_t now_ns) noexcept {
  std::array<double, 16> transform{};
  std::array<double, 3> velocity{};
  int buttons = 0;
  hd_.get_doublev(kHdCurrentTransform, transform.data());
  hd_.get_doublev(kHdCurrentVelocity, velocity.data());
  hd_.get_integerv(kHdCurrentButtons, &buttons);
  note_status();
  note_error();
  stillgrid_device_state& state = sample.state;
  state.time_ns = now_ns;
  state.sequence = frames_;
  sample.is_lost = is_lost_;
  sample.error = lost_by_;
  const auto pose = pose_of(transform);
  sample.is_bad = !pose;
  if (!pose) return;
  state.valid = STILLGRID_STATE_POSITION | STILLGRID_STATE_ORIENTATION | STILLGRID_STATE_BUTTONS;
  Eigen::Map<Eigen::Vector3d>(state.position_m) = pose->position_m;
  Eigen::Map<Eigen::Vector4d>(state.orientation_xyzw) = pose->orientation.coeffs();
  state.buttons = static_cast<std::uint32_t>(buttons);
  const Eigen::Vector3d velocity_m_s = 1e-3 * Eigen::Map<const Eigen::Vector3d>(velocity.data());
  if (velocity_m_s.allFinite()) {
    state.valid |= STILLGRID_STATE_VELOCITY;
    Eigen::Map<Eigen::Vector3d>(state.velocity_m_s) = velocity_m_s;
  }
  state.status_known = STILLGRID_STATUS_MOTORS_ON | STILLGRID_STATUS_CALIBRATED |
                       STILLGRID_STATUS_HOT | STILLGRID_STATUS_FAULT;
  if (hd_.is_enabled(kHdForceOutput) != 0) state.status |= STILLGRID_STATUS_MOTORS_ON;
  if (is_calibrated_) state.status |= STILLGRID_STATUS_CALIBRATED;
  if (frames_ < hot_until_) state.status |= STILLGRID_STATUS_HOT;
  if (frames_ < fault_until_) state.status |= STILLGRID_STATUS_FAULT;
}

void OpenHapticsServo::note_status() noexcept {
  if (frames_ % kCalibrationChecked == 0)
    is_calibrated_ = hd_.check_calibration() == kHdCalibrationOk;
  if (!tells_temperature_) return;
  std::array<double, 6> temperatures{};
  hd_.get_doublev(kHdMotorTemperature, temperatures.data());
  if (*std::max_element(temperatures.begin(), temperatures.end()) >= kWarm)
    hot_until_ = frames_ + kErrorShown;
}

void OpenHapticsServo::note_error() noexcept {
  constexpr int kMaxErrors = 8;  // a frame's
  for (int n = 0; n < kMaxErrors; ++n) {
    const unsigned code = hd_.get_error().code;
    if (code == kHdSuccess) return;
    switch (effect_of(code)) {
      case HdEffect::kNone:
        break;
      case HdEffect::kHot:
        hot_until_ = frames_ + kErrorShown;
        break;
      case HdEffect::kFault:
        fault_until_ = frames_ + kErrorShown;
        break;
      case HdEffect::kLost:
        is_lost_ = true;
        lost_by_ = code;
        break;
    }
  }
}

std::array<double, 3> OpenHapticsServo::allowed_N(std::uint64_t now_ns) noexcept {
  const Force& force = forces_.take();
  const bool is_fresh = force.time_ns + kForceHeld_ns >= now_ns;
  return is_stopped_ || !is_fresh ? std::array<double, 3>{} : force.force_N;
}

std::int32_t OpenHapticsServo::read(std::uint64_t now_ns, stillgrid_device_state& state) noexcept {
  const Sample& sample = samples_.take();
  state = sample.state;
  error_ = sample.error;
  fault_ = nullptr;
  if (sample.is_lost)
    fault_ = "the device is lost";
  else if (sample.is_bad)
    fault_ = "the vendor's library gave a pose that is no number or leads out of the room";
  else if (sample.state.time_ns + kLongestPause_ns < now_ns)
    fault_ = "the vendor's scheduler has not called back for 100 ms";
  return fault_ == nullptr ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_IO;
}

void OpenHapticsServo::write(std::uint64_t now_ns, const double* force_N) noexcept {
  Force force;
  force.time_ns = now_ns;
  std::copy_n(force_N, 3, force.force_N.begin());
  forces_.put(force);
}

}  // namespace stillgrid::devices
