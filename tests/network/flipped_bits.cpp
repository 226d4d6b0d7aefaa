#include "tests/network/flipped_bits.hpp"

#include <netinet/in.h>

#include <cstddef>

namespace stillgrid::network {
namespace {

constexpr std::size_t kShortestHeader = 20;  // of IPv4, bytes
constexpr std::size_t kUdpHeader = 8;
constexpr int kTries = 256;

/// What a packet carries beyond its headers; empty unless it is UDP over IPv4.
std::span<std::uint8_t> payload_of(std::span<std::uint8_t> packet) {
  if (packet.size() < kShortestHeader || packet[0] >> 4 != 4 || packet[9] != IPPROTO_UDP) return {};
  const bool is_first = ((packet[6] & 0x1f) << 8 | packet[7]) == 0;  // fragment offset
  const std::size_t header = std::size_t{packet[0] & 0x0fU} * 4 + (is_first ? kUdpHeader : 0);
  return header < packet.size() ? packet.subspan(header) : std::span<std::uint8_t>{};
}

}  // namespace

bool flip_unseen(std::span<std::uint8_t> packet, std::mt19937_64& random) {
  const std::span<std::uint8_t> payload = payload_of(packet);
  const std::size_t words = payload.size() / 2;
  if (words < 2) return false;
  for (int i = 0; i < kTries; ++i) {
    const std::size_t byte = random() % 2;
    const auto bit = static_cast<std::uint8_t>(1U << random() % 8);
    std::uint8_t& one = payload[2 * (random() % words) + byte];
    std::uint8_t& other = payload[2 * (random() % words) + byte];
    if (((one ^ other) & bit) == 0) continue;
    one ^= bit;
    other ^= bit;
    return true;
  }
  return false;
}

}  // namespace stillgrid::network
