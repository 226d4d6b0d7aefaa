#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "shared/tools/device_check/checked_device.hpp"
#include "shared/tools/device_check/edge_buffer.hpp"

namespace stillgrid::device_check {

/// Calls with structs that end at struct_size: no byte behind it may be touched, and it stays what
/// it is. The call must work with the header's own size, and refuse any other.
template <class Struct, class Call>
void check_struct(const std::string& what, const Call& call) {
  EdgeBuffer<Struct> buffer;
  for (const std::size_t size : {std::size_t{0}, std::size_t{8}, sizeof(Struct)}) {
    Struct* const out = buffer.cut(size);
    const std::string step = what + " with a struct of " + std::to_string(size) +
                             " bytes, behind which nothing may be touched";
    const std::int32_t code = call_driver(step.c_str(), [&] { return call(out); });
    if (out->struct_size != size)
      broken(what + " changes struct_size from " + std::to_string(size) + " to " +
             std::to_string(out->struct_size));
    const bool is_done = code >= 0 || code == STILLGRID_DEVICE_END;
    if (is_done != (size == sizeof(Struct)))
      broken(what + " with " + std::to_string(size) + " bytes answers " + code_name(code));
  }
}

}  // namespace stillgrid::device_check
