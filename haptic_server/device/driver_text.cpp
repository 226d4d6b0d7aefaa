#include "haptic_server/device/driver_text.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace stillgrid::device {
namespace {

/// The bytes of the character that text begins with, 0 where it is none (RFC 3629: neither overlong
/// nor a surrogate nor above U+10FFFF).
std::size_t character_bytes(std::string_view text) {
  constexpr std::array<std::uint32_t, 5> kLeastOfLength = {0, 0, 0x80, 0x800, 0x10000};
  const auto first = static_cast<std::uint8_t>(text[0]);
  if (first < 0x80) return 1;
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC0 || first > 0xF7 || text.size() < bytes) return 0;
  std::uint32_t code = first & (0xFFU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    const auto next = static_cast<std::uint8_t>(text[i]);
    if ((next & 0xC0U) != 0x80U) return 0;
    code = (code << 6U) | (next & 0x3FU);
  }
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  return code < kLeastOfLength[bytes] || code > 0x10FFFF || is_surrogate ? 0 : bytes;
}

}  // namespace

std::string line_of(const char* text, std::size_t most_bytes) {
  std::string line;
  if (text == nullptr) return line;
  for (std::string_view rest(text, strnlen(text, most_bytes)); !rest.empty();) {
    const std::size_t bytes = character_bytes(rest);
    const auto first = static_cast<std::uint8_t>(rest[0]);
    if (bytes == 0)
      line += '?';
    else if (first < 0x20 || first == 0x7F)
      line += ' ';
    else
      line += rest.substr(0, bytes);
    rest.remove_prefix(bytes == 0 ? 1 : bytes);
  }
  return line;
}

}  // namespace stillgrid::device
