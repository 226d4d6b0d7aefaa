#include <cstdint>

#include "proto/device_plugin.h"

// A driver of a later interface, which does not look at the host's.
extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* /*host*/,
                                                   stillgrid_device_api* out) {
  out->abi = STILLGRID_DEVICE_ABI + 1;
  return STILLGRID_DEVICE_OK;
}
