#include "shared/tools/device_check/checked_device.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <string_view>
#include <thread>

#include "haptic_server/device/negotiation.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_guard.hpp"

namespace stillgrid::device_check {
namespace {

constexpr std::uint64_t kPeriod_ns = 1'000'000;
constexpr std::array<double, 3> kNoTorque_N_m{};

thread_local bool is_realtime_thread = false;
std::atomic<const char*> complaint_of_log = nullptr;

void log_line(std::uint32_t /*severity*/, const char* line) {
  if (is_realtime_thread) {
    complaint_of_log = "the real-time thread logs a line";
  } else if (line == nullptr) {
    complaint_of_log = "null is logged for a line";
  } else {
    std::fprintf(stderr, "log: %s\n", line);
  }
}

const void* host_extension(const char* name) {
  static const stillgrid_host_log log{sizeof log, 0, log_line};
  return name != nullptr && std::string_view(name) == STILLGRID_HOST_LOG ? &log : nullptr;
}

}  // namespace

std::string code_name(std::int32_t code) {
  static constexpr std::array kNames = {"OK",          "E_VERSION", "E_ARGUMENT", "E_ORDER",
                                        "E_NO_DEVICE", "E_IO",      "END"};
  const std::int64_t index = -std::int64_t{code};
  if (index < 0 || index >= std::ssize(kNames)) return std::to_string(code);
  return std::string(kNames.at(static_cast<std::size_t>(index))) + " (" + std::to_string(code) +
         ")";
}

std::string number_text(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", number);
  return text.data();
}

stillgrid_device_negotiate_fn load_driver(const Subject& subject) {
  note_step("loading the library");
  void* const library = ::dlopen(subject.library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const reason = ::dlerror();
    broken(reason == nullptr ? "the loader refuses it" : reason);
  }
  void* const symbol = ::dlsym(library, "stillgrid_device_negotiate");
  if (symbol == nullptr) broken("it does not export stillgrid_device_negotiate");
  return reinterpret_cast<stillgrid_device_negotiate_fn>(symbol);
}

stillgrid_host_info host_of_checks() {
  return {sizeof(stillgrid_host_info),
          STILLGRID_DEVICE_ABI,
          STILLGRID_CLOCK_MONOTONIC,
          0,
          kPeriod_ns,
          host_extension};
}

const char* log_complaint() noexcept {
  return complaint_of_log;
}

stillgrid_device_api negotiate_table(const Subject& subject, const stillgrid_host_info& host) {
  const auto negotiate = load_driver(subject);
  stillgrid_device_api api{};
  api.struct_size = sizeof api;
  const std::int32_t code = call_driver("negotiate()", [&] { return negotiate(&host, &api); });
  if (code != STILLGRID_DEVICE_OK)
    broken("negotiate() answers " + code_name(code) + " to a host of version " +
           std::to_string(host.abi));
  if (api.abi != host.abi)
    broken("negotiate() gives a table of version " + std::to_string(api.abi) + ", expected " +
           std::to_string(host.abi));
  if (!device::has_every_function(api)) broken("the table leaves functions out");
  return api;
}

CheckedDevice::CheckedDevice(const Subject& subject, const stillgrid_host_info& host)
    : api_(negotiate_table(subject, host)) {
  open(subject);
}

CheckedDevice::~CheckedDevice() {
  if (handle_ == nullptr) return;
  try {  // motors off, whatever the check found; it has its outcome
    if (is_active_) deactivate();
    close();
  } catch (const CheckEnded&) {
    return;
  }
}

void CheckedDevice::open(const Subject& subject) {
  const std::int32_t count = call_driver("enumerate()", [&] { return api_.enumerate(); });
  if (count == 0) end_check(Verdict::kAbsent, "no device is present");
  require(std::min(count, STILLGRID_DEVICE_OK), "enumerate()");
  if (std::int64_t{subject.index} >= count)
    end_check(Verdict::kAbsent, "no device @" + std::to_string(subject.index) + " is present");
  require(call_driver("open()", [&] { return api_.open(subject.index, &handle_); }), "open()");
  if (handle_ == nullptr) broken("open() answers OK and gives no device");
  for (const device::DeviceOption& option : subject.options)
    require_options_taken(
        call_driver(
            "configure()",
            [&] { return api_.configure(handle_, option.key.c_str(), option.value.c_str()); }),
        "option " + option.key + "=" + option.value);
}

stillgrid_device_descriptor CheckedDevice::describe() {
  stillgrid_device_descriptor descriptor{};
  descriptor.struct_size = sizeof descriptor;
  require_options_taken(
      call_driver("describe()", [&] { return api_.describe(handle_, &descriptor); }), "describe()");
  return descriptor;
}

void CheckedDevice::activate() {
  require_options_taken(call_driver("activate()", [&] { return api_.activate(handle_); }),
                        "activate()");
  is_active_ = true;
}

void CheckedDevice::deactivate() {
  is_active_ = false;
  require(call_driver("deactivate()", [&] { return api_.deactivate(handle_); }), "deactivate()");
}

void CheckedDevice::close() {
  stillgrid_device* const device = handle_;
  handle_ = nullptr;
  is_active_ = false;
  call_driver("close()", [&] { api_.close(device); });
}

std::int32_t CheckedDevice::read(std::uint64_t now_ns, stillgrid_device_state& state) {
  state = {};
  state.struct_size = sizeof state;
  return call_driver("read()", [&] { return api_.read(handle_, now_ns, &state); });
}

std::int32_t CheckedDevice::write(std::uint64_t now_ns, const std::array<double, 3>& force_N) {
  return call_driver(
      "write()", [&] { return api_.write(handle_, now_ns, force_N.data(), kNoTorque_N_m.data()); });
}

void CheckedDevice::require(std::int32_t code, const std::string& step) const {
  if (code == STILLGRID_DEVICE_OK || code == STILLGRID_DEVICE_END) return;
  const char* const text = call_driver("strerror()", [&] { return api_.strerror(handle_, code); });
  const std::string reason = text == nullptr ? "" : text;
  if (code == STILLGRID_DEVICE_E_NO_DEVICE)
    end_check(Verdict::kAbsent, "no device: " + step + ": " + reason);
  broken(step + " answers " + code_name(code) + ": " + reason);
}

void CheckedDevice::require_options_taken(std::int32_t code, const std::string& step) const {
  if (code != STILLGRID_DEVICE_E_ARGUMENT) return require(code, step);
  const char* const reason =
      call_driver("strerror()", [&] { return api_.strerror(handle_, code); });
  end_check(Verdict::kRefused, step + ": " + (reason == nullptr ? "" : reason));
}

void run_ticks(std::size_t ticks, const std::function<bool(std::uint64_t now_ns)>& work) {
  std::exception_ptr thrown;
  std::thread([&] {
    is_realtime_thread = true;
    try {
      realtime::RealtimeSection section;
      realtime::PeriodicTimer timer(kPeriod_ns);
      for (std::size_t tick = 1; tick <= ticks; ++tick) {
        section.begin_tick(tick);
        if (!work(timer.wait().now_ns)) break;
      }
    } catch (...) {
      thrown = std::current_exception();
    }
  }).join();
  if (thrown) std::rethrow_exception(thrown);
}

void read_ticks(CheckedDevice& device, std::size_t ticks) {
  stillgrid_device_state state{};
  run_ticks(ticks, [&](std::uint64_t now_ns) {
    const std::int32_t code = device.read(now_ns, state);
    device.require(code, "read()");
    if (code == STILLGRID_DEVICE_END) return false;
    device.require(device.write(now_ns, {}), "write()");
    return true;
  });
}

}  // namespace stillgrid::device_check
