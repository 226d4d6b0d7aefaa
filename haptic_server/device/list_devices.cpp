#include "haptic_server/device/list_devices.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/device/driver_call.hpp"
#include "haptic_server/device/driver_text.hpp"
#include "haptic_server/device/negotiation.hpp"

namespace stillgrid::device {
namespace {

constexpr std::int32_t kMaxDevices = 64;
constexpr unsigned kLongest_s = 20;

void print_row(const std::string& device, const std::string& name, const std::string& serial) {
  std::printf("%-40s %-20s %s\n", device.c_str(), name.c_str(), serial.c_str());
}

std::string text_of(const DeviceSpec& spec) {
  std::string text = spec.plugin;
  if (spec.index > 0) text.append(1, '@').append(std::to_string(spec.index));
  for (std::size_t i = 0; i < spec.options.size(); ++i)
    text.append(1, i == 0 ? ':' : ',')
        .append(spec.options[i].key)
        .append(1, '=')
        .append(spec.options[i].value);
  return text;
}

/// What opens the listed device: its options in the place of those given, and of whatever else
/// selects one.
DeviceSpec selecting(DeviceSpec spec, const std::string& listed) {
  if (listed.empty()) return spec;
  const std::vector<DeviceOption> own = parse_device_spec(spec.plugin + ":" + listed).options;
  constexpr std::array<std::string_view, 4> kSelectors = {"index", "serial", "name", "device_id"};
  std::erase_if(spec.options, [&](const DeviceOption& given) {
    return std::find(kSelectors.begin(), kSelectors.end(), given.key) != kSelectors.end() ||
           std::any_of(own.begin(), own.end(),
                       [&](const DeviceOption& option) { return option.key == given.key; });
  });
  spec.options.insert(spec.options.end(), own.begin(), own.end());
  return spec;
}

/// A line without the plugin's name before it, which its row has.
void print_none(const DeviceSpec& spec, std::string line) {
  const std::string before = "device '" + spec.plugin + "': ";
  if (line.starts_with(before)) line.erase(0, before.size());
  print_row(text_of(spec), "-", line);
}

/// A device of a driver that has no list.
void print_enumerated(DeviceSpec spec, std::uint32_t index) {
  spec.index = index;
  try {
    const Device device(spec, {});
    print_row(text_of(spec), device.descriptor().name, device.identity().serial);
  } catch (const DeviceError& error) {
    print_none(spec, error.what());
  }
}

/// Closed on every way.
class OpenHandle {
 public:
  OpenHandle(const stillgrid_device_api& api, const DeviceSpec& spec) : api_(api), spec_(spec) {
    require(call_driver([&] { return api_.open(spec.index, &handle_); }), "open");
    if (handle_ == nullptr)
      fail_device(DeviceFailure::kDeviceFault, spec_.plugin, "open: gave no device");
    for (const DeviceOption& option : spec.options)
      require(call_driver([&] {
                return api_.configure(handle_, option.key.c_str(), option.value.c_str());
              }),
              "option " + option.key + "=" + option.value);
  }
  ~OpenHandle() {
    if (handle_ != nullptr)
      call_driver([&] {
        api_.close(handle_);
        return STILLGRID_DEVICE_OK;
      });
  }
  OpenHandle(const OpenHandle&) = delete;
  OpenHandle& operator=(const OpenHandle&) = delete;

  /// False after the last.
  bool list(std::uint32_t index, stillgrid_device_listing& out) {
    Fenced<stillgrid_device_listing> listed;
    const std::int32_t code = call_driver([&] { return api_.list(handle_, index, &listed.value); });
    if (code == STILLGRID_DEVICE_E_NO_DEVICE && index > 0) return false;
    require(code, "list");
    if (!listed.holds())
      fail_device(DeviceFailure::kDeviceFault, spec_.plugin,
                  "list: wrote past the struct_size of the listing");
    out = listed.value;
    return true;
  }

 private:
  void require(std::int32_t code, const std::string& step) {
    if (code == STILLGRID_DEVICE_OK) return;
    const char* line = nullptr;
    call_driver([&] {
      line = api_.strerror(handle_, code);
      return STILLGRID_DEVICE_OK;
    });
    if (step == "open") handle_ = nullptr;  // what a refused call gave
    fail_device(code == STILLGRID_DEVICE_E_ARGUMENT ? DeviceFailure::kBadInput
                                                    : DeviceFailure::kDeviceFault,
                spec_.plugin, step + ": " + (line == nullptr ? "" : line_of(line, 1024)));
  }

  const stillgrid_device_api& api_;
  const DeviceSpec& spec_;
  stillgrid_device* handle_ = nullptr;
};

void print_rows(const DeviceSpec& spec) {
  const stillgrid_device_api api = negotiate_device(spec.plugin, {});
  if (api.list == nullptr) {
    const std::int32_t count = call_driver([&] { return api.enumerate(); });
    if (count < 0)
      fail_device(DeviceFailure::kDeviceFault, spec.plugin,
                  "enumerate: answers " + std::to_string(count));
    if (count == 0 || std::int64_t{spec.index} >= count)
      fail_device(DeviceFailure::kDeviceFault, spec.plugin,
                  count == 0 ? "no device is present"
                             : "there are devices @0 to @" + std::to_string(count - 1));
    for (std::int32_t i = 0; i < std::min(count, kMaxDevices); ++i)
      print_enumerated(spec, static_cast<std::uint32_t>(i));
    return;
  }
  OpenHandle driver(api, spec);
  stillgrid_device_listing listed{};
  for (std::uint32_t i = 0; i < kMaxDevices && driver.list(i, listed); ++i) {
    const std::string options = line_of(listed.options, sizeof listed.options - 1);
    print_row(text_of(selecting(spec, options)), line_of(listed.name, sizeof listed.name - 1),
              line_of(listed.serial, sizeof listed.serial - 1));
  }
}

/// What a child says that came to its end; a driver that ends the program cannot.
constexpr int kListed = 100, kFailed = 101;

std::string died(int status) {
  if (!WIFSIGNALED(status)) return "ends the program";
  return WTERMSIG(status) == SIGALRM ? "does not answer within 20 s"
                                     : std::string("crashes: ") + ::strsignal(WTERMSIG(status));
}

/// Prints the rows in a process of its own, what is wrong by say(), an empty line where it was
/// said there. Returns the exit status.
template <class Say>
int print_in_process(const DeviceSpec& spec, Say&& say) {
  std::fflush(stdout);
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(kLongest_s);
    int failure = 0;
    try {
      print_rows(spec);
    } catch (const DeviceError& error) {
      say(std::string(error.what()));
      failure = error.exit_status();
    }
    std::_Exit(std::fflush(stdout) != 0 ? kFailed : kListed + 2 * failure);
  }
  int status = 0;
  constexpr int kFault = static_cast<int>(DeviceFailure::kDeviceFault);
  if (child < 0 || ::waitpid(child, &status, 0) != child) {
    say("no process to ask it in");
    return kFault;
  }
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  if (code == kFailed) return static_cast<int>(DeviceFailure::kBadInput);
  if (code >= kListed) return (code - kListed) / 2;
  say(died(status));
  return kFault;
}

}  // namespace

int print_devices(const std::string& device) {
  const DeviceSpec spec = parse_device_spec(device);
  const int status = print_in_process(spec, [&](const std::string& line) {
    const bool is_named = line.starts_with("device '");
    std::fprintf(stderr, "haptic_server: %s%s\n",
                 is_named ? "" : ("device '" + spec.plugin + "': ").c_str(), line.c_str());
  });
  return status;
}

int print_installed_devices() {
  std::set<std::string> plugins;
  for (const std::filesystem::path& folder : installed_folders()) {
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder, none))
      if (entry.path().extension() == ".so") plugins.insert(entry.path().stem());
  }
  if (plugins.empty()) std::printf("no driver is installed\n");
  for (const std::string& plugin : plugins) {
    DeviceSpec spec;
    spec.plugin = plugin;
    (void)print_in_process(spec, [&](const std::string& line) { print_none(spec, line); });
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}

}  // namespace stillgrid::device
