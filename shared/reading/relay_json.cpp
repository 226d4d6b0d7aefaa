#include "shared/reading/relay_json.hpp"

#include <nlohmann/json.hpp>

namespace stillgrid::reading {

nlohmann::ordered_json relay_json(const std::optional<proto::RelayFigures>& figures) {
  using Json = nlohmann::ordered_json;
  if (!figures) return {};
  const bool is_measured = figures->round_trip_ns != 0;
  const auto measured = [&](auto value) { return is_measured ? Json(value) : Json(); };
  return {{"connected", figures->connected != 0},
          {"round_trip_ns", measured(figures->round_trip_ns)},
          {"clock_offset_ns", measured(figures->clock_offset_ns)},
          {"clock_bound_ns", measured(figures->clock_bound_ns)},
          {"received", figures->received},
          {"received_bytes", figures->received_bytes},
          {"lost", figures->lost},
          {"repeated", figures->repeated},
          {"out_of_order", figures->out_of_order},
          {"late", figures->late},
          {"refused", figures->refused},
          {"partitions", figures->partitions},
          {"longest_silence_ns", figures->longest_silence_ns}};
}

}  // namespace stillgrid::reading
