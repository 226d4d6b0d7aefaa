#pragma once

#include <array>
#include <cstdint>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "proto/device_plugin.h"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/check_record.hpp"

namespace stillgrid::device_check {

/// Calls one function of the driver's, which the step and the complaints name.
/// Ends the check if an exception comes out.
template <class Call>
auto call_driver(const char* function, const Call& call) -> decltype(call()) {
  note_step(function);
  try {
    return call();
  } catch (const std::exception& error) {
    broken(std::string("an exception leaves ") + function + ": " + error.what());
  } catch (...) {
    broken(std::string("an exception leaves ") + function);
  }
}

/// "E_ORDER (-3)".
[[nodiscard]] std::string code_name(std::int32_t code);

/// Six digits of it: "0.25", "1e+300", "nan".
[[nodiscard]] std::string number_text(double number);

/// Loads the library as the server does. Ends the check if that cannot be.
[[nodiscard]] stillgrid_device_negotiate_fn load_driver(const Subject& subject);

/// What this host says of itself: our versions, CLOCK_MONOTONIC, 1 kHz, a log as its extension.
[[nodiscard]] stillgrid_host_info host_of_checks();

/// What was wrong with the driver's use of the log, or null.
[[nodiscard]] const char* log_complaint() noexcept;

/// Agrees on a table. Ends the check if the driver refuses or leaves functions out.
[[nodiscard]] stillgrid_device_api negotiate_table(const Subject& subject,
                                                   const stillgrid_host_info& host);

/// The first device, open and configured as the user asked. What goes wrong in its life ends the
/// check: CheckEnded. Destroyed, it is deactivated and closed whatever happened before.
class CheckedDevice {
 public:
  explicit CheckedDevice(const Subject& subject,
                         const stillgrid_host_info& host = host_of_checks());
  ~CheckedDevice();
  CheckedDevice(const CheckedDevice&) = delete;
  CheckedDevice& operator=(const CheckedDevice&) = delete;

  [[nodiscard]] const stillgrid_device_api& api() const noexcept { return api_; }
  [[nodiscard]] stillgrid_device* handle() const noexcept { return handle_; }

  void open(const Subject& subject);  // Pre: closed
  [[nodiscard]] stillgrid_device_descriptor describe();
  void activate();
  void deactivate();
  void close();

  /// The driver's code, any. Realtime: if the driver is.
  [[nodiscard]] std::int32_t read(std::uint64_t now_ns, stillgrid_device_state& state);
  [[nodiscard]] std::int32_t write(std::uint64_t now_ns, const std::array<double, 3>& force_N);

  /// Ends the check unless the code is 0 or END: broken, or absent if there is no device.
  void require(std::int32_t code, const std::string& step) const;

 private:
  void require_options_taken(std::int32_t code, const std::string& step) const;

  stillgrid_device_api api_;
  stillgrid_device* handle_ = nullptr;
  bool is_active_ = false;
};

/// Calls work(now_ns) once a millisecond, in a thread of its own that is the real-time thread and
/// a RealtimeSection, until it returns false or did so `ticks` times. Passes on what it throws.
void run_ticks(std::size_t ticks, const std::function<bool(std::uint64_t now_ns)>& work);

/// Reads once a tick and writes no force, until the end of a recording. Pre: active.
void read_ticks(CheckedDevice& device, std::size_t ticks);

}  // namespace stillgrid::device_check
