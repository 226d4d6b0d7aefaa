#pragma once

#include <optional>
#include <string_view>

#include "shared/files/number_text.hpp"

namespace stillgrid::devices {

/// As finite_number(); a '+' may stand before it.
[[nodiscard]] inline std::optional<double> parse_number(std::string_view text) noexcept {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  return files::finite_number(text);
}

}  // namespace stillgrid::devices
