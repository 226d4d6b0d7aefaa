#include "haptic_server/device/device_host.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>

namespace stillgrid {
namespace {

[[noreturn]] void fail(DeviceFailure failure, const std::string& plugin, const std::string& line) {
  throw DeviceError(failure, "device '" + plugin + "': " + line);
}

/// A driver is asked never to let an exception out; one that does must not take us along.
template <class Call>
std::int32_t call_driver(const Call& call) noexcept {
  try {
    return call();
  } catch (...) {
    return STILLGRID_DEVICE_E_IO;
  }
}

/// Loads the library for good: its code may still be running in a thread of its own.
stillgrid_device_negotiate_fn load_negotiator(const std::string& plugin) {
  const std::filesystem::path file = find_device_plugin(plugin);
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const reason = dlerror();
    fail(DeviceFailure::kBadInput, plugin,
         std::string("expected a device plugin: ") + (reason == nullptr ? "" : reason));
  }
  void* const symbol = dlsym(library, "stillgrid_device_negotiate");
  if (symbol == nullptr) {
    fail(DeviceFailure::kBadInput, plugin,
         "expected a device plugin: it does not export stillgrid_device_negotiate");
  }
  return reinterpret_cast<stillgrid_device_negotiate_fn>(symbol);
}

bool has_every_function(const stillgrid_device_api& api) {
  return api.enumerate != nullptr && api.open != nullptr && api.configure != nullptr &&
         api.describe != nullptr && api.activate != nullptr && api.read != nullptr &&
         api.write != nullptr && api.deactivate != nullptr && api.close != nullptr &&
         api.emergency_stop != nullptr && api.strerror != nullptr;
}

stillgrid_device_api negotiate(const std::string& plugin, const DeviceLoop& loop) {
  const auto negotiator = load_negotiator(plugin);
  const stillgrid_host_info host{
      sizeof(stillgrid_host_info), STILLGRID_DEVICE_ABI_MIN, STILLGRID_DEVICE_ABI_MAX,
      loop.is_virtual ? STILLGRID_CLOCK_VIRTUAL : STILLGRID_CLOCK_MONOTONIC, loop.period_ns};
  stillgrid_device_api api{};
  api.struct_size = sizeof api;
  const std::int32_t code = call_driver([&] { return negotiator(&host, &api); });
  const bool is_in_range =
      api.abi >= STILLGRID_DEVICE_ABI_MIN && api.abi <= STILLGRID_DEVICE_ABI_MAX;
  if (code == STILLGRID_DEVICE_E_VERSION || (code == STILLGRID_DEVICE_OK && !is_in_range)) {
    fail(DeviceFailure::kCannotStart, plugin,
         "no common version of the device interface: expected " +
             std::to_string(STILLGRID_DEVICE_ABI_MIN) + " to " +
             std::to_string(STILLGRID_DEVICE_ABI_MAX));
  }
  if (code != STILLGRID_DEVICE_OK) {
    fail(DeviceFailure::kDeviceFault, plugin, "negotiate: code " + std::to_string(code));
  }
  if (api.struct_size < sizeof api || !has_every_function(api)) {
    fail(DeviceFailure::kDeviceFault, plugin, "negotiate: expected a table with every function");
  }
  return api;
}

bool is_sane(const stillgrid_device_descriptor& d) {
  const std::array limits = {d.position_resolution_m, d.max_force_N, d.continuous_force_N,
                             d.nominal_stiffness_N_m, d.rate_hz};
  bool sane = std::all_of(limits.begin(), limits.end(),
                          [](double limit) { return std::isfinite(limit) && limit >= 0.0; });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double min_m = d.workspace_min_m[axis];
    const double max_m = d.workspace_max_m[axis];
    sane = sane && std::isfinite(min_m) && std::isfinite(max_m) && min_m <= max_m;
  }
  return sane;
}

}  // namespace

Device::Device(const DeviceSpec& spec, const DeviceLoop& loop)
    : plugin_(spec.plugin), api_(negotiate(spec.plugin, loop)) {
  try {
    open(spec);
  } catch (...) {
    close();
    throw;
  }
}

Device::~Device() {
  deactivate();
  close();
}

void Device::open(const DeviceSpec& spec) {
  const std::int32_t count = call_driver([&] { return api_.enumerate(); });
  if (count == 0) fail(DeviceFailure::kDeviceFault, plugin_, "no device is present");
  require(std::min(count, STILLGRID_DEVICE_OK), "enumerate");
  require(call_driver([&] { return api_.open(0, &device_); }), "open");
  if (device_ == nullptr) fail(DeviceFailure::kDeviceFault, plugin_, "open: gave no device");
  for (const DeviceOption& option : spec.options) configure(option);
  describe();
  activate();
}

void Device::configure(const DeviceOption& option) {
  const std::int32_t code = call_driver(
      [&] { return api_.configure(device_, option.key.c_str(), option.value.c_str()); });
  require(code, "option " + option.key + "=" + option.value);
}

void Device::describe() {
  descriptor_.struct_size = sizeof descriptor_;
  require(call_driver([&] { return api_.describe(device_, &descriptor_); }), "describe");
  descriptor_.name[STILLGRID_DEVICE_NAME_SIZE - 1] = '\0';
  if (!is_sane(descriptor_)) {
    fail(DeviceFailure::kDeviceFault, plugin_,
         "describe: expected finite figures, none negative, workspace_min_m <= workspace_max_m");
  }
}

void Device::activate() {
  require(call_driver([&] { return api_.activate(device_); }), "activate");
  is_active_ = true;
}

void Device::close() noexcept {
  if (device_ == nullptr) return;
  call_driver([&] {
    api_.close(device_);
    return STILLGRID_DEVICE_OK;
  });
  device_ = nullptr;
}

std::int32_t Device::read(std::uint64_t now_ns, stillgrid_device_state& state) noexcept {
  state = {};
  state.struct_size = sizeof state;
  if (!is_active_) return STILLGRID_DEVICE_E_ORDER;
  const std::int32_t code = call_driver([&] { return api_.read(device_, now_ns, &state); });
  if (code != STILLGRID_DEVICE_OK && code != STILLGRID_DEVICE_END) state.valid = 0;
  return code;
}

std::int32_t Device::write(std::uint64_t now_ns, const Eigen::Vector3d& force_N,
                           const Eigen::Vector3d& torque_N_m) noexcept {
  if (!is_active_) return STILLGRID_DEVICE_E_ORDER;
  return call_driver(
      [&] { return api_.write(device_, now_ns, force_N.data(), torque_N_m.data()); });
}

void Device::deactivate() noexcept {
  if (!is_active_) return;
  is_active_ = false;
  call_driver([&] { return api_.deactivate(device_); });
}

void Device::emergency_stop() noexcept {
  call_driver([&] {
    api_.emergency_stop(device_);
    return STILLGRID_DEVICE_OK;
  });
}

std::string Device::error_line(std::int32_t code) const {
  const char* line = nullptr;
  call_driver([&] {
    line = api_.strerror(device_, code);
    return STILLGRID_DEVICE_OK;
  });
  return line == nullptr ? "code " + std::to_string(code) : line;
}

void Device::require(std::int32_t code, const std::string& step) const {
  if (code == STILLGRID_DEVICE_OK) return;
  // What a driver refuses as an argument came from the command line: it is the only input.
  const bool is_input = code == STILLGRID_DEVICE_E_ARGUMENT;
  fail(is_input ? DeviceFailure::kBadInput : DeviceFailure::kDeviceFault, plugin_,
       step + ": " + error_line(code));
}

double force_limit_N(const stillgrid_device_descriptor& device) noexcept {
  constexpr double kUndeclared_N = 40.0;
  return device.max_force_N > 0.0 ? device.max_force_N : kUndeclared_N;
}

}  // namespace stillgrid
