#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <type_traits>

#include "haptic_server/devices/driver_host.hpp"
#include "proto/device_plugin.h"

namespace stillgrid::devices {

/// The C ABI around a driver, which is a class of these members:
///   static constexpr const char* kName;
///   explicit Driver(const HostLoop&);
///   void configure(key, value)                  may throw: the option is refused
///   void describe(descriptor&)                  may throw: the options do not fit together
///   void activate()                             may throw, as describe()
///   int32_t read(now_ns, is_stopped, state&) noexcept     fills in all it marks as valid
///   int32_t write(now_ns, is_stopped, force_N, torque_N_m) noexcept    torque: may be null
///   void deactivate() noexcept                  zero force; or int32_t: whether there is none
/// and, where the driver has a use for them:
///   void identify(identity&)                    may throw, as describe()
///   void set_tick(HostTick)                     ticks come between activate() and deactivate()
///   bool list(index, listing&)                  may throw; false after the last
///   void command(key, value)                    may throw: the order is refused
///   int32_t write_gripper(now_ns, is_stopped, force_N) noexcept
///   void emergency_stop() noexcept              any thread: where a thread of the driver's serves
///                                               the device; is_stopped above says it as well
///   const char* fault_line(code) noexcept       on what read() or write() returned; null: nothing
/// This template keeps the order of life, the sizes of structs and the exceptions inside.
template <class Driver>
struct PluginAdapter {
  explicit PluginAdapter(const HostLoop& loop) : driver(loop) {}

  Driver driver;
  ErrorLine error;
  std::atomic<bool> is_active = false;   // a driver's own thread may tick before activate() is over
  std::atomic<bool> is_stopped = false;  // emergency_stop() may come from any thread

  static inline HostLoop host_loop;       // of the last negotiation
  static inline ErrorLine library_error;  // where there is no device to hold it

  static PluginAdapter* of(stillgrid_device* device) noexcept {
    return reinterpret_cast<PluginAdapter*>(device);
  }

  template <class Work>
  static std::int32_t guarded(ErrorLine& error, const Work& work) noexcept {
    try {
      work();
      return STILLGRID_DEVICE_OK;
    } catch (const std::bad_alloc&) {
      return error.set(STILLGRID_DEVICE_E_IO, "out of memory");
    } catch (const DriverError& fault) {
      return error.set(fault.code(), fault.what());
    } catch (const std::exception& refusal) {
      return error.set(STILLGRID_DEVICE_E_ARGUMENT, refusal.what());
    } catch (...) {
      return error.set(STILLGRID_DEVICE_E_IO, "unknown fault in the driver");
    }
  }

  static std::int32_t enumerate() noexcept { return 1; }

  static std::int32_t open(std::uint32_t index, stillgrid_device** out) noexcept {
    if (out == nullptr) {
      return library_error.set(STILLGRID_DEVICE_E_ARGUMENT, "open: no place for the device");
    }
    *out = nullptr;
    if (index != 0) {
      return library_error.set(STILLGRID_DEVICE_E_NO_DEVICE, "open: there is only device 0");
    }
    return guarded(library_error, [out] {
      *out =
          reinterpret_cast<stillgrid_device*>(std::make_unique<PluginAdapter>(host_loop).release());
    });
  }

  static std::int32_t configure(stillgrid_device* device, const char* key,
                                const char* value) noexcept {
    if (device == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (self.is_active) return STILLGRID_DEVICE_E_ORDER;
    if (key == nullptr || value == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    return guarded(self.error, [&] { self.driver.configure(key, value); });
  }

  static std::int32_t describe(stillgrid_device* device,
                               stillgrid_device_descriptor* out) noexcept {
    if (device == nullptr || !has_size(out)) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    stillgrid_device_descriptor descriptor{};
    std::strncpy(descriptor.name, Driver::kName, sizeof descriptor.name - 1);
    descriptor.rate_hz = 1e9 / static_cast<double>(host_loop.period_ns);
    const std::int32_t code = guarded(self.error, [&] { self.driver.describe(descriptor); });
    if (code == STILLGRID_DEVICE_OK) copy_out(descriptor, out);
    return code;
  }

  static std::int32_t activate(stillgrid_device* device) noexcept {
    if (device == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (self.is_active) return STILLGRID_DEVICE_E_ORDER;
    self.is_stopped = false;  // before: a stop while motors come on must last
    self.is_active = true;
    const std::int32_t code = guarded(self.error, [&] { self.driver.activate(); });
    if (code != STILLGRID_DEVICE_OK) self.is_active = false;
    return code;
  }

  static std::int32_t read(stillgrid_device* device, std::uint64_t now_ns,
                           stillgrid_device_state* out) noexcept {
    if (device == nullptr || !has_size(out)) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (!self.is_active) return STILLGRID_DEVICE_E_ORDER;
    stillgrid_device_state state{};
    const std::int32_t code = self.driver.read(now_ns, self.is_stopped, state);
    copy_out(state, out);
    return code;
  }

  static std::int32_t write(stillgrid_device* device, std::uint64_t now_ns, const double* force_N,
                            const double* torque_N_m) noexcept {
    if (device == nullptr || force_N == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (!self.is_active) return STILLGRID_DEVICE_E_ORDER;
    return self.driver.write(now_ns, self.is_stopped, force_N, torque_N_m);
  }

  static std::int32_t write_gripper(stillgrid_device* device, std::uint64_t now_ns,
                                    double force_N) noexcept {
    if (device == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (!self.is_active) return STILLGRID_DEVICE_E_ORDER;
    return self.driver.write_gripper(now_ns, self.is_stopped, force_N);
  }

  static std::int32_t set_tick(stillgrid_device* device, stillgrid_device_tick_fn tick,
                               void* context) noexcept {
    if (device == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (self.is_active) return STILLGRID_DEVICE_E_ORDER;
    self.driver.set_tick(HostTick{tick, context});
    return STILLGRID_DEVICE_OK;
  }

  static std::int32_t list(stillgrid_device* device, std::uint32_t index,
                           stillgrid_device_listing* out) noexcept {
    if (device == nullptr || !has_size(out)) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (self.is_active) return STILLGRID_DEVICE_E_ORDER;
    stillgrid_device_listing listing{};
    bool is_there = false;
    const std::int32_t code =
        guarded(self.error, [&] { is_there = self.driver.list(index, listing); });
    if (code != STILLGRID_DEVICE_OK) return code;
    if (is_there) copy_out(listing, out);
    return is_there ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_NO_DEVICE;
  }

  static std::int32_t command(stillgrid_device* device, const char* key,
                              const char* value) noexcept {
    if (device == nullptr || key == nullptr || value == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (!self.is_active) return STILLGRID_DEVICE_E_ORDER;
    return guarded(self.error, [&] { self.driver.command(key, value); });
  }

  static std::int32_t deactivate(stillgrid_device* device) noexcept {
    if (device == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    if (!self.is_active) return STILLGRID_DEVICE_E_ORDER;
    std::int32_t code = STILLGRID_DEVICE_OK;
    if constexpr (std::is_void_v<decltype(self.driver.deactivate())>)
      self.driver.deactivate();
    else
      code = self.driver.deactivate();
    self.is_active = false;
    return code;
  }

  static void close(stillgrid_device* device) noexcept {
    deactivate(device);
    delete of(device);
  }

  static void emergency_stop(stillgrid_device* device) noexcept {
    if (device == nullptr) return;
    of(device)->is_stopped = true;
    if constexpr (requires(Driver & own) { own.emergency_stop(); })
      of(device)->driver.emergency_stop();
  }

  static const char* strerror(stillgrid_device* device, std::int32_t code) noexcept {
    const ErrorLine& error = device == nullptr ? library_error : of(device)->error;
    if (code != STILLGRID_DEVICE_OK && code == error.code) return error.text.data();
    if constexpr (requires(Driver & own) { own.fault_line(0); }) {
      const char* const line = device == nullptr ? nullptr : of(device)->driver.fault_line(code);
      if (line != nullptr) return line;
    }
    switch (code) {
      case STILLGRID_DEVICE_OK:
        return "done";
      case STILLGRID_DEVICE_E_VERSION:
        return "built for another version of the device interface";
      case STILLGRID_DEVICE_E_ARGUMENT:
        return "null argument, or a struct of another size";
      case STILLGRID_DEVICE_E_ORDER:
        return "call not allowed in this state of life";
      case STILLGRID_DEVICE_E_NO_DEVICE:
        return "no such device";
      case STILLGRID_DEVICE_E_IO:
        return "the device stopped answering";
      case STILLGRID_DEVICE_END:
        return "the recording has come to its end";
      default:
        return "unknown code";
    }
  }

  /// Returns whether a struct of the host's is there, and of this header's size.
  template <class Struct>
  static bool has_size(const Struct* given) noexcept {
    return given != nullptr && given->struct_size == sizeof(Struct);
  }

  template <class Struct>
  static void copy_out(Struct& from, Struct* to) noexcept {
    from.struct_size = sizeof(Struct);
    *to = from;
  }

  static std::int32_t identify(stillgrid_device* device, stillgrid_device_identity* out) noexcept {
    if (device == nullptr || !has_size(out)) return STILLGRID_DEVICE_E_ARGUMENT;
    PluginAdapter& self = *of(device);
    stillgrid_device_identity identity{};
    const std::int32_t code = guarded(self.error, [&] { self.driver.identify(identity); });
    if (code == STILLGRID_DEVICE_OK) copy_out(identity, out);
    return code;
  }

  static const void* get_extension(const char* name) noexcept {
    if constexpr (requires(Driver & own, stillgrid_device_identity & i) { own.identify(i); }) {
      static constexpr stillgrid_device_identity_api kIdentity{sizeof kIdentity, 0, identify};
      if (name != nullptr && std::string_view(name) == STILLGRID_DEVICE_IDENTITY) return &kIdentity;
    }
    return nullptr;
  }

  /// A table of the host's by its name, or null.
  template <class Table>
  static const Table* extension_of(const stillgrid_host_info& host, const char* name) noexcept {
    if (host.get_extension == nullptr) return nullptr;
    const auto* const table = static_cast<const Table*>(host.get_extension(name));
    return has_size(table) ? table : nullptr;
  }

  static stillgrid_device_api table() noexcept {
    stillgrid_device_api api{};
    api.enumerate = enumerate;
    api.open = open;
    api.configure = configure;
    api.describe = describe;
    api.activate = activate;
    api.read = read;
    api.write = write;
    api.deactivate = deactivate;
    api.close = close;
    api.emergency_stop = emergency_stop;
    api.strerror = strerror;
    api.get_extension = get_extension;
    using Own = Driver&;
    if constexpr (requires(Own own) { own.set_tick(HostTick{}); }) api.set_tick = set_tick;
    if constexpr (requires(Own own, stillgrid_device_listing & l) { own.list(0U, l); })
      api.list = list;
    if constexpr (requires(Own own) { own.command("", ""); }) api.command = command;
    if constexpr (requires(Own own) { own.write_gripper(0, false, 0.0); })
      api.write_gripper = write_gripper;
    return api;
  }

  static std::int32_t negotiate(const stillgrid_host_info* host,
                                stillgrid_device_api* out) noexcept {
    if (host == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
    if (host->abi != STILLGRID_DEVICE_ABI) return STILLGRID_DEVICE_E_VERSION;
    if (!has_size(host) || !has_size(out) || host->period_ns == 0)
      return STILLGRID_DEVICE_E_ARGUMENT;
    host_loop.period_ns = host->period_ns;
    host_loop.clock = host->clock;
    host_loop.log.table = extension_of<stillgrid_host_log>(*host, STILLGRID_HOST_LOG);
    const auto* const session = extension_of<stillgrid_host_session>(*host, STILLGRID_HOST_SESSION);
    const bool serves_one = session != nullptr && session->name != nullptr;
    host_loop.session = serves_one ? session->name : "";
    stillgrid_device_api api = table();
    api.abi = STILLGRID_DEVICE_ABI;
    copy_out(api, out);
    return STILLGRID_DEVICE_OK;
  }
};

}  // namespace stillgrid::devices
