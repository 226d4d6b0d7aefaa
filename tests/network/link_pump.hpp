#pragma once

#include <array>
#include <cstdint>

#include "tests/network/link_direction.hpp"

namespace stillgrid::network {

/// Carries packets between two TUN interfaces.
class LinkPump {
 public:
  /// tuns: of sides a and b, which do not block.
  LinkPump(std::array<int, 2> tuns, std::uint64_t seed)
      : tuns_(tuns), directions_{LinkDirection(2 * seed), LinkDirection(2 * seed + 1)} {}

  /// What side 0 (a) or 1 (b) sends.
  [[nodiscard]] LinkDirection& sent_by(std::size_t side) { return directions_[side]; }

  /// Carries packets until one is to be read from another file, for 100 ms at most, or a signal
  /// comes. Returns whether that file is to be read.
  bool carry_until_readable(int file);

 private:
  void take(std::size_t from);
  void deliver(std::size_t from);
  bool sleep(int file);

  std::array<int, 2> tuns_;
  std::array<LinkDirection, 2> directions_;
};

}  // namespace stillgrid::network
