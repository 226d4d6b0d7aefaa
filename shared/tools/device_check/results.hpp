#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "shared/tools/device_check/check.hpp"

namespace stillgrid::device_check {

/// A check and how it ended.
struct CheckResult {
  Check check;
  Outcome outcome;
  double time_s = 0.0;
};

/// How many of the results have that name: "PASS", "WARN", "FAIL" or "SKIP".
[[nodiscard]] std::size_t count_of(const std::vector<CheckResult>& results, const char* verdict);

/// A line, and below it, indented, why and the details.
[[nodiscard]] std::string text_of(const CheckResult& result);

/// "32 checks: 30 passed, 1 failed, 0 warnings, 1 skipped".
[[nodiscard]] std::string summary_of(const std::vector<CheckResult>& results);

/// docs/device_check.md, "The report".
[[nodiscard]] nlohmann::json json_of(const std::vector<CheckResult>& results,
                                     const Subject& subject);

}  // namespace stillgrid::device_check
