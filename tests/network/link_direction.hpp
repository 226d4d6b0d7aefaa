#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "tests/network/link_settings.hpp"

namespace stillgrid::network {

/// Of packets. At any moment sent + duplicated is the sum of all below, and of those on their way.
struct LinkCounters {
  std::uint64_t sent = 0, duplicated = 0;
  std::uint64_t delivered = 0, lost = 0, partitioned = 0;
  std::uint64_t overflowed = 0;  // beyond what the rate lets through
  std::uint64_t refused = 0;     // by the receiver's kernel
  // Of those that went on their way:
  std::uint64_t reordered = 0, corrupted = 0;
  std::uint64_t delivered_bytes = 0;
};

/// One direction of a link: decides of each packet whether, when and how often it arrives, and
/// keeps it until then. The same seed and the same packets at the same times have the same fate.
/// Knows no clock.
class LinkDirection {
 public:
  explicit LinkDirection(std::uint64_t seed) : random_(seed) {}

  LinkSettings settings;  // of packets that are sent from now on

  /// Pre: now_ns never decreases.
  void send(std::span<const std::uint8_t> packet, std::uint64_t now_ns);

  /// Calls deliver(packet) for each that is due, in the order in which they are; it returns false
  /// where the receiver refuses.
  template <class Deliver>
  void deliver_due(std::uint64_t now_ns, const Deliver& deliver) {
    while (!on_their_way_.empty() && on_their_way_.front().due_ns <= now_ns) {
      const Packet packet = take_first();
      count_arrival(packet.bytes.size(), deliver(std::span<const std::uint8_t>(packet.bytes)));
    }
  }

  /// When the next is due; nothing where none is on its way.
  [[nodiscard]] std::optional<std::uint64_t> next_due_ns() const;

  [[nodiscard]] const LinkCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] std::size_t on_their_way() const noexcept { return on_their_way_.size(); }

 private:
  struct Packet {
    std::uint64_t due_ns = 0, number = 0;
    std::vector<std::uint8_t> bytes;
  };
  static bool is_later(const Packet& a, const Packet& b);

  void enqueue(std::vector<std::uint8_t> bytes, std::uint64_t now_ns);
  std::optional<std::uint64_t> serialised_ns(std::size_t size, std::uint64_t now_ns);
  double jitter_ms(std::uint64_t now_ns);
  Packet take_first();
  void count_arrival(std::size_t size, bool is_accepted);
  double draw();

  std::mt19937_64 random_;
  std::vector<Packet> on_their_way_;  // a heap, the first due in front
  std::uint64_t number_ = 0, last_due_ns_ = 0, free_at_ns_ = 0;
  std::uint64_t knot_ns_ = 0;                    // where the jitter last was at a drawn value
  double jitter_before_ = 0, jitter_after_ = 0;  // at that knot and the next, share of jitter_ms
  LinkCounters counters_;
};

}  // namespace stillgrid::network
