#include "shared/tools/laboratory/stability_map.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr const char* kColumns =
    "scene,device,model,transition,period_s,latency_share,jitter,seed,resolution_m,"
    "device_friction_N,contact_damping_N_s_per_m,friction,duration_s,limit_N_per_m";

/// "1", or "1-8".
std::string seeds_of(const LabCell& cell) {
  const std::string first = std::to_string(cell.seed);
  if (cell.seeds == 1) return first;
  return first + '-' + std::to_string(cell.seed + static_cast<std::uint64_t>(cell.seeds) - 1);
}

/// A row's fields up to its limit.
std::string key_of(const LabCell& cell) {
  std::ostringstream key;
  const bool is_quoted = cell.device.find(',') != std::string::npos;
  const char* const quote = is_quoted ? "\"" : "";
  key << cell.scene << ',' << quote << cell.device << quote << ',' << cell.model << ','
      << cell.transition << ',' << cell.period_s << ',' << cell.latency_share << ',' << cell.jitter
      << ',' << seeds_of(cell) << ',' << cell.resolution_m << ',' << cell.device_friction_N << ','
      << cell.contact_damping_N_s_per_m << ',' << cell.friction << ',' << cell.duration_s;
  return key.str();
}

/// What a file holds already: limits by key, as text.
std::map<std::string, std::string> read_rows(const std::filesystem::path& file) {
  std::map<std::string, std::string> rows;
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line)) return rows;
  if (line != kColumns)
    throw std::runtime_error(file.string() + ":1: value '" + line + "': expected the columns " +
                             kColumns);
  while (std::getline(stream, line)) {
    if (stream.eof()) break;  // a line without its end was being written
    const std::size_t comma = line.rfind(',');
    if (comma != std::string::npos) rows[line.substr(0, comma)] = line.substr(comma + 1);
  }
  return rows;
}

/// Written to its own place and then moved, so that a stop leaves one or the other.
void write_rows(const std::filesystem::path& file, const std::vector<LabCell>& cells,
                const std::map<std::string, std::string>& rows) {
  const std::filesystem::path part = file.string() + ".part";
  std::ofstream stream(part);
  stream << kColumns << '\n';
  for (const LabCell& cell : cells) {
    const auto row = rows.find(key_of(cell));
    if (row != rows.end()) stream << row->first << ',' << row->second << '\n';
  }
  for (const auto& [key, limit] : rows) {
    const auto is_key = [&key = key](const LabCell& cell) { return key_of(cell) == key; };
    if (std::none_of(cells.begin(), cells.end(), is_key)) stream << key << ',' << limit << '\n';
  }
  stream.close();
  if (!stream) throw std::runtime_error(part.string() + ": cannot be written");
  std::filesystem::rename(part, file);
}

}  // namespace

std::vector<LabCell> cells_of(const StabilityMap& map) {
  std::vector<LabCell> cells;
  LabCell cell = map.common;
  for (const auto& scene : map.scenes)
    for (const auto& device : map.devices)
      for (const auto& model : map.models)
        for (const auto& transition : map.transitions) {
          cell.scene = scene, cell.device = device;
          cell.model = model, cell.transition = transition;
          if (model != "grid" && transition != map.transitions.front()) continue;
          for (const double period_s : map.periods_s)
            for (const double latency_share : map.latency_shares)
              for (const double jitter : map.jitters) {
                cell.period_s = period_s, cell.latency_share = latency_share, cell.jitter = jitter;
                cells.push_back(cell);
              }
        }
  return cells;
}

void draw_map(const StabilityMap& map, const StiffnessSearch& search, unsigned threads,
              const std::filesystem::path& file) {
  const std::vector<LabCell> cells = cells_of(map);
  std::map<std::string, std::string> rows = read_rows(file);
  write_rows(file, cells, rows);
  std::mutex mutex;  // of rows, file, failure
  std::exception_ptr failure;
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < cells.size(); i = next++) {
      const std::string key = key_of(cells[i]);
      try {
        {
          const std::lock_guard lock(mutex);
          if (rows.contains(key) || failure || realtime::stop_requested()) continue;
        }
        const auto limit_N_per_m = largest_stable_stiffness_N_per_m(cells[i], search);
        std::ostringstream text;
        if (limit_N_per_m) text << *limit_N_per_m;
        const std::lock_guard lock(mutex);
        rows[key] = text.str();
        std::ofstream(file, std::ios::app) << key << ',' << text.str() << '\n';
        std::fprintf(stderr, "%zu of %zu: %s,%s\n", i + 1, cells.size(), key.c_str(),
                     text.str().c_str());
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
  write_rows(file, cells, rows);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace stillgrid::laboratory
