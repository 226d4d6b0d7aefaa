#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

#include "proto/device_plugin.h"
#include "tests/integration/faults/call_log.hpp"

// A device that is held at a place, keeps a log of what it is told, and breaks where the option
// fault= names once the test asks for it in that log.
namespace {

using stillgrid::integration::Call;

constexpr auto kHang = std::chrono::milliseconds(400);
constexpr auto kForEver = std::chrono::hours(1);  // for a test
constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

struct Driver {
  stillgrid::integration::CallLog log;
  std::string fault, error = "no error";
  // Where it is held, and where the fault "moves" takes it.
  std::map<std::string, double, std::less<>> number = {{"z_m", 0.003},
                                                       {"to_x_m", 0.0},
                                                       {"to_z_m", 0.003},
                                                       {"speed_m_s", 0.0},
                                                       {"for_s", 0.0},
                                                       {"workspace_m", 0.0},
                                                       {"no_motors", 0},
                                                       {"stiffness_N_per_m", 0},
                                                       {"continuous_force_N", 0},
                                                       {"motor_time_constant_s", 0},
                                                       {"max_speed_m_s", 0}};
  std::atomic<bool> is_stopped = false;
  bool is_active = false, is_broken = false;
  std::uint64_t began_ns = kNever, hung_ns = 0, reads = 0;
  unsigned hangs = 0;
  bool has_ended = false;
};

Driver driver;

std::int32_t fail(std::int32_t code, const char* line) {
  driver.error = line;
  return code;
}

/// Whether the fault is on in this tick.
bool is_on(std::uint64_t now_ns) {
  if (driver.began_ns == kNever && driver.log.is_triggered()) {
    driver.began_ns = now_ns;
    driver.log.add(Call::kFaultBegins);
  }
  if (driver.began_ns == kNever || driver.has_ended) return false;
  const double for_s = driver.number["for_s"];
  if (for_s == 0.0 || 1e-9 * static_cast<double>(now_ns - driver.began_ns) < for_s) return true;
  driver.has_ended = true;
  driver.log.add(Call::kFaultEnds);
  return false;
}

void hang(std::chrono::milliseconds duration) {
  ++driver.hangs;
  std::this_thread::sleep_for(duration);
  driver.hung_ns = stillgrid::integration::clock_ns();
}

/// As a hang, but never off the processor.
void spin(std::chrono::milliseconds duration) {
  ++driver.hangs;
  const auto end = std::chrono::steady_clock::now() + duration;
  while (std::chrono::steady_clock::now() < end) {
  }
}

/// On the straight way from where it is held to the end of the move.
void move(std::uint64_t now_ns, double* position_m) {
  const double x_m = driver.number["to_x_m"];
  const double z_m = driver.number["to_z_m"] - position_m[2];
  const double way_m = std::hypot(x_m, z_m);
  const double gone_s = 1e-9 * static_cast<double>(now_ns - driver.began_ns);
  const double share = std::min(1.0, driver.number["speed_m_s"] * gone_s / way_m);
  position_m[0] += share * x_m;
  position_m[2] += share * z_m;
}

/// What is wrong with a position or a stamp.
void spoil(std::uint64_t now_ns, stillgrid_device_state& state) {
  const std::string_view fault = driver.fault;
  if (fault == "position_nan") state.position_m[1] = std::numeric_limits<double>::quiet_NaN();
  if (fault == "position_infinite") state.position_m[2] = -std::numeric_limits<double>::infinity();
  if (fault == "position_huge") state.position_m[2] = -1e9;
  if (fault == "position_missing") state.valid = 0;
  if (fault == "orientation_nan")
    state.orientation_xyzw[0] = std::numeric_limits<double>::quiet_NaN();
  if (fault == "leaps") state.position_m[2] -= 1.0;
  if (fault == "flickers") state.position_m[2] += driver.reads % 2 == 0 ? 1e-3 : -1e-3;
  if (fault == "stamps_back") state.time_ns = 2 * driver.began_ns - now_ns;
  if (fault == "stamps_frozen") state.time_ns = driver.began_ns;
  if (fault == "stamps_ahead") state.time_ns = now_ns + 1'000'000'000;
  if (fault == "sequence_frozen") state.sequence = 1;
  if (fault == "motors_off" || fault == "gets_hot") {
    state.status_known = STILLGRID_STATUS_MOTORS_ON | STILLGRID_STATUS_HOT;
    state.status = fault == "gets_hot" ? state.status_known : 0U;
  }
  if (fault == "moves") move(now_ns, state.position_m);
}

/// How the fault that the option names for a call shows: "_hangs"; empty where there is none.
/// Several are joined by '+'.
std::string_view fault_of(std::string_view call) {
  std::string_view rest = driver.fault;
  while (!rest.empty()) {
    const std::string_view fault = rest.substr(0, rest.find('+'));
    rest.remove_prefix(std::min(fault.size() + 1, rest.size()));
    if (fault.substr(0, call.size()) == call) return fault.substr(call.size());
  }
  return {};
}

/// Ends the program by the driver's own hand, if it is to.
void leave(std::string_view how) {
  if (how == "_exits") std::exit(0);
  if (how == "_exits_at_once") ::_exit(0);
  if (how == "_ends_its_thread") ::pthread_exit(nullptr);
  if (how == "_aborts") std::abort();
  if (how == "_forks" && ::fork() > 0) ::_exit(0);  // the child goes on with the loop
  if (how == "_takes_signals")
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) std::signal(number, [](int) {});
  if (how == "_crashes") *static_cast<volatile int*>(nullptr) = 0;
}

/// What is wrong with a call.
std::int32_t misbehave(std::string_view call, stillgrid_device_state* state = nullptr) {
  if (driver.fault == "oversteps" && state != nullptr) std::memset(state + 1, 0x5A, 16);
  const std::string_view how = fault_of(call);
  leave(how);
  if (how == "_fails") return fail(STILLGRID_DEVICE_E_IO, "the cable is out");
  if (how == "_ends") return fail(STILLGRID_DEVICE_END, "the recording has come to its end");
  if (how == "_throws") throw std::runtime_error("a driver's own");
  if (how == "_slow") std::this_thread::sleep_for(std::chrono::milliseconds(5));
  if (how == "_hangs_for_ever") hang(kForEver);
  if (how == "_spins" && driver.hangs == 0) spin(kHang);
  if ((how == "_hangs" || how == "_hangs_and_dies") && driver.hangs == 0) hang(kHang);
  if (how == "_hangs_and_dies") driver.is_broken = true;
  if (how == "_hangs_again" && stillgrid::integration::clock_ns() > driver.hung_ns + 300'000'000)
    hang(kHang);
  return STILLGRID_DEVICE_OK;
}

std::int32_t enumerate() {
  return 1;
}
std::int32_t open_device(std::uint32_t /*index*/, stillgrid_device** out) {
  if (const char* const fault = std::getenv("FAULT_BEFORE_OPTIONS")) driver.fault = fault;
  if (const std::int32_t code = misbehave("open"); code != STILLGRID_DEVICE_OK) return code;
  *out = reinterpret_cast<stillgrid_device*>(&driver);
  return STILLGRID_DEVICE_OK;
}
std::int32_t configure(stillgrid_device* /*device*/, const char* key, const char* value) {
  try {
    if (std::string_view(key) == "log") {
      driver.log.open(value);
    } else if (std::string_view(key) == "fault") {
      driver.fault = value;
    } else {
      driver.number.at(key) = std::stod(value);
    }
  } catch (const std::exception& refusal) {
    return fail(STILLGRID_DEVICE_E_ARGUMENT, refusal.what());
  }
  return STILLGRID_DEVICE_OK;
}
std::int32_t describe(stillgrid_device* /*device*/, stillgrid_device_descriptor* out) {
  std::strncpy(out->name, "faulty", sizeof out->name - 1);
  if (driver.number["no_motors"] != 0.0) out->flags = STILLGRID_DEVICE_NO_MOTORS;
  out->max_force_N = 3.3;
  out->continuous_force_N = driver.number["continuous_force_N"];
  out->motor_time_constant_s = driver.number["motor_time_constant_s"];
  out->nominal_stiffness_N_per_m = driver.number["stiffness_N_per_m"];
  out->max_speed_m_s = driver.number["max_speed_m_s"];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out->workspace_min_m[axis] = -driver.number["workspace_m"];
    out->workspace_max_m[axis] = driver.number["workspace_m"];
  }
  return STILLGRID_DEVICE_OK;
}
std::int32_t activate(stillgrid_device* /*device*/) {
  if (driver.is_active) return fail(STILLGRID_DEVICE_E_ORDER, "active already");
  if (driver.is_broken) return fail(STILLGRID_DEVICE_E_IO, "the device is gone");
  if (const std::int32_t code = misbehave("activate"); code != STILLGRID_DEVICE_OK) return code;
  driver.log.add(Call::kActivate);
  driver.is_stopped = false;
  driver.is_active = true;
  return STILLGRID_DEVICE_OK;
}
std::int32_t read(stillgrid_device* /*device*/, std::uint64_t now_ns, stillgrid_device_state* out) {
  ++driver.reads;
  out->valid = STILLGRID_STATE_POSITION | STILLGRID_STATE_ORIENTATION;
  out->time_ns = now_ns;
  out->sequence = driver.reads;
  out->position_m[2] = driver.number["z_m"];
  out->orientation_xyzw[3] = 1.0;
  const bool on = is_on(now_ns);
  if (on) spoil(now_ns, *out);
  return on ? misbehave("read", out) : STILLGRID_DEVICE_OK;
}
std::int32_t write(stillgrid_device* /*device*/, std::uint64_t now_ns, const double* force_N,
                   const double* /*torque_N_m*/) {
  driver.log.add(driver.is_stopped ? Call::kIgnoredWrite : Call::kWrite, now_ns, force_N);
  return is_on(now_ns) ? misbehave("write") : STILLGRID_DEVICE_OK;
}
std::int32_t deactivate(stillgrid_device* /*device*/) {
  if (!driver.is_active) return fail(STILLGRID_DEVICE_E_ORDER, "not active");
  if (const std::int32_t code = misbehave("deactivate"); code != STILLGRID_DEVICE_OK) return code;
  driver.log.add(Call::kDeactivate);
  driver.is_active = false;
  return STILLGRID_DEVICE_OK;
}
void close_device(stillgrid_device* /*device*/) {
  misbehave("close");
  if (driver.is_active) driver.log.add(Call::kDeactivate);
  driver.is_active = false;
}
void emergency_stop(stillgrid_device* /*device*/) {
  misbehave("emergency_stop");
  driver.is_stopped = true;
  driver.log.add(Call::kEmergencyStop);
}
const char* strerror(stillgrid_device* /*device*/, std::int32_t /*code*/) {
  return driver.error.c_str();
}

}  // namespace

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* /*host*/,
                                                   stillgrid_device_api* out) {
  *out = {sizeof *out,  STILLGRID_DEVICE_ABI,
          enumerate,    open_device,
          configure,    describe,
          activate,     read,
          write,        deactivate,
          close_device, emergency_stop,
          strerror,     nullptr,
          nullptr,      nullptr,
          nullptr,      nullptr};
  return STILLGRID_DEVICE_OK;
}
