#include "haptic_server/recording/tick_row.hpp"

#include <cstddef>

#include "haptic_server/safety/safety_flag.hpp"

namespace stillgrid::recording {

void append_flags(std::uint32_t flags, std::string& text) {
  const char* separator = "";
  for (std::size_t i = 0; i < safety::kSafetyFlagNames.size(); ++i) {
    if ((flags & (1U << i)) == 0) continue;
    text += separator;
    text += safety::kSafetyFlagNames[i];
    separator = "|";
  }
}

}  // namespace stillgrid::recording
