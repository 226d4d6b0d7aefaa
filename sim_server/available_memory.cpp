#include "sim_server/available_memory.hpp"

#include <sys/resource.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

namespace stillgrid::sim_server {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr double kShare = 0.9;  // of the machine's available memory

/// The number that a file begins with; none if it has no such file, or says "max".
std::optional<double> number_in_file(const std::filesystem::path& file) {
  std::ifstream stream(file);
  double number = 0.0;
  if (stream >> number) return number;
  return std::nullopt;
}

/// A line of /proc's "Key:   number kB".
double kilobytes_of(const std::filesystem::path& file, const std::string& key) {
  std::ifstream stream(file);
  std::string word;
  double number = 0.0;
  while (stream >> word)
    if (word == key && stream >> number) return 1024.0 * number;
  return kUnlimited;
}

/// What a group holds of files, which the kernel drops when memory is asked for.
double file_cache_bytes(const std::filesystem::path& folder, bool is_second) {
  std::ifstream stream(folder / "memory.stat");
  const std::string before = is_second ? "" : "total_";
  std::string word;
  double bytes = 0.0;
  for (double number = 0.0; stream >> word >> number;)
    if (word == before + "inactive_file" || word == before + "active_file") bytes += number;
  return bytes;
}

/// The folders of the control groups that this process is in, of either version, and those above.
double left_by_groups(const std::filesystem::path& root) {
  const std::filesystem::path groups = root / "sys/fs/cgroup";
  double left = kUnlimited;
  std::ifstream stream(root / "proc/self/cgroup");
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string kinds = line.substr(first + 1, second - first - 1);
    const bool is_second = kinds.empty();
    if (!is_second && kinds.find("memory") == std::string::npos) continue;
    const std::filesystem::path base = is_second ? groups : groups / "memory";
    std::filesystem::path within = std::filesystem::path(line.substr(second + 1)).relative_path();
    while (true) {
      const auto folder = base / within;
      const auto most =
          number_in_file(folder / (is_second ? "memory.max" : "memory.limit_in_bytes"));
      const auto taken =
          number_in_file(folder / (is_second ? "memory.current" : "memory.usage_in_bytes"));
      if (most && taken)
        left = std::min(
            left,
            std::max(0.0, *most - std::max(0.0, *taken - file_cache_bytes(folder, is_second))));
      if (within.empty()) break;
      within = within.parent_path();
    }
  }
  return left;
}

double left_of_address_space(const std::filesystem::path& root) {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
  const double taken = kilobytes_of(root / "proc/self/status", "VmSize:");
  return taken < kUnlimited ? std::max(0.0, static_cast<double>(limit.rlim_cur) - taken)
                            : kUnlimited;
}

}  // namespace

dynamics::Memory available_memory(const std::filesystem::path& root) {
  dynamics::Memory memory{kUnlimited, kUnlimited};
  memory.private_bytes = std::min({kShare * kilobytes_of(root / "proc/meminfo", "MemAvailable:"),
                                   left_by_groups(root), left_of_address_space(root)});
  struct statvfs space {};
  if (statvfs((root / "dev/shm").c_str(), &space) == 0)
    memory.shared_bytes = static_cast<double>(space.f_bavail) * static_cast<double>(space.f_frsize);
  return memory;
}

}  // namespace stillgrid::sim_server
