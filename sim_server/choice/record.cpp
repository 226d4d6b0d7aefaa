#include "sim_server/choice/record.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "shared/rendering/force_error.hpp"

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

std::string fault_of(const Record& record, const Record& chosen, double max_error_share) {
  if (!record.error_share) return "its error is unknown";
  if (!keeps_error(record, max_error_share)) return "misses the error";
  return record.work_per_ms <= chosen.work_per_ms ? "errs more" : "costs more";
}

}  // namespace

bool keeps_error(const Record& record, double max_error_share) {
  return record.error_share && *record.error_share <= max_error_share;
}

std::size_t choose_record(std::span<Record> records, double max_error_share) {
  const bool none_runs = std::ranges::all_of(records, [](auto& r) { return !r.refusal.empty(); });
  const auto rank = [&](const Record& r) {
    const bool runs = none_runs || r.refusal.empty();
    const bool is_exact = keeps_error(r, max_error_share);
    const double error = r.error_share.value_or(kInfinity);
    return std::tuple(!runs, !is_exact, is_exact ? r.work_per_ms : error, r.bytes, error);
  };
  auto best = std::ranges::min_element(records, {}, rank);
  const auto least_work = best->work_per_ms;
  const auto least_bytes = best->bytes;
  const auto is_as_cheap = [&](const Record& r) {
    return r.refusal.empty() && keeps_error(r, max_error_share) && r.bytes <= least_bytes &&
           r.work_per_ms <= kEqualWork * least_work;
  };
  if (is_as_cheap(*best))
    for (auto record = records.begin(); record != records.end(); ++record)
      if (is_as_cheap(*record) && *record->error_share < *best->error_share) best = record;
  for (Record& record : records)
    if (&record != &*best && record.refusal.empty())
      record.refusal = fault_of(record, *best, max_error_share);
  best->refusal.clear();
  return static_cast<std::size_t>(best - records.begin());
}

std::string json_line(const Record& record) {
  nlohmann::ordered_json json = {{"name", record.name},
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
