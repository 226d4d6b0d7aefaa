#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cfenv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "proto/device_plugin.h"

// A driver that keeps every rule but the one that $STILLGRID_HOSTILE_FAULT names. Without it, a
// pattern of how little keeping them takes.
namespace {

const char* const fault = std::getenv("STILLGRID_HOSTILE_FAULT");

bool is(const char* name) {
  return fault != nullptr && std::strcmp(fault, name) == 0;
}

[[noreturn]] void crash() {
  std::abort();
}

[[noreturn]] void hang() {
  while (true) std::this_thread::sleep_for(std::chrono::seconds(1));
}

/// Out of the order in which compilers might see it coming.
void touch(const void* memory) {
  asm volatile("" : : "r"(memory) : "memory");
}

struct Device {
  bool is_active = false;
  bool was_active = false;
  std::atomic<bool> is_stopped = false;
  bool stopped_and_left = false;
  std::uint64_t sequence = 0;
  double force_N = 0.0;
  std::thread::id opener;
  int file = -1;
  std::mutex mutex;
  std::unique_ptr<std::array<char, 64>> memory;
  stillgrid_device_tick_fn tick = nullptr;
  void* tick_context = nullptr;
  std::atomic<bool> is_ending = false;
  std::thread ticking, ticking_too;
};

Device device;
const stillgrid_host_log* host_log = nullptr;

Device* of(stillgrid_device* handle) {
  if (handle == nullptr && is("null_device")) crash();
  return reinterpret_cast<Device*>(handle);
}

/// Runs at the end of the program.
struct AtExit {
  ~AtExit() {
    if (is("exit_crash")) crash();
    if (is("exit_hang")) hang();
  }
} at_exit;

std::int32_t enumerate() {
  if (is("nothing_there") || (is("gone") && device.was_active)) return 0;
  return is("enumerate_fails") ? STILLGRID_DEVICE_E_IO : 1;
}

std::int32_t open_device(std::uint32_t index, stillgrid_device** out) {
  if (out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (index != 0 && !is("any_index")) return STILLGRID_DEVICE_E_NO_DEVICE;
  if (is("open_throws")) throw std::runtime_error("no luck");
  if (is("opens_once") && device.was_active) return STILLGRID_DEVICE_E_IO;
  device.is_stopped = false;
  device.opener = std::this_thread::get_id();
  *out = reinterpret_cast<stillgrid_device*>(&device);
  return STILLGRID_DEVICE_OK;
}

std::int32_t configure(stillgrid_device* handle, const char* key, const char* value) {
  Device* const self = of(handle);
  if (self == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (self->is_active && is("configure_active")) return STILLGRID_DEVICE_OK;
  if (self->is_active) return STILLGRID_DEVICE_E_ORDER;
  if (is("null_key") && key == nullptr) crash();
  if (key == nullptr || value == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (is("unlucky_order") && self->stopped_and_left) crash();
  if (is("unknown_key_throws")) throw std::invalid_argument(key);
  return is("unknown_key") ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ARGUMENT;
}

/// Writes what fits into the host's struct, or what would in a world without hosts.
template <class Struct>
std::int32_t hand_over(Struct& from, Struct* to, const char* overrun, const char* resize) {
  if (to == nullptr || (to->struct_size != sizeof from && !is(overrun)))
    return STILLGRID_DEVICE_E_ARGUMENT;
  from.struct_size = is(resize) ? 0 : sizeof from;
  *to = from;
  return STILLGRID_DEVICE_OK;
}

std::int32_t describe(stillgrid_device* handle, stillgrid_device_descriptor* out) {
  if (of(handle) == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  stillgrid_device_descriptor descriptor{};
  std::strncpy(descriptor.name, "hostile", sizeof descriptor.name - 1);
  if (is("endless_name")) std::memset(descriptor.name, 'x', sizeof descriptor.name);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    descriptor.workspace_min_m[axis] = is("inside_out") ? 0.2 : -0.1;
    descriptor.workspace_max_m[axis] = is("leaves_workspace") ? -0.01 : 0.1;
  }
  descriptor.workspace_min_m[1] = descriptor.workspace_max_m[1] = -0.2;  // equal: no edge
  descriptor.max_force_N = is("nan_force") ? std::nan("") : 3.0;
  descriptor.continuous_force_N = is("weak_for_a_moment") ? 5.0 : 1.0;
  descriptor.rate_hz =
      is("drifting_rate") && handle != nullptr && device.was_active ? 999.0 : 1000.0;
  descriptor.max_read_ns = is("no_max_read") ? 0 : 300'000;
  descriptor.flags = is("declared_system_call") || is("declared_allocation") || is("masks_signals")
                         ? STILLGRID_DEVICE_USES_SYSCALLS
                         : 0;
  if (!is("masks_signals"))
    descriptor.flags |= STILLGRID_DEVICE_SETS_PACE;  // its threads' are its own
  descriptor.dof_sensed = is("freedom_of_ghosts") ? 1024U : 127U;
  if (is("no_gripper")) descriptor.dof_sensed = 63U;
  descriptor.dof_actuated = 71U;
  descriptor.axis_count = is("many_axes") ? 5 : 2;
  descriptor.gripper_open_m = 0.03;
  descriptor.max_gripper_force_N = 2.0;
  return hand_over(descriptor, out, "descriptor_overrun", "descriptor_resized");
}

void tick_until_told(Device& self) {
  const auto period = std::chrono::milliseconds(is("ticks_seldom") ? 10 : 1);
  bool goes_on = true;
  for (auto next = std::chrono::steady_clock::now(); !self.is_ending && goes_on;) {
    std::this_thread::sleep_until(next += period);
    goes_on = self.tick(self.tick_context) == 0 || is("ticks_on");
  }
}

void begin_ticks(Device& self) {
  self.is_ending = false;
  if (self.tick == nullptr || is("no_ticks")) return;
  self.ticking = std::thread(tick_until_told, std::ref(self));
  if (is("ticks_twice")) self.ticking_too = std::thread(tick_until_told, std::ref(self));
}

void end_ticks(Device& self) {
  self.is_ending = true;
  for (std::thread* const thread : {&self.ticking, &self.ticking_too})
    if (thread->joinable()) thread->join();
}

std::int32_t activate(stillgrid_device* handle) {
  Device* const self = of(handle);
  if (self == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (self->is_active && !is("activates_twice")) return STILLGRID_DEVICE_E_ORDER;
  if (is("activate_hangs")) hang();
  if (is("opens_umask")) ::umask(0);
  if (is("leaves_folder") && ::chdir("/") != 0) crash();
  if (is("unplugged")) return STILLGRID_DEVICE_E_NO_DEVICE;
  if (is("activates_once") && self->was_active) return STILLGRID_DEVICE_E_IO;
  if (is("stop_stays") && self->is_stopped) return STILLGRID_DEVICE_E_IO;
  if (self->file < 0) self->file = open("/dev/null", O_WRONLY | O_CLOEXEC);
  self->is_active = true;
  self->was_active = true;
  self->is_stopped = false;
  begin_ticks(*self);
  return STILLGRID_DEVICE_OK;
}

void busy_for(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

void disturb_realtime(Device& self) {
  if (is("read_throws")) throw std::runtime_error("read");
  if (is("read_hangs")) hang();
  if (is("read_crashes")) touch(*static_cast<const char* const volatile*>(nullptr));
  if (is("allocates") || is("declared_allocation"))
    self.memory = std::make_unique<std::array<char, 64>>();
  if (is("locks")) const std::lock_guard one_at_a_time(self.mutex);
  const bool asks_kernel = is("system_call") || is("declared_system_call");
  if (asks_kernel && ::write(self.file, "x", 1) != 1) crash();
  if (is("rounds_up")) std::fesetround(FE_UPWARD);
  if (is("masks_signals")) {
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
  }
  if (is("slow")) busy_for(std::chrono::microseconds(700));
  if (is("throws_inside")) {
    try {
      throw std::runtime_error("kept in");
    } catch (const std::runtime_error& kept) {
      touch(&kept);
    }
  }
  if (is("logs_in_realtime") && host_log != nullptr) host_log->log(STILLGRID_LOG_INFO, "a tick");
}

void fill_in(Device& self, std::uint64_t now_ns, stillgrid_device_state& state) {
  const std::uint64_t n = ++self.sequence;
  state.valid = is("nothing_valid") ? 0 : STILLGRID_STATE_POSITION | STILLGRID_STATE_ORIENTATION;
  state.time_ns = now_ns;
  if (is("time_back") && n % 16 == 15) state.time_ns -= 5'000'000;
  if (is("time_zero")) state.time_ns = 0;
  if (is("time_ahead")) state.time_ns += 1'000'000'000;
  state.sequence = is("sequence_stays") ? 1 : n;
  if (is("sequence_back") && n % 16 == 15) state.sequence -= 2;
  if (is("sequence_lies") && n % 16 == 15) state.sequence -= 1;
  state.position_m[0] = 1e-5 * static_cast<double>(n % 100);
  if (is("sequence_stays")) state.position_m[0] = 0.0;
  if (is("millimetres")) state.position_m[0] = 50.0 + 1e-2 * static_cast<double>(n % 100);
  if (is("slips") && n % 16 == 15) state.position_m[1] = 0.09;
  if (is("nan_position") && n % 16 == 15) state.position_m[1] = std::nan("");
  state.valid |= STILLGRID_STATE_AXES | STILLGRID_STATE_GRIPPER;
  if (is("nothing_valid")) state.valid = 0;
  state.axes[1] = is("long_axis") ? 1.5 : -1.0;
  state.gripper_m = is("nan_gripper") ? std::nan("") : 0.02;
  state.orientation_xyzw[3] = is("long_quaternion") ? 1.5 : 1.0;
}

std::int32_t read_state(stillgrid_device* handle, std::uint64_t now_ns,
                        stillgrid_device_state* out) {
  Device* const self = of(handle);
  if (self == nullptr || out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  const bool is_forgiven =
      (is("reads_early") && !self->was_active) || (is("reads_late") && self->was_active);
  if (!self->is_active && !is_forgiven) return STILLGRID_DEVICE_E_ORDER;
  disturb_realtime(*self);
  stillgrid_device_state state{};
  fill_in(*self, now_ns, state);
  if (is("poisoned_by_force")) state.position_m[2] = 0.0 * self->force_N;
  return hand_over(state, out, "state_overrun", "state_resized");
}

std::int32_t write_force(stillgrid_device* handle, std::uint64_t /*now_ns*/, const double* force_N,
                         const double* /*torque_N_m*/) {
  Device* const self = of(handle);
  if (self == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (force_N == nullptr && !is("null_force")) return STILLGRID_DEVICE_E_ARGUMENT;
  if (!self->is_active) {
    const bool is_forgiven = is("writes_late") && self->was_active;
    return is_forgiven ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ORDER;
  }
  if (is("write_throws")) throw 7;
  if (is("huge_force") && std::abs(force_N[0]) > 1e200) crash();
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isfinite(force_N[axis])) self->force_N = force_N[axis];
  return STILLGRID_DEVICE_OK;
}

std::int32_t deactivate(stillgrid_device* handle) {
  Device* const self = of(handle);
  if (self == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  const bool is_forgiven = is(self->was_active ? "leaves_twice" : "leaves_early");
  if (!self->is_active && !is_forgiven) return STILLGRID_DEVICE_E_ORDER;
  if (is("leave_throws")) throw std::runtime_error("deactivate");
  if (is("leave_fails")) return STILLGRID_DEVICE_E_IO;
  end_ticks(*self);
  self->is_active = false;
  self->stopped_and_left = self->is_stopped;
  return STILLGRID_DEVICE_OK;
}

void close_device(stillgrid_device* handle) {
  Device* const self = of(handle);
  if (self == nullptr) return;
  if (is("close_crash")) crash();
  if (is("close_active") && self->is_active) crash();
  if (is("thread_left")) std::thread(hang).detach();
  end_ticks(*self);
  self->tick = nullptr;
  if (self->file >= 0 && !is("file_left")) ::close(self->file);
  self->file = -1;
  self->is_active = false;
  self->stopped_and_left = false;
}

void emergency_stop(stillgrid_device* handle) {
  Device* const self = of(handle);
  if (self == nullptr) return;
  if (is("stop_throws")) throw std::runtime_error("stop");
  if (is("stop_of_one_thread") && std::this_thread::get_id() != self->opener) crash();
  self->is_stopped = true;
}

const char* strerror(stillgrid_device* /*device*/, std::int32_t code) {
  if (is("speechless") && (code > 0 || code < -6)) return nullptr;
  return is("talkative") ? "one line\nand another" : "it did not work";
}

std::int32_t identify(stillgrid_device* handle, stillgrid_device_identity* out) {
  if (of(handle) == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  stillgrid_device_identity identity{};
  std::strncpy(identity.driver, "hostile 1", sizeof identity.driver - 1);
  if (is("endless_serial")) std::memset(identity.serial, '7', sizeof identity.serial);
  return hand_over(identity, out, "identity_overrun", "identity_resized");
}

const void* get_extension(const char* name) {
  static const stillgrid_device_identity_api identity{sizeof identity, 0, identify};
  const bool is_known = is("knows_all") || std::string_view(name) == STILLGRID_DEVICE_IDENTITY;
  return is_known ? &identity : nullptr;
}

std::int32_t set_tick(stillgrid_device* handle, stillgrid_device_tick_fn tick, void* context) {
  Device* const self = of(handle);
  if (self == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (self->is_active) return is("late_tick") ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ORDER;
  if (is("keeps_tick") && tick == nullptr) return STILLGRID_DEVICE_OK;
  self->tick = tick;
  self->tick_context = context;
  return STILLGRID_DEVICE_OK;
}

std::int32_t list(stillgrid_device* handle, std::uint32_t index, stillgrid_device_listing* out) {
  if (of(handle) == nullptr || out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (index > 1 && !is("endless_list")) return STILLGRID_DEVICE_E_NO_DEVICE;
  stillgrid_device_listing listing{};
  std::strncpy(listing.name, "hostile", sizeof listing.name - 1);
  listing.serial[0] = static_cast<char>('0' + index);
  const char* const options = is("options_of_no_use") ? "serial" : "serial=0";
  std::strncpy(listing.options, options, sizeof listing.options - 1);
  if (listing.options[7] == '0' && !is("same_options"))
    listing.options[7] = static_cast<char>('0' + index);
  if (is("endless_serial_listed")) std::memset(listing.serial, '7', sizeof listing.serial);
  return hand_over(listing, out, "listing_overrun", "listing_resized");
}

std::int32_t command(stillgrid_device* handle, const char* key, const char* value) {
  Device* const self = of(handle);
  if (self == nullptr || ((key == nullptr || value == nullptr) && !is("null_order")))
    return STILLGRID_DEVICE_E_ARGUMENT;
  if (!self->is_active) return is("orders_early") ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ORDER;
  if (is("null_order") && (key == nullptr || value == nullptr)) crash();
  return is("any_order") ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_ARGUMENT;
}

std::int32_t write_gripper(stillgrid_device* handle, std::uint64_t /*now_ns*/, double force_N) {
  Device* const self = of(handle);
  if (self == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (!self->is_active && !is("grips_late")) return STILLGRID_DEVICE_E_ORDER;
  return std::isfinite(force_N) || is("grips_nan") ? STILLGRID_DEVICE_OK
                                                   : STILLGRID_DEVICE_E_ARGUMENT;
}

/// Finds the host's log, from a host that has extensions.
void find_log(const stillgrid_host_info& host) {
  host_log = nullptr;
  if (host.get_extension == nullptr) {
    if (is("needs_log")) crash();
    return;
  }
  host_log = static_cast<const stillgrid_host_log*>(host.get_extension(STILLGRID_HOST_LOG));
}

}  // namespace

#ifdef HOSTILE_EXTRA_SYMBOL
extern "C" [[gnu::visibility("default")]] int hostile_helper();
int hostile_helper() {
  return 1;
}
#endif

#ifdef HOSTILE_UNDEFINED
extern "C" int stillgrid_nowhere();
#endif

#ifdef HOSTILE_NAMELESS
#define stillgrid_device_negotiate hostile_negotiate
extern "C" std::int32_t hostile_negotiate(const stillgrid_host_info*, stillgrid_device_api*);
#endif

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
#ifdef HOSTILE_UNDEFINED
  if (host == nullptr) return stillgrid_nowhere();
#endif
  if (is("null_host") && host == nullptr) crash();
  if (host == nullptr || out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (is("refuses_all")) return STILLGRID_DEVICE_E_VERSION;
  if (host->abi != STILLGRID_DEVICE_ABI && !is("takes_any_version"))
    return STILLGRID_DEVICE_E_VERSION;
  if (out->struct_size != sizeof *out && !is("table_overrun")) return STILLGRID_DEVICE_E_ARGUMENT;
  if (host->struct_size != sizeof *host && !is("host_overread")) return STILLGRID_DEVICE_E_ARGUMENT;
  find_log(*host);
  stillgrid_device_api api{sizeof api,   is("wrong_version") ? 7U : STILLGRID_DEVICE_ABI,
                           enumerate,    open_device,
                           configure,    describe,
                           activate,     read_state,
                           write_force,  deactivate,
                           close_device, emergency_stop,
                           strerror,     get_extension,
                           set_tick,     list,
                           command,      write_gripper};
  if (is("no_set_tick")) api.set_tick = nullptr;
  if (is("no_stop")) api.emergency_stop = nullptr;
  if (is("table_resized")) api.struct_size = 0;
  *out = api;
  return STILLGRID_DEVICE_OK;
}
