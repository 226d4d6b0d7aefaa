#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "haptic_server/devices/driver_host.hpp"
#include "haptic_server/devices/mailbox.hpp"
#include "haptic_server/devices/openhaptics_library.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::devices {

/// One device in the vendor's scheduler, whose thread calls back once a period: it reads the
/// device, runs the host's tick where there is one, and sends the newest force, all in one frame.
/// Without a tick the host's thread takes states and leaves forces in mailboxes; a force that it
/// has not written anew for 20 ms is zero. Nothing in the callback locks, allocates or waits.
class OpenHapticsServo {
 public:
  /// is_stopped: any thread sets it for zero force from the next frame on. Lives longer, as hd
  /// does.
  OpenHapticsServo(const OpenHapticsLibrary& hd, unsigned device, HostTick tick,
                   const std::atomic<bool>& is_stopped);
  ~OpenHapticsServo() { stop(); }

  OpenHapticsServo(const OpenHapticsServo&) = delete;
  OpenHapticsServo& operator=(const OpenHapticsServo&) = delete;

  /// Starts the scheduler, motors on, and waits for its first callback. Throws one line where it
  /// does not come within a second.
  void start();
  /// Zero force is sent, motors off, the scheduler stopped: no callback after it has returned.
  void stop() noexcept;
  /// The newest state, or E_IO: the device is lost, its pose is none, or there was no callback for
  /// 100 ms. Realtime: wait-free.
  std::int32_t read(std::uint64_t now_ns, stillgrid_device_state& state) noexcept;
  /// Realtime: wait-free.
  void write(std::uint64_t now_ns, const double* force_N) noexcept;

  /// Why read() returned E_IO, in a few words, and the vendor's code for it, zero: none.
  [[nodiscard]] const char* fault() const noexcept { return fault_; }
  [[nodiscard]] unsigned error() const noexcept { return error_; }

 private:
  struct Sample {
    stillgrid_device_state state{};
    bool is_lost = false;
    bool is_bad = false;
    unsigned error = 0;
  };
  struct Force {
    std::uint64_t time_ns = 0;
    std::array<double, 3> force_N{};
  };

  static unsigned on_frame(void* servo) noexcept;
  unsigned frame() noexcept;
  void sense(Sample& sample, std::uint64_t now_ns) noexcept;
  void note_error() noexcept;
  void note_status() noexcept;
  [[nodiscard]] std::array<double, 3> allowed_N(std::uint64_t now_ns) noexcept;

  const OpenHapticsLibrary& hd_;
  unsigned device_;
  HostTick tick_;
  const std::atomic<bool>& is_stopped_;
  unsigned long handle_ = 0;
  bool is_started_ = false;
  bool tells_temperature_ = false;

  Mailbox<Sample> samples_;
  Mailbox<Force> forces_;
  std::atomic<bool> is_ending_ = false;
  std::atomic<bool> has_begun_ = false;
  std::atomic<bool> has_ended_ = false;

  // Of the scheduler's thread.
  std::uint64_t frames_ = 0;
  std::uint64_t hot_until_ = 0, fault_until_ = 0;  // frames
  bool is_lost_ = false;
  bool is_ticking_ = true;
  bool is_calibrated_ = false;
  unsigned lost_by_ = 0;

  // Of the thread that reads.
  const char* fault_ = nullptr;
  unsigned error_ = 0;
};

}  // namespace stillgrid::devices
