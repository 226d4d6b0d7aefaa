#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace stillgrid::command_line {

/// A check for command lines: a number within [low, high], in decimal digits. Unlike CLI11's own,
/// it refuses what is no number: a NaN compares false with every bound.
[[nodiscard]] inline CLI::Validator number_in(double low, double high) {
  return {[low, high](const std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            const bool is_decimal = text.find_first_not_of("0123456789.eE+-") == std::string::npos;
            if (is_decimal && end != text.c_str() && *end == '\0' && value >= low && value <= high)
              return std::string();
            return "value '" + text + "': expected a number from " + CLI::detail::to_string(low) +
                   " to " + CLI::detail::to_string(high);
          },
          "NUMBER"};
}

/// The same of a whole number. Unlike CLI11's own, it takes no -1 for what has no sign. Pre:
/// 0 <= low <= high <= 999999999999999.
[[nodiscard]] inline CLI::Validator integer_in(std::uint64_t low, std::uint64_t high) {
  return {[low, high](const std::string& text) {
            const bool is_whole = !text.empty() && text.size() <= 15 &&
                                  text.find_first_not_of("0123456789") == std::string::npos;
            const std::uint64_t value =
                is_whole ? std::strtoull(text.c_str(), nullptr, 10) : high + 1;
            if (is_whole && value >= low && value <= high) return std::string();
            return "value '" + text + "': expected an integer from " + std::to_string(low) +
                   " to " + std::to_string(high);
          },
          "INTEGER"};
}

}  // namespace stillgrid::command_line
