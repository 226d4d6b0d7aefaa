#include <cstdint>

#include "proto/device_plugin.h"

// A driver whose device is there but does not open.
namespace {

std::int32_t enumerate() {
  return 1;
}
std::int32_t open(std::uint32_t /*index*/, stillgrid_device** /*out*/) {
  return STILLGRID_DEVICE_E_IO;
}
std::int32_t configure(stillgrid_device* /*device*/, const char* /*key*/, const char* /*value*/) {
  return STILLGRID_DEVICE_E_ORDER;
}
std::int32_t describe(stillgrid_device* /*device*/, stillgrid_device_descriptor* /*out*/) {
  return STILLGRID_DEVICE_E_ORDER;
}
std::int32_t activate(stillgrid_device* /*device*/) {
  return STILLGRID_DEVICE_E_ORDER;
}
std::int32_t read(stillgrid_device* /*device*/, std::uint64_t /*now_ns*/,
                  stillgrid_device_state* /*out*/) {
  return STILLGRID_DEVICE_E_ORDER;
}
std::int32_t write(stillgrid_device* /*device*/, std::uint64_t /*now_ns*/,
                   const double* /*force_N*/, const double* /*torque_N_m*/) {
  return STILLGRID_DEVICE_E_ORDER;
}
void close(stillgrid_device* /*device*/) {}
void emergency_stop(stillgrid_device* /*device*/) {}
const char* strerror(stillgrid_device* /*device*/, std::int32_t /*code*/) {
  return "the cable is not plugged in";
}

}  // namespace

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* /*host*/,
                                                   stillgrid_device_api* out) {
  *out = {sizeof *out, STILLGRID_DEVICE_ABI,
          enumerate,   open,
          configure,   describe,
          activate,    read,
          write,       activate,
          close,       emergency_stop,
          strerror,    nullptr,
          nullptr,     nullptr,
          nullptr,     nullptr};
  return STILLGRID_DEVICE_OK;
}
