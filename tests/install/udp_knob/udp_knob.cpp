// A device at the far end of a UDP socket, for Stillgrid: a knob, a phone, a board on the desk.
// C++20.
//
// It sends "x_m y_m z_m" as text to 127.0.0.1:PORT, some hundred times a second or more, and is
// answered each time with the force: "fx_N fy_N fz_N". A thread of the driver's own does that; the
// real-time calls exchange the newest values with it and enter the kernel never. A driver of a USB
// device is made the same way.
#include <arpa/inet.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <stillgrid/device_plugin.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

namespace {

constexpr double kMaxForce_N = 2.0;
// Longer, and the device has gone. The server's own force fades when samples are 100 ms old.
constexpr std::uint64_t kSilence_ns = 500'000'000;
// No turn of the driver's thread counts for more silence: after a stall there is mail to be read.
constexpr std::uint64_t kLongestTurn_ns = 20'000'000;
// A force that was written longer ago is not told: the loop hangs.
constexpr std::uint64_t kForceHolds_ns = 50'000'000;
constexpr int kPriority = 70;  // below the haptic loop's 80, above all that is ordinary

using Vector = std::array<double, 3>;

/// What one thread says and another hears, newest only, without a lock: three places, of which each
/// has one and the third goes to and fro.
template <class Value>
class Latest {
 public:
  void say(const Value& value) noexcept {
    places_[mine_] = value;
    mine_ = between_.exchange(mine_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }
  [[nodiscard]] const Value& hear() noexcept {
    if ((between_.load(std::memory_order_relaxed) & kFresh) != 0)
      heard_ = between_.exchange(heard_, std::memory_order_acq_rel) & kIndex;
    return places_[heard_];
  }

 private:
  static constexpr unsigned kIndex = 3, kFresh = 4;
  std::array<Value, 3> places_{};
  unsigned mine_ = 0, heard_ = 1;
  std::atomic<unsigned> between_ = 2;
};

/// What the host is told instead of an exception: a code, and a line for strerror().
class Refusal : public std::runtime_error {
 public:
  Refusal(std::int32_t code, const std::string& line) : std::runtime_error(line), code_(code) {}
  [[nodiscard]] std::int32_t code() const noexcept { return code_; }

 private:
  std::int32_t code_;
};

std::uint64_t monotonic_ns() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();  // CLOCK_MONOTONIC
  return static_cast<std::uint64_t>(std::chrono::nanoseconds(now).count());
}

class Socket {
 public:
  explicit Socket(std::uint16_t port) : file_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_port = htons(port);
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (file_ >= 0 && bind(file_, reinterpret_cast<sockaddr*>(&here), sizeof here) == 0) return;
    const std::string reason = std::strerror(errno);
    if (file_ >= 0) close(file_);
    throw Refusal(STILLGRID_DEVICE_E_IO, "port " + std::to_string(port) + ": " + reason);
  }
  ~Socket() { close(file_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  /// Whether three numbers came within that time: the newest that wait, for after a stall there are
  /// many. From now on they are answered where they came from.
  [[nodiscard]] bool receive(Vector& position_m, int patience_ms) {
    constexpr int kMax = 1000;  // more than wait in a socket: a flood does not keep us here
    pollfd ready{file_, POLLIN, 0};
    if (poll(&ready, 1, patience_ms) <= 0) return false;
    std::array<char, 256> text;
    bool is_fresh = false;
    for (int packets = 0; packets < kMax; ++packets) {
      socklen_t size = sizeof there_;
      const ssize_t bytes = recvfrom(file_, text.data(), text.size(), MSG_DONTWAIT,
                                     reinterpret_cast<sockaddr*>(&there_), &size);
      if (bytes < 0) break;
      if (Vector numbers; parse({text.data(), static_cast<std::size_t>(bytes)}, numbers)) {
        position_m = numbers;
        is_fresh = true;
      }
    }
    return is_fresh;
  }

  void answer(const Vector& force_N) {
    std::array<char, 128> text;
    const int bytes = std::snprintf(text.data(), text.size(), "%.6g %.6g %.6g\n", force_N[0],
                                    force_N[1], force_N[2]);
    // Nobody there to receive it is found out by silence.
    (void)sendto(file_, text.data(), static_cast<std::size_t>(bytes), 0,
                 reinterpret_cast<const sockaddr*>(&there_), sizeof there_);
  }

 private:
  static bool parse(std::string_view text, Vector& numbers) {
    for (double& number : numbers) {
      text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
      if (error != std::errc() || !std::isfinite(number)) return false;
      text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    }
    return true;
  }

  int file_;
  sockaddr_in there_{};
};

}  // namespace

/// What the interface calls a device: the struct is ours, the host knows its name only.
struct stillgrid_device {
  std::uint16_t port = 0;
  bool is_active = false;
  std::string error = "no error";

  struct Sample {
    std::uint64_t time_ns = 0, number = 0;
    Vector position_m{};
  };
  struct Command {
    std::uint64_t time_ns = 0;
    Vector force_N{};
  };
  Latest<Sample> samples;
  Latest<Command> commands;
  std::atomic<bool> is_stopped = false, is_silent = false;
  std::jthread thread;
};

namespace {

const stillgrid_host_log* host_log = nullptr;
std::uint32_t host_clock = STILLGRID_CLOCK_MONOTONIC;
std::string open_error = "no error";

/// Runs work; what it throws becomes a code and the line of strerror(). Nothing crosses the border.
template <class Work>
std::int32_t guarded(std::string& error, const Work& work) noexcept {
  try {
    work();
    return STILLGRID_DEVICE_OK;
  } catch (const Refusal& refusal) {
    error = refusal.what();
    return refusal.code();
  } catch (const std::exception& fault) {
    error = fault.what();
    return STILLGRID_DEVICE_E_IO;
  }
}

/// Fills in the host's struct. Refuses one of another size than this header's.
template <class Struct>
std::int32_t copy_out(Struct from, Struct* to) noexcept {
  if (to->struct_size != sizeof from) return STILLGRID_DEVICE_E_ARGUMENT;
  from.struct_size = sizeof from;
  *to = from;
  return STILLGRID_DEVICE_OK;
}

/// The driver's own thread: hears the device, answers it, and leaves it without force.
void converse(const std::stop_token& stop, stillgrid_device& device, Socket& socket,
              stillgrid_device::Sample sample) {
  constexpr Vector kNoForce_N{};
  std::uint64_t turn_ns = sample.time_ns, silence_ns = 0;
  while (!stop.stop_requested()) {
    const bool is_fresh = socket.receive(sample.position_m, 2);
    const std::uint64_t now_ns = monotonic_ns();
    silence_ns = is_fresh ? 0 : silence_ns + std::min(now_ns - turn_ns, kLongestTurn_ns);
    turn_ns = now_ns;
    device.is_silent = silence_ns > kSilence_ns;
    if (is_fresh) {
      sample.time_ns = now_ns;
      ++sample.number;
      device.samples.say(sample);
    }
    const stillgrid_device::Command& command = device.commands.hear();
    if (device.is_stopped)
      socket.answer(kNoForce_N);
    else if (is_fresh)
      socket.answer(now_ns <= command.time_ns + kForceHolds_ns ? command.force_N : kNoForce_N);
  }
  socket.answer(kNoForce_N);
}

/// An ordinary thread starves beside the haptic loop on a busy machine.
void raise_priority(std::jthread& thread) {
  sched_param priority{};
  priority.sched_priority = kPriority;
  const int refusal = pthread_setschedparam(thread.native_handle(), SCHED_FIFO, &priority);
  if (refusal != 0 && host_log != nullptr)
    host_log->log(STILLGRID_LOG_WARNING, "its thread is not SCHED_FIFO: raise 'ulimit -r' to 70");
}

std::int32_t enumerate_devices() noexcept {
  return 1;
}

std::int32_t open_device(std::uint32_t index, stillgrid_device** out) noexcept {
  if (out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  *out = nullptr;
  if (index != 0) return STILLGRID_DEVICE_E_NO_DEVICE;
  return guarded(open_error, [out] { *out = std::make_unique<stillgrid_device>().release(); });
}

std::int32_t configure(stillgrid_device* device, const char* key, const char* value) noexcept {
  if (device == nullptr || key == nullptr || value == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (device->is_active) return STILLGRID_DEVICE_E_ORDER;
  return guarded(device->error, [&] {
    const std::string_view text = value;
    const char* const end = text.data() + text.size();
    std::uint16_t port = 0;
    const auto result = std::from_chars(text.data(), end, port);
    const bool is_port = result.ec == std::errc() && result.ptr == end && port > 0;
    if (key != std::string_view("port") || !is_port)
      throw Refusal(STILLGRID_DEVICE_E_ARGUMENT, "expected port=1..65535");
    device->port = port;
  });
}

std::int32_t describe(stillgrid_device* device, stillgrid_device_descriptor* out) noexcept {
  if (device == nullptr || out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  stillgrid_device_descriptor descriptor{};
  std::strcpy(descriptor.name, "udp_knob");
  descriptor.max_force_N = kMaxForce_N;
  descriptor.max_read_ns = 20'000;
  return copy_out(descriptor, out);
}

std::int32_t activate(stillgrid_device* device) noexcept {
  if (device == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (device->is_active) return STILLGRID_DEVICE_E_ORDER;
  return guarded(device->error, [device] {
    if (host_clock == STILLGRID_CLOCK_VIRTUAL)
      throw Refusal(STILLGRID_DEVICE_E_ARGUMENT, "a real device has no place in virtual time");
    if (device->port == 0) throw Refusal(STILLGRID_DEVICE_E_ARGUMENT, "port=1..65535 is required");
    device->is_stopped = false;
    device->is_silent = false;
    device->commands.say({});
    auto socket = std::make_unique<Socket>(device->port);
    stillgrid_device::Sample first;
    if (!socket->receive(first.position_m, 2000))
      throw Refusal(STILLGRID_DEVICE_E_NO_DEVICE,
                    "port " + std::to_string(device->port) + ": nothing came within 2 s");
    first.time_ns = monotonic_ns();
    first.number = 1;
    device->samples.say(first);
    device->thread =
        std::jthread([device, first, socket = std::move(socket)](const std::stop_token& stop) {
          converse(stop, *device, *socket, first);
        });
    device->is_active = true;
    raise_priority(device->thread);
    if (host_log != nullptr) host_log->log(STILLGRID_LOG_INFO, "the device speaks");
  });
}

/// Real-time: no lock, no allocation, no system call; an error here has no line made for it.
std::int32_t read_state(stillgrid_device* device, std::uint64_t /*now_ns*/,
                        stillgrid_device_state* out) noexcept {
  if (device == nullptr || out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (!device->is_active) return STILLGRID_DEVICE_E_ORDER;
  if (device->is_silent) return STILLGRID_DEVICE_E_IO;
  const stillgrid_device::Sample& sample = device->samples.hear();
  stillgrid_device_state state{};
  state.valid = STILLGRID_STATE_POSITION;
  state.time_ns = sample.time_ns;
  state.sequence = sample.number;
  std::copy(sample.position_m.begin(), sample.position_m.end(), state.position_m);
  return copy_out(state, out);
}

std::int32_t write_force(stillgrid_device* device, std::uint64_t now_ns, const double* force_N,
                         const double* /*torque_N_m*/) noexcept {
  if (device == nullptr || force_N == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (!device->is_active) return STILLGRID_DEVICE_E_ORDER;
  stillgrid_device::Command told{now_ns, {}};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::isfinite(force_N[axis]))
      told.force_N[axis] = std::clamp(force_N[axis], -kMaxForce_N, kMaxForce_N);
  device->commands.say(told);
  return STILLGRID_DEVICE_OK;
}

std::int32_t deactivate(stillgrid_device* device) noexcept {
  if (device == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (!device->is_active) return STILLGRID_DEVICE_E_ORDER;
  device->thread = {};  // ends it: its last word is zero force
  device->is_active = false;
  return STILLGRID_DEVICE_OK;
}

void close_device(stillgrid_device* device) noexcept {
  delete device;  // ends the thread too, if it still runs
}

/// From any thread: the driver's own sees it within 2 ms.
void emergency_stop(stillgrid_device* device) noexcept {
  if (device != nullptr) device->is_stopped = true;
}

const char* error_line(stillgrid_device* device, std::int32_t code) noexcept {
  switch (code) {
    case STILLGRID_DEVICE_OK:
      return "done";
    case STILLGRID_DEVICE_E_ORDER:
      return "call not allowed in this state of life";
    case STILLGRID_DEVICE_E_IO:
      if (device != nullptr && device->is_active) return "nothing came for 500 ms";
      [[fallthrough]];
    default:
      return device == nullptr ? open_error.c_str() : device->error.c_str();
  }
}

std::int32_t identify(stillgrid_device* device, stillgrid_device_identity* out) noexcept {
  if (device == nullptr || out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  stillgrid_device_identity identity{};
  std::snprintf(identity.serial, sizeof identity.serial, "127.0.0.1:%u", device->port);
  std::strcpy(identity.driver, "udp_knob 1.0");
  return copy_out(identity, out);
}

const void* get_extension(const char* name) noexcept {
  static constexpr stillgrid_device_identity_api kIdentity{sizeof kIdentity, 0, identify};
  if (name == nullptr || name != std::string_view(STILLGRID_DEVICE_IDENTITY)) return nullptr;
  return &kIdentity;
}

}  // namespace

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  if (host == nullptr || out == nullptr) return STILLGRID_DEVICE_E_ARGUMENT;
  if (host->abi != STILLGRID_DEVICE_ABI) return STILLGRID_DEVICE_E_VERSION;
  if (host->struct_size != sizeof *host) return STILLGRID_DEVICE_E_ARGUMENT;
  host_clock = host->clock;
  host_log = nullptr;
  if (host->get_extension != nullptr)
    host_log = static_cast<const stillgrid_host_log*>(host->get_extension(STILLGRID_HOST_LOG));
  stillgrid_device_api api{};
  api.abi = STILLGRID_DEVICE_ABI;
  api.enumerate = enumerate_devices;
  api.open = open_device;
  api.configure = configure;
  api.describe = describe;
  api.activate = activate;
  api.read = read_state;
  api.write = write_force;
  api.deactivate = deactivate;
  api.close = close_device;
  api.emergency_stop = emergency_stop;
  api.strerror = error_line;
  api.get_extension = get_extension;
  return copy_out(api, out);
}
