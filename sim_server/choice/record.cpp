#include "sim_server/choice/record.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

namespace stillgrid::choice {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

std::string cell(const std::optional<double>& value) {
  return value ? print("%10.3g", *value) : "         -";
}

std::string fault_of(const Record& record, const Record& chosen, const Limits& limits) {
  if (record.work_per_ms > limits.work_per_ms) return "costs more than its share";
  if (!record.error_share) return "its error is unknown";
  if (!keeps_error(record, limits)) return "misses the error";
  return record.work_per_ms <= chosen.work_per_ms ? "errs more" : "costs more";
}

}  // namespace

bool keeps_error(const Record& record, const Limits& limits) {
  return record.error_share && *record.error_share <= limits.error_share;
}

std::size_t choose_record(std::span<Record> records, const Limits& limits) {
  const bool none_runs = std::ranges::all_of(records, [](auto& r) { return !r.refusal.empty(); });
  const auto rank = [&](const Record& r) {
    const bool runs = none_runs || r.refusal.empty();
    const bool is_cheap = r.work_per_ms <= limits.work_per_ms, is_exact = keeps_error(r, limits);
    const double error = r.error_share.value_or(kInfinity);
    const bool by_work = !is_cheap || is_exact;
    return std::tuple(!runs, !is_cheap, is_cheap && !is_exact, by_work ? r.work_per_ms : error,
                      r.bytes, error);
  };
  auto best = std::ranges::min_element(records, {}, rank);
  const auto least_work = best->work_per_ms;
  const auto least_bytes = best->bytes;
  const auto is_as_cheap = [&](const Record& r) {
    return r.refusal.empty() && keeps_error(r, limits) && r.bytes <= least_bytes &&
           r.work_per_ms <= std::min(limits.work_per_ms, kEqualWork * least_work);
  };
  if (is_as_cheap(*best))
    for (auto record = records.begin(); record != records.end(); ++record)
      if (is_as_cheap(*record) && *record->error_share < *best->error_share) best = record;
  for (Record& record : records)
    if (&record != &*best && record.refusal.empty())
      record.refusal = fault_of(record, *best, limits);
  best->refusal.clear();
  return static_cast<std::size_t>(best - records.begin());
}

std::string json_line(const Record& record) {
  nlohmann::ordered_json json = {{"name", record.name},
                                 {"settings", record.settings},
                                 {"work_per_ms", record.work_per_ms},
                                 {"error_share", nullptr},
                                 {"truth_error_share", record.truth_error_share},
                                 {"latency_share", record.latency_share},
                                 {"spheres", record.spheres},
                                 {"refusal", record.refusal}};
  if (record.error_share) json["error_share"] = *record.error_share;
  return json.dump();
}

std::string table_of(std::span<const Record> records, double work_per_processor_ms) {
  std::string text = print("  %-34s%10s%10s%10s%10s%10s\n  %-34s%10s%10s%10s%10s%10s\n",
                           "candidate", "work", "processor", "error", "error", "spheres", "",
                           "a ms", "%", "% force", "JND", "or bricks");
  for (const Record& record : records) {
    const auto error = [&](double unit) {
      return record.error_share ? std::optional(*record.error_share / unit) : std::nullopt;
    };
    text += (record.refusal.empty() ? "* " : "  ") +
            print("%-34s%10.3g%10.3g", record.name.c_str(), record.work_per_ms,
                  100.0 * record.work_per_ms / work_per_processor_ms) +
            cell(error(0.01)) + cell(error(rendering::kJustNoticeable)) +
            print("%10zu", record.spheres) + "  " +
            (record.refusal.empty() ? "chosen" : record.refusal) + '\n';
  }
  return text;
}

}  // namespace stillgrid::choice
