#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace stillgrid::scene_relay {

/// The four stamps of an exchange [RFC 5905, section 8], ns: two on this machine's clock, two on
/// the other's.
struct Exchange {
  std::uint64_t sent_ns;            // ours
  std::uint64_t other_received_ns;  // the other's
  std::uint64_t other_sent_ns;      // the other's
  std::uint64_t received_ns;        // ours
};

/// How far the clock of the other machine is from this one's, from exchanges over the network.
///
/// Of the last exchanges the one of the shortest round trip counts: its offset is off by half that
/// trip at most, and by what the clocks drift during it and since. The offset in use follows it by
/// no more than kSlew, and half a millisecond at once, so that times told one after the other, a
/// millisecond apart, stay in order; it leaps only where what is used cannot be true, as after the
/// other machine slept.
/// Thread: one. Realtime: yes.
class ClockOffset {
 public:
  /// Of the time that passes.
  static constexpr double kSlew = 1e-3;
  /// Of any two clocks.
  static constexpr double kDrift = 1e-4;

  /// False, and nothing is changed, where no such exchange can have been.
  bool add(const Exchange& exchange) noexcept;

  /// After kEnough exchanges.
  [[nodiscard]] bool is_known() const noexcept { return count_ >= kEnough; }
  /// The other's clock less ours.
  [[nodiscard]] std::int64_t offset_ns() const noexcept { return offset_ns_; }
  /// By how much it may be off, at the last exchange; kDrift of the time since comes to it.
  [[nodiscard]] std::uint64_t bound_ns() const noexcept { return bound_ns_; }
  /// The shortest of the last ones.
  [[nodiscard]] std::uint64_t round_trip_ns() const noexcept { return round_trip_ns_; }

  /// A time of the other's clock on ours, and of ours on the other's; 0 and the last number where
  /// there is none.
  [[nodiscard]] std::uint64_t to_ours(std::uint64_t other_ns) const noexcept;
  [[nodiscard]] std::uint64_t to_others(std::uint64_t our_ns) const noexcept;

 private:
  static constexpr std::size_t kEnough = 3, kKept = 64;
  struct Kept {
    std::int64_t offset_ns = 0;
    std::uint64_t round_trip_ns = 0, error_ns = 0, at_ns = 0;
    [[nodiscard]] std::uint64_t bound_ns(std::uint64_t now_ns) const noexcept;
  };

  std::array<Kept, kKept> kept_{};
  std::size_t count_ = 0, next_ = 0;
  std::int64_t offset_ns_ = 0;
  std::uint64_t bound_ns_ = 0, round_trip_ns_ = 0, at_ns_ = 0;
};

}  // namespace stillgrid::scene_relay
