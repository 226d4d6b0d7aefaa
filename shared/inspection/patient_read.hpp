#pragma once

#include <chrono>
#include <thread>

#include "shared/publication/double_buffer.hpp"

namespace stillgrid {

/// read_latest() again and again while it is overtaken: a look from outside has no priority and may
/// copy a whole image. Thread: any but a real-time one.
template <class Gather>
ReadResult read_patiently(const DoubleBuffer& buffer, Gather&& gather) {
  ReadResult result;
  for (int round = 0; round < 50; ++round) {
    result = read_latest(buffer, gather);
    if (result.status != ReadStatus::kContended) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return result;
}

}  // namespace stillgrid
