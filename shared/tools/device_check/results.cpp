#include "shared/tools/device_check/results.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

namespace stillgrid::device_check {
namespace {

constexpr const char* kIndent = "     ";

}  // namespace

std::size_t count_of(const std::vector<CheckResult>& results, const char* verdict) {
  return static_cast<std::size_t>(
      std::count_if(results.begin(), results.end(), [&](const CheckResult& result) {
        return std::string_view(verdict_name(result.outcome.verdict)) == verdict;
      }));
}

std::string text_of(const CheckResult& result) {
  const auto& [verdict, line, details] = result.outcome;
  const std::string name = verdict_name(verdict);
  // What was not checked is one line: there may be many of them.
  const bool is_told_below = name == "FAIL" || name == "WARN";
  std::array<char, 64> head{};
  std::snprintf(head.data(), head.size(), "%s %-22s ", name.c_str(), result.check.name);
  std::string text = head.data() + (name == "SKIP" ? line : std::string(result.check.rule));
  if (name == "PASS" && !line.empty()) text += ": " + line;
  text += "\n";
  if (is_told_below && !line.empty()) text += kIndent + line + "\n";
  std::istringstream lines(details);
  for (std::string detail; std::getline(lines, detail);) text += kIndent + detail + "\n";
  return text;
}

std::string summary_of(const std::vector<CheckResult>& results) {
  return std::to_string(results.size()) + " checks: " + std::to_string(count_of(results, "PASS")) +
         " passed, " + std::to_string(count_of(results, "FAIL")) + " failed, " +
         std::to_string(count_of(results, "WARN")) + " warnings, " +
         std::to_string(count_of(results, "SKIP")) + " skipped";
}

nlohmann::json json_of(const std::vector<CheckResult>& results, const Subject& subject) {
  nlohmann::json json = {{"library", subject.library.string()},
                         {"seed", subject.seed},
                         {"seconds", subject.seconds},
                         {"any_force", subject.any_force},
                         {"passed", count_of(results, "PASS")},
                         {"failed", count_of(results, "FAIL")},
                         {"warnings", count_of(results, "WARN")},
                         {"skipped", count_of(results, "SKIP")},
                         {"options", nlohmann::json::object()},
                         {"checks", nlohmann::json::array()}};
  for (const device::DeviceOption& option : subject.options)
    json["options"][option.key] = option.value;
  for (const auto& [check, outcome, time_s] : results)
    json["checks"].push_back({{"name", check.name},
                              {"rule", check.rule},
                              {"verdict", verdict_name(outcome.verdict)},
                              {"line", outcome.line},
                              {"details", outcome.details},
                              {"time_s", time_s}});
  return json;
}

}  // namespace stillgrid::device_check
