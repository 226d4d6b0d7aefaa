#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <set>
#include <string>

#include "haptic_server/device/device_spec.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"
#include "shared/tools/device_check/struct_sizes.hpp"

namespace stillgrid::device_check {
namespace {

using Listing = stillgrid_device_listing;

template <std::size_t N>
std::string text_of(const char (&text)[N], const char* name) {
  const std::size_t length = ::strnlen(text, N);
  if (length == N) broken(std::string(name) + " is not zero-terminated");
  return {text, length};
}

/// Of device number index: false after the last.
bool list(CheckedDevice& device, std::uint32_t index, Listing& out) {
  out = {};
  out.struct_size = sizeof out;
  const std::int32_t code =
      call_driver("list()", [&] { return device.api().list(device.handle(), index, &out); });
  if (code == STILLGRID_DEVICE_E_NO_DEVICE) return false;
  device.require(code, "list()");
  return true;
}

Outcome check_list(const Subject& subject) {
  CheckedDevice device(subject);
  if (device.api().list == nullptr) end_check(Verdict::kPass, "the driver has no list");
  constexpr std::uint32_t kMax = 64;
  std::uint32_t count = 0;
  Listing listing{};
  std::set<std::string> options;
  for (; count < kMax && list(device, count, listing); ++count) {
    if (text_of(listing.name, "name").empty()) broken("a device of the list has no name");
    (void)text_of(listing.serial, "serial");
    const std::string given = text_of(listing.options, "options");
    try {
      if (!given.empty()) (void)device::parse_device_spec("plugin:" + given);
    } catch (const device::DeviceError& error) {
      broken("options '" + given + "' cannot be given to --device: " + error.what());
    }
    if (!options.insert(given).second)
      broken("two devices of the list are opened by the same options, '" + given + "'");
  }
  if (count == kMax) broken("the list has no end: E_NO_DEVICE is expected after the last");
  if (count > 0)
    check_struct<Listing>("list()",
                          [&](Listing* out) { return device.api().list(device.handle(), 0, out); });
  if (call_driver("list() to a null place",
                  [&] { return device.api().list(device.handle(), 0, nullptr); }) >= 0)
    broken("list() to a null place is not refused");
  return {Verdict::kPass, std::to_string(count) + " in the list", {}};
}

Outcome check_command(const Subject& subject) {
  CheckedDevice device(subject);
  const stillgrid_device_api& api = device.api();
  if (api.command == nullptr) end_check(Verdict::kPass, "the driver takes no orders");
  const auto order = [&](const char* key, const char* value, const char* when) {
    const std::int32_t code =
        call_driver("command()", [&] { return api.command(device.handle(), key, value); });
    if (code >= 0) broken(std::string("command() ") + when + " answers " + code_name(code));
  };
  order("key", "value", "before activate()");
  device.activate();
  const std::string endless(10'000, 'x');
  order("no such order", "1", "of an unknown key");
  order("", "", "of an empty key");
  order(endless.c_str(), endless.c_str(), "of 10,000 characters");
  order(nullptr, "1", "of a null key");
  order("key", nullptr, "of a null value");
  read_ticks(device, 5);
  device.deactivate();
  order("key", "value", "after deactivate()");
  return {};
}

Outcome check_gripper(const Subject& subject) {
  CheckedDevice device(subject);
  const stillgrid_device_api& api = device.api();
  const bool is_declared = device.describe().max_gripper_force_N > 0.0;
  if (is_declared && api.write_gripper == nullptr)
    broken("it declares max_gripper_force_N, and write_gripper is null");
  if (api.write_gripper == nullptr) end_check(Verdict::kPass, "no gripper has a motor");
  const auto write = [&](double force_N) {
    return call_driver("write_gripper()", [&] {
      return api.write_gripper(device.handle(), realtime::monotonic_ns(), force_N);
    });
  };
  if (write(0.0) >= 0) broken("write_gripper() before activate() is not refused");
  device.activate();
  read_ticks(device, 5);
  device.require(write(0.0), "write_gripper() of no force");
  if (write(std::numeric_limits<double>::quiet_NaN()) >= 0)
    broken("write_gripper() of a force that is no number is not refused");
  device.deactivate();
  if (write(0.0) >= 0) broken("write_gripper() after deactivate() is not refused");
  return {};
}

constexpr std::array kChecks = {
    Check{"services.list", "lists the devices that it sees, each with options that open it",
          "life.order", check_list},
    Check{"services.command", "refuses orders that it does not know, or out of order", "life.again",
          check_command},
    Check{"services.gripper", "takes the gripper's force while it is active, and numbers alone",
          "life.again", check_gripper},
};

}  // namespace

std::span<const Check> service_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
