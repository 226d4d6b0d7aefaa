#pragma once

#include "proto/segment_header.hpp"

namespace stillgrid::publication {

/// What a relay may tell whose link of 20 ms loses, doubles and delays, and was cut twice.
[[nodiscard]] inline proto::RelayFigures lossy_figures() {
  return {.relay_id = 0xFEEDFACE12345678,
          .connected = 1,
          .clock_offset_ns = -1'234'567'890'123,
          .clock_bound_ns = 104'000,
          .round_trip_ns = 20'340'000,
          .received = 1'234'567,
          .received_bytes = 3ULL << 29U,
          .lost = 1'002,
          .repeated = 7,
          .out_of_order = 0,
          .late = 3,
          .refused = 1,
          .partitions = 2,
          .longest_silence_ns = 3'140'000'000,
          .reserved = {}};
}

/// The same before it has heard anything of the other side.
[[nodiscard]] inline proto::RelayFigures lonely_figures() {
  proto::RelayFigures figures{};
  figures.relay_id = 1;
  return figures;
}

}  // namespace stillgrid::publication
