#include "haptic_server/device/device_spec.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <system_error>

namespace stillgrid::device {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(std::string_view value, const std::string& expected) {
  throw DeviceError(DeviceFailure::kBadInput,
                    "device: value '" + std::string(value) + "': expected " + expected);
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// Takes the front of text up to the separator, or all of it.
std::string_view take_until(std::string_view& text, char separator) {
  const std::size_t end = std::min(text.find(separator), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return part;
}

/// Takes the "@N" from the plugin's end; a file's name may have one too.
void take_index(DeviceSpec& spec) {
  const std::size_t at = spec.plugin.rfind('@');
  if (at == std::string::npos || is_file(spec.plugin)) return;
  const char* const end = spec.plugin.data() + spec.plugin.size();
  const auto [stop, error] = std::from_chars(spec.plugin.data() + at + 1, end, spec.index);
  if (error == std::errc{} && stop == end) spec.plugin.resize(at);
}

}  // namespace

DeviceSpec parse_device_spec(std::string_view text) {
  std::string_view rest = text;
  DeviceSpec spec;
  spec.plugin = take_until(rest, ':');
  take_index(spec);
  if (spec.plugin.empty()) refuse(text, "PLUGIN[:key=value,...]");
  const bool has_options = text.find(':') != std::string_view::npos;
  if (has_options && (rest.empty() || rest.ends_with(','))) {
    refuse(text, "key=value after each ':' and ','");
  }
  while (!rest.empty()) {
    const std::string_view part = take_until(rest, ',');
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos || equals == 0) {
      refuse(part, "key=value, options of " + spec.plugin + " separated by ','");
    }
    const std::string key(part.substr(0, equals));
    const bool is_repeated =
        std::any_of(spec.options.begin(), spec.options.end(),
                    [&key](const DeviceOption& option) { return option.key == key; });
    if (is_repeated) refuse(part, "the key " + key + " only once");
    spec.options.push_back({key, std::string(part.substr(equals + 1))});
  }
  return spec;
}

std::vector<fs::path> installed_folders() {
  std::vector<fs::path> folders;
  if (const char* const listed = std::getenv("STILLGRID_DEVICE_PATH"); listed != nullptr) {
    for (std::string_view rest = listed; !rest.empty();) {
      const std::string_view folder = take_until(rest, ':');
      if (!folder.empty()) folders.emplace_back(folder);
    }
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    const fs::path above = program.parent_path().parent_path();
    folders.push_back(above / "lib" / "stillgrid" / "devices");
    // PREFIX/libexec/stillgrid holds what our scripts run.
    if (above.filename() == "libexec")
      folders.push_back(above.parent_path() / "lib" / "stillgrid" / "devices");
  }
  return folders;
}

std::filesystem::path find_device_plugin(const std::string& plugin) {
  if (plugin.find('/') != std::string::npos || plugin.ends_with(".so")) {
    if (!is_file(plugin)) refuse(plugin, "a device plugin: there is no such file");
    return fs::absolute(plugin);
  }
  std::string searched;
  for (const fs::path& folder : installed_folders()) {
    const fs::path candidate = folder / (plugin + ".so");
    if (is_file(candidate)) return fs::absolute(candidate);
    searched += (searched.empty() ? "" : ", ") + folder.string();
  }
  refuse(plugin, "a path to a .so, or a plugin installed in " + searched);
}

}  // namespace stillgrid::device
