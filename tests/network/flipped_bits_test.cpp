#include "tests/network/flipped_bits.hpp"

#include <netinet/in.h>

#include <bit>
#include <catch2/catch.hpp>
#include <vector>

namespace stillgrid::network::flipped_bits_test {
namespace {

/// IPv4 with some options, then drawn bytes. fragment: its place in 8 bytes, 0 for the first or
/// only one.
std::vector<std::uint8_t> drawn_packet(std::mt19937_64& random, std::uint8_t protocol,
                                       unsigned fragment) {
  const std::size_t header = 20 + 4 * (random() % 3);
  std::vector<std::uint8_t> packet(header + 8 + 12 + random() % 1'400);
  for (std::uint8_t& byte : packet) byte = static_cast<std::uint8_t>(random());
  packet[0] = static_cast<std::uint8_t>(0x40 | header / 4);
  packet[6] = static_cast<std::uint8_t>(fragment >> 8);
  packet[7] = static_cast<std::uint8_t>(fragment);
  packet[9] = protocol;
  return packet;
}

/// Of words of 16 bits, with end-around carry, as RFC 1071 has it.
std::uint32_t internet_sum(std::span<const std::uint8_t> bytes) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    sum += i % 2 == 0 ? bytes[i] * 256U : bytes[i];
    sum = (sum & 0xffffU) + (sum >> 16);
  }
  return sum;
}

}  // namespace

TEST_CASE("Two bits of what a datagram carries are flipped, and no checksum sees it") {
  std::mt19937_64 random(GENERATE(1U, 23U, 456U));
  for (int i = 0; i < 500; ++i) {
    const unsigned fragment = i % 3 == 0 ? 1 + static_cast<unsigned>(random() % 5'000) : 0;
    const std::vector<std::uint8_t> before = drawn_packet(random, IPPROTO_UDP, fragment);
    std::vector<std::uint8_t> after = before;
    REQUIRE(flip_unseen(after, random));
    REQUIRE(after.size() == before.size());
    const std::size_t headers = (before[0] & 0x0fU) * 4U + (fragment == 0 ? 8U : 0U);
    int flipped = 0;
    for (std::size_t byte = 0; byte < before.size(); ++byte) {
      const int bits = std::popcount(static_cast<unsigned>(before[byte] ^ after[byte]));
      REQUIRE((bits == 0 || byte >= headers));
      flipped += bits;
    }
    CHECK(flipped == 2);
    CHECK(internet_sum(before) == internet_sum(after));
  }
}

TEST_CASE("What is no datagram, or carries nothing that differs, is left as it is") {
  std::mt19937_64 random(7);
  std::vector<std::vector<std::uint8_t>> packets = {drawn_packet(random, IPPROTO_TCP, 0),
                                                    drawn_packet(random, IPPROTO_ICMP, 0)};
  packets.push_back(drawn_packet(random, IPPROTO_UDP, 0));
  std::fill(packets.back().begin() + 20, packets.back().end(), std::uint8_t{0});
  packets.push_back(drawn_packet(random, IPPROTO_UDP, 0));
  packets.back().resize(30);  // a byte or two
  packets.push_back(drawn_packet(random, IPPROTO_UDP, 0));
  packets.back()[0] = 0x4f;  // a header that is longer than the packet
  packets.back().resize(40);
  for (const std::vector<std::uint8_t>& before : packets) {
    std::vector<std::uint8_t> after = before;
    CHECK_FALSE(flip_unseen(after, random));
    CHECK(after == before);
  }
}

}  // namespace stillgrid::network::flipped_bits_test
