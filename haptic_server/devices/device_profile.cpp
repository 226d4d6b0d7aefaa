#include "haptic_server/devices/device_profile.hpp"

#include <algorithm>
#include <cctype>
#include <string>

namespace stillgrid::devices {
namespace {

// CHAI3D 3.2, CDeltaDevices.cpp: force, stiffness, torque, gripper and the radius of the workspace,
// here its diameter along each axis; a sigma's is off the origin, by an offset whose sign is not
// told. That 20 N of the delta.3 are for ever: hapticore, dhd_real.cpp.
constexpr std::array kForceDimension{
    DeviceProfile{"delta.3", 20.0, 20.0, 5000.0, {0.3, 0.3, 0.3}, 0.0, 0.0},
    DeviceProfile{"omega.3", 12.0, 0.0, 5000.0, {0.15, 0.15, 0.15}, 0.0, 0.0},
    DeviceProfile{"omega.6", 12.0, 0.0, 5000.0, {0.15, 0.15, 0.15}, 0.0, 0.0},
    DeviceProfile{"omega.7", 12.0, 0.0, 5000.0, {0.15, 0.15, 0.15}, 0.0, 8.0},
    DeviceProfile{"sigma.7", 12.0, 0.0, 4000.0, {}, 0.2, 8.0},
    DeviceProfile{"falcon", 8.0, 0.0, 3000.0, {0.08, 0.08, 0.08}, 0.0, 0.0},
};

// As the simulated PHANToM's (phantom_model.cpp). No workspace: these devices' is not about their
// origin, and their library tells it.
constexpr std::array kOpenHaptics{
    DeviceProfile{"touch x", 7.9, 1.75, 1480.0, {}, 0.0, 0.0},
    DeviceProfile{"premium 1.5", 8.5, 1.4, 3500.0, {}, 0.0, 0.0},
    DeviceProfile{"touch", 3.3, 0.88, 1020.0, {}, 0.0, 0.0},
    DeviceProfile{"omni", 3.3, 0.88, 1020.0, {}, 0.0, 0.0},
};

void fill_in(double& figure, double published) noexcept {
  if (figure == 0.0) figure = published;
}

bool has_words(std::string_view name, std::string_view words) {
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find(' ', begin), words.size());
    if (name.find(words.substr(begin, end - begin)) == std::string_view::npos) return false;
    begin = end + 1;
  }
  return true;
}

}  // namespace

std::span<const DeviceProfile> force_dimension_profiles() noexcept {
  return kForceDimension;
}
std::span<const DeviceProfile> openhaptics_profiles() noexcept {
  return kOpenHaptics;
}

const DeviceProfile* profile_of(std::span<const DeviceProfile> profiles, std::string_view name) {
  std::string small(name);
  std::transform(small.begin(), small.end(), small.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  const auto found = std::find_if(profiles.begin(), profiles.end(), [&](const auto& profile) {
    return has_words(small, profile.words);
  });
  return found == profiles.end() ? nullptr : &*found;
}

void fill_in(stillgrid_device_descriptor& descriptor, const DeviceProfile& profile) noexcept {
  fill_in(descriptor.max_force_N, profile.max_force_N);
  fill_in(descriptor.continuous_force_N, profile.continuous_force_N);
  fill_in(descriptor.nominal_stiffness_N_per_m, profile.nominal_stiffness_N_per_m);
  fill_in(descriptor.max_torque_N_m, profile.max_torque_N_m);
  fill_in(descriptor.max_gripper_force_N, profile.max_gripper_force_N);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (descriptor.workspace_min_m[axis] < descriptor.workspace_max_m[axis]) continue;
    descriptor.workspace_min_m[axis] = -0.5 * profile.workspace_m[axis];
    descriptor.workspace_max_m[axis] = 0.5 * profile.workspace_m[axis];
  }
}

}  // namespace stillgrid::devices
