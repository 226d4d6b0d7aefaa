#include <cstdint>

#include "proto/device_plugin.h"

// A driver of a later interface than any host of ours.
extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* /*host*/,
                                                   stillgrid_device_api* /*out*/) {
  return STILLGRID_DEVICE_E_VERSION;
}
