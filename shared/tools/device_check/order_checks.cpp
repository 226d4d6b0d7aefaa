#include <array>
#include <string>

#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"

namespace stillgrid::device_check {
namespace {

/// Ends the check unless the driver refused a call out of order.
void require_refused(std::int32_t code, const std::string& what) {
  if (code == STILLGRID_DEVICE_E_ORDER || code == STILLGRID_DEVICE_E_ARGUMENT) return;
  broken(what + " answers " + code_name(code) + ", expected E_ORDER");
}

/// What only an active device may be asked.
void ask_inactive(CheckedDevice& device, const std::string& when) {
  stillgrid_device_state state{};
  const std::uint64_t now_ns = realtime::monotonic_ns();
  require_refused(device.read(now_ns, state), "read() " + when);
  require_refused(device.write(now_ns, {}), "write() " + when);
  require_refused(
      call_driver("deactivate()", [&] { return device.api().deactivate(device.handle()); }),
      "deactivate() " + when);
}

void live(CheckedDevice& device) {
  device.activate();
  read_ticks(device, 5);
  device.deactivate();
}

Outcome check_before(const Subject& subject) {
  CheckedDevice device(subject);
  ask_inactive(device, "before activate()");
  live(device);
  return {};
}

Outcome check_active(const Subject& subject) {
  CheckedDevice device(subject);
  device.activate();
  const stillgrid_device_api& api = device.api();
  require_refused(call_driver("activate()", [&] { return api.activate(device.handle()); }),
                  "activate() while active");
  const device::DeviceOption option =
      subject.options.empty() ? device::DeviceOption{"key", "value"} : subject.options.front();
  require_refused(
      call_driver(
          "configure()",
          [&] { return api.configure(device.handle(), option.key.c_str(), option.value.c_str()); }),
      "configure() while active");
  read_ticks(device, 5);
  device.deactivate();
  live(device);
  return {};
}

Outcome check_after(const Subject& subject) {
  CheckedDevice device(subject);
  live(device);
  ask_inactive(device, "after deactivate()");
  live(device);
  return {};
}

Outcome check_close(const Subject& subject) {
  CheckedDevice device(subject);
  device.activate();
  read_ticks(device, 5);
  device.close();
  device.open(subject);
  live(device);
  return {};
}

constexpr std::array kChecks = {
    Check{"order.before_activate", "refuses read, write and deactivate before activate",
          "life.again", check_before},
    Check{"order.while_active", "refuses activate and configure while it is active", "life.again",
          check_active},
    Check{"order.after_deactivate", "refuses read, write and deactivate after deactivate",
          "life.again", check_after},
    Check{"order.close_active", "may be closed while it is active", "life.again", check_close},
};

}  // namespace

std::span<const Check> order_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
