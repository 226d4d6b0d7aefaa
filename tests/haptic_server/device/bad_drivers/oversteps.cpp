#include <array>
#include <cstdint>
#include <cstring>

#include "proto/device_plugin.h"

// A driver that takes every struct of the host's for a longer one where the option past= names the
// call (describe, identify, read), and lies about the size. Its strings end nowhere and hold what
// no line may. It tells the host's log what became of it.
namespace {

std::array<char, 16> past{};
const stillgrid_host_log* host_log = nullptr;

bool oversteps(const char* call) {
  return std::strcmp(past.data(), call) == 0;
}

template <class Struct>
void finish(Struct* out, const char* call) {
  out->struct_size = 1U << 20U;
  if (oversteps(call)) std::memset(out + 1, 0x5A, 16);
}

std::int32_t enumerate() {
  return 1;
}
std::int32_t open(std::uint32_t /*index*/, stillgrid_device** out) {
  past = {};
  *out = reinterpret_cast<stillgrid_device*>(&past);
  return STILLGRID_DEVICE_OK;
}
std::int32_t configure(stillgrid_device* /*device*/, const char* /*key*/, const char* value) {
  std::strncpy(past.data(), value, past.size() - 1);
  return STILLGRID_DEVICE_OK;
}
std::int32_t describe(stillgrid_device* /*device*/, stillgrid_device_descriptor* out) {
  std::memset(out->name, 'x', sizeof out->name);
  std::memcpy(out->name, "two\nlines", 9);
  finish(out, "describe");
  return STILLGRID_DEVICE_OK;
}
std::int32_t identify(stillgrid_device* /*device*/, stillgrid_device_identity* out) {
  std::memset(out->serial, 0xC3, sizeof out->serial);  // begins a character that never comes
  std::strncpy(out->firmware, "M\xC3\xBChle \xE2\x82\xAC\t7", sizeof out->firmware);
  finish(out, "identify");
  return STILLGRID_DEVICE_OK;
}
std::int32_t activate(stillgrid_device* /*device*/) {
  if (host_log != nullptr) host_log->log(STILLGRID_LOG_WARNING, "motors\non");
  return STILLGRID_DEVICE_OK;
}
std::int32_t read(stillgrid_device* /*device*/, std::uint64_t now_ns, stillgrid_device_state* out) {
  out->valid = STILLGRID_STATE_POSITION;
  out->time_ns = now_ns;
  finish(out, "read");
  return STILLGRID_DEVICE_OK;
}
std::int32_t write(stillgrid_device* /*device*/, std::uint64_t /*now_ns*/,
                   const double* /*force_N*/, const double* /*torque_N_m*/) {
  return STILLGRID_DEVICE_OK;
}
std::int32_t deactivate(stillgrid_device* /*device*/) {
  return STILLGRID_DEVICE_OK;
}
void close(stillgrid_device* /*device*/) {}
void emergency_stop(stillgrid_device* /*device*/) {}
const char* strerror(stillgrid_device* /*device*/, std::int32_t /*code*/) {
  return "no error";
}

const void* get_extension(const char* name) {
  static constexpr stillgrid_device_identity_api kIdentity{sizeof kIdentity, 0, identify};
  return std::strcmp(name, STILLGRID_DEVICE_IDENTITY) == 0 ? &kIdentity : nullptr;
}

}  // namespace

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                   stillgrid_device_api* out) {
  host_log = static_cast<const stillgrid_host_log*>(host->get_extension(STILLGRID_HOST_LOG));
  *out = {1U << 20U, STILLGRID_DEVICE_ABI,
          enumerate, open,
          configure, describe,
          activate,  read,
          write,     deactivate,
          close,     emergency_stop,
          strerror,  get_extension,
          nullptr,   nullptr,
          nullptr,   nullptr};
  return STILLGRID_DEVICE_OK;
}
