#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string_view>

// What the two fakes of vendors' libraries share: a handle with a hand on it, a fault that
// STILLGRID_FAKE_FAULT names and that comes STILLGRID_FAKE_AFTER_S after the motors were switched
// on, and the forces that were told, in the file STILLGRID_FAKE_LOG.
namespace stillgrid::integration {

using Vector = std::array<double, 3>;

/// The log, as vendor_faults_test.py reads it; forces are norms.
struct FakeLog {
  double last_N = 0.0;
  double greatest_N = 0.0;
  double at_fault_N = 0.0;  // told last before the fault
  double late_N =
      0.0;  // the greatest of the forces that follow the first kLate ones after the fault
  double fault_s = 0.0;  // when it came, 0: not yet
  double zero_after =
      -1.0;  // forces from the fault to the first zero, or the motors' end; -1: not yet
  double motors_are_on = 0.0;
};

constexpr int kLate = 20;  // forces: 20 ms at 1 kHz, however long a busy machine takes

inline double now_s() noexcept {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class FakeDevice {
 public:
  FakeDevice() {
    const char* const fault = std::getenv("STILLGRID_FAKE_FAULT");
    const char* const after = std::getenv("STILLGRID_FAKE_AFTER_S");
    const char* const file = std::getenv("STILLGRID_FAKE_LOG");
    if (fault != nullptr) fault_ = fault;
    if (after != nullptr) after_s_ = std::atof(after);
    if (file == nullptr) return;
    const int descriptor = ::open(file, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (descriptor < 0 || ::ftruncate(descriptor, sizeof(FakeLog)) != 0) std::abort();
    void* const place =
        ::mmap(nullptr, sizeof(FakeLog), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    ::close(descriptor);
    if (place == MAP_FAILED) std::abort();
    log_ = new (place) FakeLog;
  }

  [[nodiscard]] bool has(std::string_view fault) const noexcept { return fault_ == fault; }
  /// Whether that fault is the one asked for, and has come.
  [[nodiscard]] bool shows(std::string_view fault) noexcept {
    if (!has(fault) || on_s_ == 0.0 || now_s() < on_s_ + after_s_) return false;
    if (log_->fault_s == 0.0) {
      log_->at_fault_N = log_->last_N;
      log_->fault_s = now_s();
    }
    return true;
  }

  void motors_on() noexcept {
    if (on_s_ == 0.0) on_s_ = last_s_ = now_s();
    log_->motors_are_on = 1.0;
  }
  void motors_off() noexcept {
    log_->motors_are_on = 0.0;
    note_zero();
  }

  void tell(const Vector& force_N) noexcept {
    const double norm_N = std::hypot(force_N[0], force_N[1], force_N[2]);
    log_->last_N = norm_N;
    log_->greatest_N = std::max(log_->greatest_N, norm_N);
    if (log_->fault_s != 0.0 && ++since_fault_ > kLate)
      log_->late_N = std::max(log_->late_N, norm_N);
    if (norm_N == 0.0) note_zero();
    force_N_ = force_N;
  }

  /// 0.1 kg on a hand of 300 N/m and 5 N s/m that goes from 30 mm above the origin to 10 mm below
  /// it in 0.4 s, and stays; semi-implicit Euler of 0.1 ms.
  void advance() noexcept {
    constexpr double kStep_s = 1e-4, kMass_kg = 0.1, kStiffness_N_per_m = 300.0, kDamping = 5.0;
    const double time_s = now_s();
    if (on_s_ == 0.0) return;
    last_s_ = std::max(last_s_, time_s - 0.05);
    for (; last_s_ + kStep_s <= time_s; last_s_ += kStep_s) {
      const double share = std::clamp((last_s_ - on_s_) / 0.4, 0.0, 1.0);
      const Vector aim_m{0.0, 0.0, 0.03 - 0.04 * share};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double pull_N = kStiffness_N_per_m * (aim_m[axis] - position_m[axis]) -
                              kDamping * velocity_m_s[axis] + force_N_[axis];
        velocity_m_s[axis] += kStep_s / kMass_kg * pull_N;
        position_m[axis] += kStep_s * velocity_m_s[axis];
      }
    }
  }

  /// What is read where the faults "nan" or "huge" show.
  [[nodiscard]] double read(double number) noexcept {
    if (shows("nan")) return std::numeric_limits<double>::quiet_NaN();
    return shows("huge") ? 1e9 : number;
  }

  Vector position_m{0.0, 0.0, 0.03}, velocity_m_s{};

 private:
  void note_zero() noexcept {
    if (log_->fault_s != 0.0 && log_->zero_after < 0.0) log_->zero_after = since_fault_;
  }

  std::string_view fault_ = "";
  double after_s_ = 0.0;
  FakeLog own_;
  FakeLog* log_ = &own_;
  double on_s_ = 0.0, last_s_ = 0.0;
  int since_fault_ = 0;  // forces that were told
  Vector force_N_{};
};

}  // namespace stillgrid::integration
