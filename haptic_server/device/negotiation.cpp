#include "haptic_server/device/negotiation.hpp"

#include <dlfcn.h>

#include <cstdint>
#include <filesystem>

#include "haptic_server/device/driver_call.hpp"
#include "haptic_server/device/driver_text.hpp"
#include "haptic_server/device/host_extensions.hpp"

namespace stillgrid::device {
namespace {

stillgrid_device_negotiate_fn load_negotiator(const std::string& plugin) {
  const std::filesystem::path file = find_device_plugin(plugin);
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const reason = dlerror();
    fail_device(DeviceFailure::kBadInput, plugin,
                std::string("expected a device plugin: ") + (reason == nullptr ? "" : reason));
  }
  void* const symbol = dlsym(library, "stillgrid_device_negotiate");
  if (symbol == nullptr) {
    fail_device(DeviceFailure::kBadInput, plugin,
                "expected a device plugin: it does not export stillgrid_device_negotiate");
  }
  return reinterpret_cast<stillgrid_device_negotiate_fn>(symbol);
}

}  // namespace

bool has_every_function(const stillgrid_device_api& api) noexcept {
  return api.enumerate != nullptr && api.open != nullptr && api.configure != nullptr &&
         api.describe != nullptr && api.activate != nullptr && api.read != nullptr &&
         api.write != nullptr && api.deactivate != nullptr && api.close != nullptr &&
         api.emergency_stop != nullptr && api.strerror != nullptr;
}

void fail_device(DeviceFailure failure, const std::string& plugin, const std::string& line) {
  throw DeviceError(failure, "device '" + plugin + "': " + line);
}

stillgrid_device_api negotiate_device(const std::string& plugin, const DeviceLoop& loop) {
  const auto negotiator = load_negotiator(plugin);
  set_log_owner(plugin);
  set_session(loop.session);
  const stillgrid_host_info host{
      sizeof(stillgrid_host_info),
      STILLGRID_DEVICE_ABI,
      loop.is_virtual ? STILLGRID_CLOCK_VIRTUAL : STILLGRID_CLOCK_MONOTONIC,
      0,
      loop.period_ns,
      host_extension};
  Fenced<stillgrid_device_api> table;
  const stillgrid_device_api& api = table.value;
  const std::int32_t code = call_driver([&] { return negotiator(&host, &table.value); });
  if (!table.holds()) {
    fail_device(DeviceFailure::kDeviceFault, plugin,
                "negotiate: wrote past the struct_size of the host's table");
  }
  if (code == STILLGRID_DEVICE_E_VERSION ||
      (code == STILLGRID_DEVICE_OK && api.abi != STILLGRID_DEVICE_ABI)) {
    fail_device(DeviceFailure::kCannotStart, plugin,
                "built for another version of the device interface: expected " +
                    std::to_string(STILLGRID_DEVICE_ABI));
  }
  if (code != STILLGRID_DEVICE_OK)
    fail_device(DeviceFailure::kDeviceFault, plugin, "negotiate: code " + std::to_string(code));
  if (!has_every_function(api)) {
    fail_device(DeviceFailure::kDeviceFault, plugin,
                "negotiate: expected a table with every function up to strerror");
  }
  return api;
}

}  // namespace stillgrid::device
