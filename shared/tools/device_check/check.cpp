#include "shared/tools/device_check/check.hpp"

namespace stillgrid::device_check {

std::vector<Check> all_checks() {
  std::vector<Check> all;
  for (const std::span<const Check> group :
       {library_checks(), negotiate_checks(), life_checks(), order_checks(), argument_checks(),
        descriptor_checks(), read_checks(), force_checks(), extension_checks(), pace_checks(),
        service_checks(), realtime_checks(), timing_checks(), fuzz_checks()})
    all.insert(all.end(), group.begin(), group.end());
  return all;
}

bool names(std::string_view pattern, std::string_view check) noexcept {
  if (!pattern.ends_with('*')) return pattern == check;
  return check.starts_with(pattern.substr(0, pattern.size() - 1));
}

}  // namespace stillgrid::device_check
