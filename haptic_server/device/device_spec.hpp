#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::device {

/// What went wrong before the loops started; the value is the program's exit status.
enum class DeviceFailure : int {
  kBadInput = 1,     // no such plugin, option refused
  kCannotStart = 2,  // no common version of the interface
  kDeviceFault = 3,  // the device cannot be opened, described or activated
};

/// One line that names the plugin and, where there is one, the key, value and what is
/// expected.
class DeviceError : public std::runtime_error {
 public:
  DeviceError(DeviceFailure failure, const std::string& line)
      : std::runtime_error(line), failure_(failure) {}

  [[nodiscard]] DeviceFailure failure() const noexcept { return failure_; }
  [[nodiscard]] int exit_status() const noexcept { return static_cast<int>(failure_); }

 private:
  DeviceFailure failure_;
};

struct DeviceOption {
  std::string key;
  std::string value;
};

/// A plugin's path or name, and its options in the order given.
struct DeviceSpec {
  std::string plugin;
  std::vector<DeviceOption> options;
  std::uint32_t index = 0;  // of the devices that the driver enumerates
};

/// Reads "PLUGIN[@N][:key=value,...]", N from 0: which of the driver's devices. The first ':' ends
/// the plugin, a ',' ends a value, and the first '=' ends a key; so a value may hold any character
/// but ','.
///
/// Throws DeviceError (kBadInput) for an empty plugin or key, an option without '=', and a
/// key given twice.
[[nodiscard]] DeviceSpec parse_device_spec(std::string_view text);

/// The absolute path of a plugin: a path to a .so (anything with a '/' or ending in ".so"),
/// or the name of an installed one, looked for in the folders of $STILLGRID_DEVICE_PATH
/// (separated by ':'), then in ../lib/stillgrid/devices beside the program's own folder.
///
/// Throws DeviceError (kBadInput) when there is no such file.
[[nodiscard]] std::filesystem::path find_device_plugin(const std::string& plugin);

/// Where plugins are looked for by their names, in that order.
[[nodiscard]] std::vector<std::filesystem::path> installed_folders();

}  // namespace stillgrid::device
