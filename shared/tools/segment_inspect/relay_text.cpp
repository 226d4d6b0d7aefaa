#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "shared/tools/segment_inspect/inspection_text.hpp"

namespace stillgrid::segment_inspect {
namespace {

/// "12,345".
std::string grouped(std::uint64_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ',');
  return digits;
}

/// "0.021 ms", "20.3 ms", "12.3 s"; with its sign where it is asked for.
std::string duration_text(double ns, bool with_sign = false) {
  const char* const sign = ns < 0.0 ? "-" : with_sign ? "+" : "";
  const double ms = std::abs(ns) * 1e-6;
  if (ms >= 999.5) return fmt::format("{}{:.1f} s", sign, ms * 1e-3);
  return ms >= 0.9995 ? fmt::format("{}{:.3g} ms", sign, ms) : fmt::format("{}{:.3f} ms", sign, ms);
}

}  // namespace

std::string relay_text(const proto::RelayFigures& figures) {
  std::string text = figures.connected != 0 ? "connected" : "silent: the other side is not heard";
  const auto of_ns = [](auto ns) { return static_cast<double>(ns); };
  if (figures.round_trip_ns != 0)
    text +=
        fmt::format(", round trip {}, clock {} +- {}", duration_text(of_ns(figures.round_trip_ns)),
                    duration_text(of_ns(figures.clock_offset_ns), true),
                    duration_text(of_ns(figures.clock_bound_ns)));
  text += fmt::format(", {} received ({}), {} lost", grouped(figures.received),
                      size_text(figures.received_bytes), grouped(figures.lost));
  for (const auto& [count, name] : {std::pair{figures.repeated, "repeated"},
                                    {figures.out_of_order, "out of order"},
                                    {figures.late, "late"},
                                    {figures.refused, "refused"},
                                    {figures.partitions, "partitions"}})
    if (count != 0) text += fmt::format(", {} {}", grouped(count), name);
  if (figures.longest_silence_ns != 0)
    text += ", longest silence " + duration_text(of_ns(figures.longest_silence_ns));
  return text;
}

}  // namespace stillgrid::segment_inspect
