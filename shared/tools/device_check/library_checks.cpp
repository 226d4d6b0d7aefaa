#include <algorithm>
#include <array>
#include <exception>
#include <string>

#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"
#include "shared/tools/device_check/exported_symbols.hpp"

namespace stillgrid::device_check {
namespace {

Outcome check_exports(const Subject& subject) {
  std::vector<std::string> others;
  try {
    others = exported_symbols(subject.library);
  } catch (const std::exception& error) {
    broken(error.what());
  }
  // Older linkers mark these in every library.
  for (const char* const mark :
       {"stillgrid_device_negotiate", "_init", "_fini", "_edata", "_end", "__bss_start"})
    others.erase(std::remove(others.begin(), others.end(), mark), others.end());
  if (others.empty()) return {};
  constexpr std::size_t kTold = 3;
  std::string line = "it exports " + std::to_string(others.size()) + " more:";
  for (std::size_t n = 0; n < std::min(others.size(), kTold); ++n) line += " " + others[n];
  if (others.size() > kTold) line += " ...";
  return {Verdict::kFail, line + " (hidden visibility and a version script keep them in)", {}};
}

Outcome check_loads(const Subject& subject) {
  (void)load_driver(subject);
  return {};
}

constexpr std::array kChecks = {
    Check{"library.exports", "exports stillgrid_device_negotiate and nothing else", "",
          check_exports},
    Check{"library.loads", "loads with every symbol resolved (RTLD_NOW)", "", check_loads},
};

}  // namespace

std::span<const Check> library_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check
