#include <cstdint>
#include <stdexcept>

#include "proto/device_plugin.h"

// A driver that lets exceptions out: from activate() unless told "calm", and from read() and
// write() always.
namespace {

bool is_calm = false;

std::int32_t enumerate() {
  return 1;
}
std::int32_t open(std::uint32_t /*index*/, stillgrid_device** out) {
  *out = reinterpret_cast<stillgrid_device*>(&is_calm);
  is_calm = false;
  return STILLGRID_DEVICE_OK;
}
std::int32_t configure(stillgrid_device* /*device*/, const char* /*key*/, const char* /*value*/) {
  is_calm = true;
  return STILLGRID_DEVICE_OK;
}
std::int32_t describe(stillgrid_device* /*device*/, stillgrid_device_descriptor* /*out*/) {
  return STILLGRID_DEVICE_OK;
}
std::int32_t activate(stillgrid_device* /*device*/) {
  if (!is_calm) throw std::runtime_error("activate");
  return STILLGRID_DEVICE_OK;
}
std::int32_t read(stillgrid_device* /*device*/, std::uint64_t /*now_ns*/,
                  stillgrid_device_state* out) {
  out->valid = STILLGRID_STATE_POSITION;
  throw std::runtime_error("read");
}
std::int32_t write(stillgrid_device* /*device*/, std::uint64_t /*now_ns*/,
                   const double* /*force_N*/, const double* /*torque_N_m*/) {
  throw std::runtime_error("write");
}
std::int32_t deactivate(stillgrid_device* /*device*/) {
  throw std::runtime_error("deactivate");
}
void close(stillgrid_device* /*device*/) {
  throw std::runtime_error("close");
}
void emergency_stop(stillgrid_device* /*device*/) {
  throw std::runtime_error("stop");
}
const char* strerror(stillgrid_device* /*device*/, std::int32_t /*code*/) {
  throw std::runtime_error("strerror");
}

}  // namespace

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* /*host*/,
                                                   stillgrid_device_api* out) {
  *out = {sizeof *out, STILLGRID_DEVICE_ABI,
          enumerate,   open,
          configure,   describe,
          activate,    read,
          write,       deactivate,
          close,       emergency_stop,
          strerror,    nullptr,
          nullptr,     nullptr,
          nullptr,     nullptr};
  return STILLGRID_DEVICE_OK;
}
