#pragma once

#include <dlfcn.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <string>

#include "proto/device_plugin.h"

namespace stillgrid::devices {

constexpr std::uint64_t kTick_ns = 1'000'000;

inline stillgrid_device_negotiate_fn negotiator_of(const std::string& plugin) {
  const std::filesystem::path file = std::filesystem::path(STILLGRID_PLUGIN_DIR) / (plugin + ".so");
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  REQUIRE(library != nullptr);
  return reinterpret_cast<stillgrid_device_negotiate_fn>(
      dlsym(library, "stillgrid_device_negotiate"));
}

/// A plugin as a host sees it that has these extensions, closed at the end.
struct Plugin {
  explicit Plugin(const std::string& name, const void* (*get_extension)(const char*) = nullptr,
                  std::uint32_t clock = STILLGRID_CLOCK_VIRTUAL) {
    const stillgrid_host_info host{sizeof host, STILLGRID_DEVICE_ABI, clock, 0,
                                   kTick_ns,    get_extension};
    api.struct_size = sizeof api;
    REQUIRE(negotiator_of(name)(&host, &api) == STILLGRID_DEVICE_OK);
    REQUIRE(api.open(0, &device) == STILLGRID_DEVICE_OK);
  }
  ~Plugin() { api.close(device); }
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;

  [[nodiscard]] std::int32_t configure(const std::string& key, const std::string& value) const {
    return api.configure(device, key.c_str(), value.c_str());
  }
  [[nodiscard]] std::string line(std::int32_t code = STILLGRID_DEVICE_E_ARGUMENT) const {
    return api.strerror(device, code);
  }
  [[nodiscard]] stillgrid_device_descriptor describe() const {
    stillgrid_device_descriptor descriptor{};
    descriptor.struct_size = sizeof descriptor;
    REQUIRE(api.describe(device, &descriptor) == STILLGRID_DEVICE_OK);
    return descriptor;
  }
  [[nodiscard]] stillgrid_device_identity identity() const {
    const auto* const extension = static_cast<const stillgrid_device_identity_api*>(
        api.get_extension(STILLGRID_DEVICE_IDENTITY));
    REQUIRE(extension != nullptr);
    stillgrid_device_identity identity{};
    identity.struct_size = sizeof identity;
    REQUIRE(extension->identify(device, &identity) == STILLGRID_DEVICE_OK);
    return identity;
  }
  std::int32_t read(std::uint64_t now_ns) {
    state = {};
    state.struct_size = sizeof state;
    return api.read(device, now_ns, &state);
  }
  [[nodiscard]] std::int32_t write(std::uint64_t now_ns, double x_N, double y_N, double z_N) const {
    const std::array force_N = {x_N, y_N, z_N};
    return api.write(device, now_ns, force_N.data(), nullptr);
  }

  stillgrid_device_api api{};
  stillgrid_device* device = nullptr;
  stillgrid_device_state state{};
};

/// From 0 to 4 ms, with a corner in the middle.
inline const std::string kRecording = "t_s,x_m,y_m,z_m\n5,0,0,1\n5.002,0.2,0,1\n5.004,0.2,0.4,1\n";

}  // namespace stillgrid::devices
