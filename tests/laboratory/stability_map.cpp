#include "tests/laboratory/stability_map.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iomanip>
#include <map>
#include <mutex>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr const char* kColumns =
    "scene,tool,device,limits,from,model,transition,period_s,latency_share,jitter,seeds,"
    "resolution_m,device_friction_N,contact_damping_N_s_per_m,friction,duration_s,lowest_N_per_m,"
    "highest_N_per_m,limit_N_per_m,lost_by,other_seeds_N_per_m,processor_s";
constexpr std::size_t kFound = 4;  // columns of what was found, after those of what was searched

/// "1", or "1-8".
std::string seeds_of(const LabCell& cell) {
  const std::string first = std::to_string(cell.seed);
  if (cell.seeds == 1) return first;
  return first + '-' + std::to_string(cell.seed + static_cast<std::uint64_t>(cell.seeds) - 1);
}

/// A row's fields up to what was found.
std::string key_of(const LabCell& cell, const StiffnessSearch& search) {
  std::ostringstream key;
  const bool is_quoted = cell.device.find(',') != std::string::npos;
  const char* const quote = is_quoted ? "\"" : "";
  key << cell.scene << ',' << cell.tool << ',' << quote << cell.device << quote << ','
      << cell.limits << ',' << cell.from << ',' << cell.model << ',' << cell.transition << ','
      << cell.period_s << ',' << cell.latency_share << ',' << cell.jitter << ',' << seeds_of(cell)
      << ',' << cell.resolution_m << ',' << cell.device_friction_N << ','
      << cell.contact_damping_N_s_per_m << ',' << friction_of(cell) << ',' << cell.duration_s << ','
      << search.lowest_N_per_m << ',' << search.highest_N_per_m;
  return key.str();
}

std::string text_of(const CellLimit& found) {
  std::ostringstream text;
  if (found.limit_N_per_m) text << *found.limit_N_per_m;
  text << ',';
  if (found.lost_by != Verdict::kStable) text << name_of(found.lost_by);
  text << ',';
  if (found.by_others_N_per_m) text << *found.by_others_N_per_m;
  text << ',' << std::setprecision(3) << found.processor_s;
  return text.str();
}

/// Where what was found begins; npos: the line has too few columns.
std::size_t end_of_key(const std::string& line) {
  std::size_t comma = line.size();
  for (std::size_t i = 0; i < kFound && comma != std::string::npos && comma > 0; ++i)
    comma = line.rfind(',', comma - 1);
  return comma;
}

/// Whether a line has as many cells as columns, and numbers and a verdict where these belong.
bool is_row(const std::string& line) {
  static const std::regex found(
      R"((\d[\d.e+-]*)?,(swings|parted|nowhere)?,(\d[\d.e+-]*)?,\d[\d.e+-]*)");
  const std::string_view columns = kColumns;
  bool is_quoted = false;
  std::ptrdiff_t commas = 0;
  for (const char letter : line) {
    if (letter == '"') is_quoted = !is_quoted;
    if (letter == ',' && !is_quoted) ++commas;
  }
  return commas == std::count(columns.begin(), columns.end(), ',') &&
         std::regex_match(line.substr(end_of_key(line) + 1), found);
}

/// What a file holds already: what was found by key, as text.
std::map<std::string, std::string> read_rows(const std::filesystem::path& file) {
  std::map<std::string, std::string> rows;
  if (std::filesystem::is_directory(file))
    throw std::runtime_error(file.string() + ": expected a file, not a folder");
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line)) return rows;
  if (line != kColumns)
    throw std::runtime_error(file.string() + ":1: value '" + line + "': expected the columns " +
                             kColumns);
  for (int number = 2; std::getline(stream, line); ++number) {
    if (stream.eof()) break;  // a line without its end was being written
    if (!is_row(line))
      throw std::runtime_error(file.string() + ':' + std::to_string(number) + ": value '" + line +
                               "': expected a row of this table, or none: take the line away");
    const std::size_t comma = end_of_key(line);
    rows[line.substr(0, comma)] = line.substr(comma + 1);
  }
  return rows;
}

/// Written to its own place and then moved, so that a stop leaves one or the other.
void write_rows(const std::filesystem::path& file, const std::vector<std::string>& keys,
                const std::map<std::string, std::string>& rows) {
  const std::filesystem::path part = file.string() + ".part";
  std::ofstream stream(part);
  stream << kColumns << '\n';
  for (const std::string& key : keys) {
    const auto row = rows.find(key);
    if (row != rows.end()) stream << row->first << ',' << row->second << '\n';
  }
  const std::set<std::string> asked(keys.begin(), keys.end());
  for (const auto& [key, found] : rows)
    if (!asked.contains(key)) stream << key << ',' << found << '\n';
  stream.close();
  if (!stream) throw std::runtime_error(part.string() + ": cannot be written");
  std::filesystem::rename(part, file);
}

bool can_come_from_outside(const LabCell& cell) {
  const auto body = lab_body_named(cell.scene.substr(0, cell.scene.find(':')));
  return !body || stands_alone(*body);
}

/// How far a map is; the cells that are left take as long as those that were measured.
class Progress {
 public:
  Progress(std::size_t cells, unsigned threads) : left_(cells), threads_(threads) {}

  void tell(const std::string& row, double cell_s) {
    measured_s_ += cell_s;
    ++measured_;
    --left_;
    const double left_s =
        measured_s_ / static_cast<double>(measured_ * threads_) * static_cast<double>(left_);
    std::fprintf(stderr, "%zu cells left, about %.0f min: %s\n", left_, left_s / 60.0, row.c_str());
  }

 private:
  std::size_t left_, measured_ = 0;
  unsigned threads_;
  double measured_s_ = 0.0;
};

}  // namespace

std::vector<LabCell> cells_of(const StabilityMap& map) {
  std::vector<LabCell> cells = {map.common};
  const auto vary = [&cells](const auto& values, auto LabCell::*of) {
    std::vector<LabCell> varied;
    for (const LabCell& cell : cells)
      for (const auto& value : values) (varied.emplace_back(cell).*of) = value;
    cells = std::move(varied);
  };
  vary(map.scenes, &LabCell::scene);
  vary(map.tools, &LabCell::tool);
  vary(map.devices, &LabCell::device);
  vary(map.limits, &LabCell::limits);
  vary(map.froms, &LabCell::from);
  vary(map.models, &LabCell::model);
  vary(map.transitions, &LabCell::transition);
  vary(map.periods_s, &LabCell::period_s);
  vary(map.latency_shares, &LabCell::latency_share);
  vary(map.jitters, &LabCell::jitter);
  std::erase_if(cells, [&map](const LabCell& cell) {
    return (cell.model != "grid" && cell.transition != map.transitions.front()) ||
           (cell.from == "outside" && !can_come_from_outside(cell));
  });
  return cells;
}

void draw_map(const StabilityMap& map, const StiffnessSearch& search, unsigned threads,
              const std::filesystem::path& file) {
  const std::vector<LabCell> cells = cells_of(map);
  std::vector<std::string> keys;
  for (const LabCell& cell : cells) keys.push_back(key_of(cell, search));
  std::map<std::string, std::string> rows = read_rows(file);
  write_rows(file, keys, rows);
  Progress progress(static_cast<std::size_t>(std::count_if(
                        keys.begin(), keys.end(),
                        [&rows](const std::string& key) { return !rows.contains(key); })),
                    threads);
  std::mutex mutex;  // of rows, file, failure, progress
  std::exception_ptr failure;
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < cells.size(); i = next++) {
      try {
        {
          const std::lock_guard lock(mutex);
          if (rows.contains(keys[i]) || failure || realtime::stop_requested()) continue;
        }
        const CellLimit found = limit_of(cells[i], search);
        const std::string text = text_of(found);
        const std::lock_guard lock(mutex);
        rows[keys[i]] = text;
        std::ofstream(file, std::ios::app) << keys[i] << ',' << text << '\n';
        progress.tell(keys[i] + ',' + text, found.processor_s);
      } catch (...) {
        const std::lock_guard lock(mutex);
        failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> pool;
    for (unsigned i = 0; i < threads; ++i) pool.emplace_back(work);
  }
  write_rows(file, keys, rows);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace stillgrid::laboratory
