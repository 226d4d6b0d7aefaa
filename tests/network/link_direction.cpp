#include "tests/network/link_direction.hpp"

#include <algorithm>
#include <utility>

#include "tests/network/flipped_bits.hpp"

namespace stillgrid::network {
namespace {

constexpr double kNs_per_ms = 1e6;
constexpr double kLongestBacklog_ns = 100e6;
constexpr double kJitterKnots_ns = 10e6;

std::uint64_t to_ns(double time_ms) {
  return static_cast<std::uint64_t>(time_ms * kNs_per_ms);
}

}  // namespace

void LinkDirection::send(std::span<const std::uint8_t> packet, std::uint64_t now_ns) {
  ++counters_.sent;
  if (settings.is_partitioned) {
    ++counters_.partitioned;
    return;
  }
  if (draw() < settings.loss) {
    ++counters_.lost;
    return;
  }
  std::vector<std::uint8_t> bytes(packet.begin(), packet.end());
  if (draw() < settings.corrupt && flip_unseen(bytes, random_)) ++counters_.corrupted;
  if (draw() < settings.duplicate) {
    ++counters_.duplicated;
    enqueue(bytes, now_ns);
  }
  enqueue(std::move(bytes), now_ns);
}

void LinkDirection::enqueue(std::vector<std::uint8_t> bytes, std::uint64_t now_ns) {
  const std::optional<std::uint64_t> passed_ns = serialised_ns(bytes.size(), now_ns);
  if (!passed_ns) {
    ++counters_.overflowed;
    return;
  }
  std::uint64_t due_ns = *passed_ns + to_ns(settings.delay_ms + jitter_ms(now_ns));
  if (draw() < settings.reorder) {
    ++counters_.reordered;
    due_ns += to_ns(settings.reorder_ms);
  } else {
    last_due_ns_ = due_ns = std::max(due_ns, last_due_ns_);
  }
  on_their_way_.push_back({due_ns, ++number_, std::move(bytes)});
  std::push_heap(on_their_way_.begin(), on_their_way_.end(), is_later);
}

/// When the last bit of a packet has passed a link of this rate; nothing if it would wait too long.
std::optional<std::uint64_t> LinkDirection::serialised_ns(std::size_t size, std::uint64_t now_ns) {
  if (settings.rate_Mbit_per_s <= 0.0) return now_ns;
  const std::uint64_t begin_ns = std::max(now_ns, free_at_ns_);
  if (static_cast<double>(begin_ns - now_ns) > kLongestBacklog_ns) return std::nullopt;
  const double bits = 8.0 * static_cast<double>(size);
  free_at_ns_ = begin_ns + static_cast<std::uint64_t>(bits * 1e3 / settings.rate_Mbit_per_s);
  return free_at_ns_;
}

/// Drawn anew at knots in time and linear between them: drawn for each packet, the kept order would
/// make the largest value of many packets a constant delay. Knots are so far apart that the delay
/// never falls faster than time passes.
double LinkDirection::jitter_ms(std::uint64_t now_ns) {
  if (settings.jitter_ms <= 0.0) return 0.0;
  const auto spacing_ns =
      static_cast<std::uint64_t>(std::max(kJitterKnots_ns, settings.jitter_ms * kNs_per_ms));
  if (const std::uint64_t knots = (now_ns - knot_ns_) / spacing_ns; knots > 0) {
    jitter_before_ = knots > 1 ? draw() : jitter_after_;
    jitter_after_ = draw();
    knot_ns_ += knots * spacing_ns;
  }
  const double share = static_cast<double>(now_ns - knot_ns_) / static_cast<double>(spacing_ns);
  return settings.jitter_ms * (jitter_before_ + share * (jitter_after_ - jitter_before_));
}

std::optional<std::uint64_t> LinkDirection::next_due_ns() const {
  if (on_their_way_.empty()) return std::nullopt;
  return on_their_way_.front().due_ns;
}

bool LinkDirection::is_later(const Packet& a, const Packet& b) {
  return std::pair(a.due_ns, a.number) > std::pair(b.due_ns, b.number);
}

LinkDirection::Packet LinkDirection::take_first() {
  std::pop_heap(on_their_way_.begin(), on_their_way_.end(), is_later);
  Packet packet = std::move(on_their_way_.back());
  on_their_way_.pop_back();
  return packet;
}

void LinkDirection::count_arrival(std::size_t size, bool is_accepted) {
  if (!is_accepted) {
    ++counters_.refused;
    return;
  }
  ++counters_.delivered;
  counters_.delivered_bytes += size;
}

/// In [0, 1).
double LinkDirection::draw() {
  return static_cast<double>(random_() >> 11) * 0x1p-53;
}

}  // namespace stillgrid::network
