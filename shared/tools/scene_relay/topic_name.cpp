#include "shared/tools/scene_relay/topic_name.hpp"

namespace stillgrid::scene_relay {

std::string topic_part(std::string_view session) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string result;
  for (const char c : session) {
    const auto number = static_cast<unsigned char>(c);
    const bool is_plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    result += is_plain ? std::string(1, c)
                       : std::string{'_', kDigits[number >> 4U], kDigits[number & 15U]};
  }
  return result;
}

}  // namespace stillgrid::scene_relay
