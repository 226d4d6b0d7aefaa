#include "haptic_server/device/device_host.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <sstream>

#include "haptic_server/device/driver_call.hpp"
#include "haptic_server/device/driver_text.hpp"
#include "haptic_server/device/negotiation.hpp"

namespace stillgrid::device {
namespace {

constexpr std::size_t kLongestErrorLine = 1024;

bool is_sane(const stillgrid_device_descriptor& d) {
  const std::array limits = {d.position_resolution_m,
                             d.max_force_N,
                             d.continuous_force_N,
                             d.nominal_stiffness_N_per_m,
                             d.rate_hz,
                             d.motor_time_constant_s,
                             d.max_speed_m_s,
                             d.max_torque_N_m,
                             d.continuous_torque_N_m,
                             d.gripper_open_m,
                             d.max_gripper_force_N};
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
    : spec_(spec), plugin_(spec.plugin), api_(negotiate_device(spec.plugin, loop)) {
  try {
    open();
    sets_pace_ = !loop.is_virtual && api_.set_tick != nullptr &&
                 (descriptor_.flags & STILLGRID_DEVICE_SETS_PACE) != 0;
    if (sets_pace_) require_rate(loop);
  } catch (...) {
    close();
    throw;
  }
}

Device::~Device() {
  deactivate();
  close();
}

void Device::reopen() {
  const stillgrid_device_descriptor before = descriptor_;
  const std::string serial = identity_.serial;
  close();
  try {
    open();
    // Limits, filters and recordings are the first device's.
    if (identity_.serial != serial || std::memcmp(&before, &descriptor_, sizeof before) != 0)
      fail_device(DeviceFailure::kDeviceFault, plugin_,
                  "another device has come: expected the name, serial number and limits of before");
    if (sets_pace_) set_tick(tick_, tick_context_);
  } catch (...) {
    descriptor_ = before;
    identity_.serial = serial;
    close();
    throw;
  }
}

void Device::open() {
  const std::int32_t count = call_driver([&] { return api_.enumerate(); });
  if (count == 0) fail_device(DeviceFailure::kDeviceFault, plugin_, "no device is present");
  require(std::min(count, STILLGRID_DEVICE_OK), "enumerate");
  stillgrid_device* opened = nullptr;  // kept only if the driver says that it is open
  require(call_driver([&] { return api_.open(spec_.index, &opened); }), "open");
  if (opened == nullptr) fail_device(DeviceFailure::kDeviceFault, plugin_, "open: gave no device");
  device_ = opened;
  for (const DeviceOption& option : spec_.options) configure(option);
  describe();
  identify();
}

void Device::configure(const DeviceOption& option) {
  const std::int32_t code = call_driver(
      [&] { return api_.configure(device_, option.key.c_str(), option.value.c_str()); });
  require(code, "option " + option.key + "=" + option.value);
}

void Device::describe() {
  Fenced<stillgrid_device_descriptor> described;
  require(call_driver([&] { return api_.describe(device_, &described.value); }), "describe");
  if (!described.holds()) {
    fail_device(DeviceFailure::kDeviceFault, plugin_,
                "describe: wrote past the struct_size of the descriptor");
  }
  descriptor_ = described.value;
  // Its name stands in reports and recordings. As a line it is no longer than it was.
  const std::string name = line_of(descriptor_.name, STILLGRID_DEVICE_NAME_SIZE - 1);
  std::memset(descriptor_.name, 0, sizeof descriptor_.name);
  std::memcpy(descriptor_.name, name.data(), name.size());
  if (!is_sane(descriptor_)) {
    fail_device(DeviceFailure::kDeviceFault, plugin_,
                "describe: expected finite figures, none negative, workspace_min_m <= "
                "workspace_max_m");
  }
}

void Device::identify() {
  if (api_.get_extension == nullptr) return;
  const stillgrid_device_identity_api* table = nullptr;
  require(call_driver([&] {
            table = static_cast<const stillgrid_device_identity_api*>(
                api_.get_extension(STILLGRID_DEVICE_IDENTITY));
            return STILLGRID_DEVICE_OK;
          }),
          "get_extension");
  if (table == nullptr) return;
  if (table->struct_size != sizeof *table || table->identify == nullptr) {
    fail_device(DeviceFailure::kDeviceFault, plugin_,
                "get_extension: expected a whole table of " STILLGRID_DEVICE_IDENTITY);
  }
  Fenced<stillgrid_device_identity> identified;
  require(call_driver([&] { return table->identify(device_, &identified.value); }), "identify");
  if (!identified.holds()) {
    fail_device(DeviceFailure::kDeviceFault, plugin_,
                "identify: wrote past the struct_size of the identity");
  }
  const auto line = [](const char* text) { return line_of(text, STILLGRID_IDENTITY_SIZE - 1); };
  identity_ = {line(identified.value.serial), line(identified.value.firmware),
               line(identified.value.driver)};
}

void Device::require_rate(const DeviceLoop& loop) const {
  constexpr double kSlack = 1e-3;
  const double rate_hz = 1e9 / static_cast<double>(loop.period_ns);
  if (descriptor_.rate_hz == 0.0 ||
      std::abs(descriptor_.rate_hz - rate_hz) <= kSlack * descriptor_.rate_hz)
    return;
  std::ostringstream line;
  line << "it sets the pace, at " << descriptor_.rate_hz << " Hz: expected --rate "
       << descriptor_.rate_hz << ", not " << rate_hz;
  fail_device(DeviceFailure::kBadInput, plugin_, line.str());
}

void Device::set_tick(stillgrid_device_tick_fn tick, void* context) {
  require(call_driver([&] { return api_.set_tick(device_, tick, context); }), "set_tick");
  tick_ = tick;
  tick_context_ = context;
}

void Device::activate() {
  if (device_ == nullptr)
    fail_device(DeviceFailure::kDeviceFault, plugin_, "activate: it is not open");
  const std::lock_guard no_command(commanding_);
  is_stopped_ = false;
  is_active_ = true;  // before: a device that sets the pace may read before it has returned
  const std::int32_t code = call_driver([&] { return api_.activate(device_); });
  if (code != STILLGRID_DEVICE_OK) is_active_ = false;
  require(code, "activate");
}

void Device::close() noexcept {
  const std::lock_guard no_command(commanding_);
  stillgrid_device* const device = device_.exchange(nullptr);
  if (device == nullptr) return;
  call_driver([&] {
    api_.close(device);
    return STILLGRID_DEVICE_OK;
  });
}

std::int32_t Device::read(std::uint64_t now_ns, stillgrid_device_state& state) noexcept {
  state = {};
  state.struct_size = sizeof state;
  if (!is_active_) return STILLGRID_DEVICE_E_ORDER;
  Fenced<stillgrid_device_state> fresh;
  std::int32_t code = call_driver([&] { return api_.read(device_, now_ns, &fresh.value); });
  if (!fresh.holds()) code = STILLGRID_DEVICE_E_IO;
  state = fresh.value;
  if (code != STILLGRID_DEVICE_OK && code != STILLGRID_DEVICE_END) state.valid = 0;
  return code;
}

std::int32_t Device::write(std::uint64_t now_ns, const Eigen::Vector3d& force_N,
                           const Eigen::Vector3d& torque_N_m) noexcept {
  if (!is_active_) return STILLGRID_DEVICE_E_ORDER;
  if (is_stopped_.load(std::memory_order_relaxed)) return STILLGRID_DEVICE_OK;
  return call_driver(
      [&] { return api_.write(device_, now_ns, force_N.data(), torque_N_m.data()); });
}

std::int32_t Device::write_gripper(std::uint64_t now_ns, double force_N) noexcept {
  if (!is_active_) return STILLGRID_DEVICE_E_ORDER;
  if (api_.write_gripper == nullptr || is_stopped_.load(std::memory_order_relaxed))
    return STILLGRID_DEVICE_OK;
  return call_driver([&] { return api_.write_gripper(device_, now_ns, force_N); });
}

std::string Device::command(const std::string& key, const std::string& value) {
  const std::lock_guard one_at_a_time(commanding_);
  if (api_.command == nullptr) return "the driver takes none";
  if (!is_active_) return "the device is not active";
  const std::int32_t code =
      call_driver([&] { return api_.command(device_, key.c_str(), value.c_str()); });
  return code == STILLGRID_DEVICE_OK ? std::string() : error_line(code);
}

std::int32_t Device::deactivate() noexcept {
  const std::lock_guard no_command(commanding_);
  if (!is_active_) return STILLGRID_DEVICE_OK;
  const std::int32_t code = call_driver([&] { return api_.deactivate(device_); });
  is_active_ = false;  // after: the last tick of a device that sets the pace has come to its end
  return code;
}

void Device::emergency_stop() noexcept {
  is_stopped_ = true;
  stillgrid_device* const device = device_;
  if (device == nullptr) return;
  call_driver([&] {
    api_.emergency_stop(device);
    return STILLGRID_DEVICE_OK;
  });
}

std::string Device::error_line(std::int32_t code) const {
  const char* line = nullptr;
  call_driver([&] {
    line = api_.strerror(device_, code);
    return STILLGRID_DEVICE_OK;
  });
  return line == nullptr ? "code " + std::to_string(code) : line_of(line, kLongestErrorLine);
}

void Device::require(std::int32_t code, const std::string& step) const {
  if (code == STILLGRID_DEVICE_OK) return;
  // What a driver refuses as an argument came from the command line: it is the only input.
  const bool is_input = code == STILLGRID_DEVICE_E_ARGUMENT;
  fail_device(is_input ? DeviceFailure::kBadInput : DeviceFailure::kDeviceFault, plugin_,
              step + ": " + error_line(code));
}

}  // namespace stillgrid::device
