#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"
#include "shared/tools/device_check/struct_sizes.hpp"

namespace stillgrid::device_check {
namespace {

constexpr std::array<double, 3> kZero{};

/// Ends the check unless the driver refused what `what` says.
void require_negative(std::int32_t code, const std::string& what) {
  if (code >= 0) broken(what + " answers " + code_name(code) + ", expected E_ARGUMENT");
}

/// A call that must be refused; its text is the step too.
template <class Call>
void refused(const std::string& what, const Call& call) {
  require_negative(call_driver(what.c_str(), call), what);
}

Outcome check_no_device(const Subject& subject) {
  const stillgrid_device_api api = negotiate_table(subject, host_of_checks());
  stillgrid_device_descriptor descriptor{};
  descriptor.struct_size = sizeof descriptor;
  stillgrid_device_state state{};
  state.struct_size = sizeof state;
  const std::uint64_t now_ns = realtime::monotonic_ns();
  refused("configure() of no device", [&] { return api.configure(nullptr, "key", "value"); });
  refused("describe() of no device", [&] { return api.describe(nullptr, &descriptor); });
  refused("activate() of no device", [&] { return api.activate(nullptr); });
  refused("read() of no device", [&] { return api.read(nullptr, now_ns, &state); });
  refused("write() of no device",
          [&] { return api.write(nullptr, now_ns, kZero.data(), kZero.data()); });
  refused("deactivate() of no device", [&] { return api.deactivate(nullptr); });
  call_driver("emergency_stop() of no device", [&] { api.emergency_stop(nullptr); });
  call_driver("close() of no device", [&] { api.close(nullptr); });
  return {};
}

Outcome check_nulls(const Subject& subject) {
  CheckedDevice device(subject);
  const stillgrid_device_api& api = device.api();
  stillgrid_device* const handle = device.handle();
  refused("open() to a null place", [&] { return api.open(0, nullptr); });
  refused("configure() of a null key", [&] { return api.configure(handle, nullptr, "value"); });
  refused("configure() of a null value", [&] { return api.configure(handle, "key", nullptr); });
  refused("describe() to a null place", [&] { return api.describe(handle, nullptr); });
  device.activate();
  const std::uint64_t now_ns = realtime::monotonic_ns();
  refused("read() to a null place", [&] { return api.read(handle, now_ns, nullptr); });
  refused("write() of a null force",
          [&] { return api.write(handle, now_ns, nullptr, kZero.data()); });
  call_driver("write() of a null torque",
              [&] { return api.write(handle, now_ns, kZero.data(), nullptr); });
  device.deactivate();
  return {};
}

Outcome check_index(const Subject& subject) {
  CheckedDevice device(subject);
  const stillgrid_device_api& api = device.api();
  const std::int32_t count = call_driver("enumerate()", [&] { return api.enumerate(); });
  const auto past = static_cast<std::uint32_t>(std::max(count, 0));
  for (const std::uint32_t index : {past, std::numeric_limits<std::uint32_t>::max()}) {
    stillgrid_device* other = nullptr;
    refused("open() of device " + std::to_string(index) + " of " + std::to_string(count),
            [&] { return api.open(index, &other); });
  }
  return {};
}

Outcome check_options(const Subject& subject) {
  CheckedDevice device(subject);
  const stillgrid_device_api& api = device.api();
  const std::string endless(100'000, 'k');
  for (const char* const key : {"no.such.key", "", endless.c_str()}) {
    const std::string shown = std::string(key).substr(0, 16);
    const std::string step = "configure() of the unknown key '" + shown + "'";
    const std::int32_t code =
        call_driver(step.c_str(), [&] { return api.configure(device.handle(), key, "value"); });
    if (code != STILLGRID_DEVICE_E_ARGUMENT)
      broken(step + " answers " + code_name(code) + ", expected E_ARGUMENT");
  }
  device.activate();
  device.deactivate();
  return {};
}

Outcome check_sizes(const Subject& subject) {
  CheckedDevice device(subject);
  const stillgrid_device_api& api = device.api();
  stillgrid_device* const handle = device.handle();
  check_struct<stillgrid_device_descriptor>(
      "describe()", [&](stillgrid_device_descriptor* out) { return api.describe(handle, out); });
  device.activate();
  run_ticks(1, [&](std::uint64_t now_ns) {
    check_struct<stillgrid_device_state>(
        "read()", [&](stillgrid_device_state* out) { return api.read(handle, now_ns, out); });
    return true;
  });
  device.deactivate();
  return {};
}

/// One line, terminated, not empty.
void check_line(const char* line, std::int32_t code) {
  constexpr std::size_t kLongest = 4096;
  const std::string what = "strerror() of " + code_name(code) + " gives ";
  if (line == nullptr) broken(what + "null");
  const std::size_t length = ::strnlen(line, kLongest);
  if (length == 0) broken(what + "no text");
  if (length == kLongest) broken(what + "more than 4095 characters");
  if (std::string_view(line, length).find('\n') != std::string_view::npos)
    broken(what + "more than one line");
}

Outcome check_errors(const Subject& subject) {
  CheckedDevice device(subject);
  const auto check_codes = [&](stillgrid_device* handle) {
    for (const std::int32_t code :
         {0, -1, -2, -3, -4, -5, -6, -7, -1000, 1, std::numeric_limits<std::int32_t>::min(),
          std::numeric_limits<std::int32_t>::max()})
      check_line(call_driver("strerror()", [&] { return device.api().strerror(handle, code); }),
                 code);
  };
  check_codes(nullptr);
  check_codes(device.handle());
  return {};
}

constexpr std::array kChecks = {
    Check{"arguments.no_device", "refuses a null device", "life.order", check_no_device},
    Check{"arguments.nulls", "refuses null places, keys, values and forces", "life.order",
          check_nulls},
    Check{"arguments.index", "refuses a device number that enumerate does not give", "life.order",
          check_index},
    Check{"arguments.options", "refuses an unknown key with E_ARGUMENT, and lives on", "life.order",
          check_options},
    Check{"arguments.sizes", "refuses structs of another size, and stays inside struct_size",
          "life.order", check_sizes},
    Check{"arguments.errors", "has one line on every code", "life.order", check_errors},
};

}  // namespace

std::span<const Check> argument_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
