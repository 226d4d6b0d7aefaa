#pragma once

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <string>

namespace stillgrid {

/// A check for command lines: a number within [low, high]. Unlike CLI11's own, it refuses what is
/// no number: a NaN compares false with every bound.
[[nodiscard]] inline CLI::Validator number_in(double low, double high) {
  return {[low, high](const std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            if (end != text.c_str() && *end == '\0' && value >= low && value <= high)
              return std::string();
            return "value '" + text + "': expected a number from " + CLI::detail::to_string(low) +
                   " to " + CLI::detail::to_string(high);
          },
          "NUMBER"};
}

}  // namespace stillgrid
