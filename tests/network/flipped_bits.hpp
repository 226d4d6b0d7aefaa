#pragma once

#include <cstdint>
#include <random>
#include <span>

namespace stillgrid::network {

/// Flips two bits in what a packet of UDP over IPv4 carries, such that its checksum still holds and
/// the receiver is given the bytes: one of two words of 16 bits gains the bit that the other loses,
/// and the checksum is the words' sum [RFC 768]. Of a fragment too. Returns false, nothing changed,
/// where the packet is of another kind or carries too little that differs.
[[nodiscard]] bool flip_unseen(std::span<std::uint8_t> packet, std::mt19937_64& random);

}  // namespace stillgrid::network
