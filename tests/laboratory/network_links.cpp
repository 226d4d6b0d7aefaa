#include "tests/laboratory/network_links.hpp"

#include <algorithm>
#include <utility>

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::laboratory {

Packets::Packets(const PacketPath& path, std::uint64_t seed) : path_(path), random_(seed) {}

std::uint64_t Packets::delay_ns() {
  const double spread =
      path_.delay_jitter > 0.0 ? path_.delay_jitter * (2.0 * share_(random_) - 1.0) : 0.0;
  return realtime::to_ns(path_.delay_s * (1.0 + spread));
}

void ToolLink::send(const proto::ToolState& sample) {
  if (!packets_.is_lost()) in_flight_.push_back({sample, sample.time_ns + packets_.delay_ns()});
}

const std::optional<ArrivedSample>& ToolLink::newest(std::uint64_t now_ns) {
  std::erase_if(in_flight_, [&](const ArrivedSample& arrived) {
    if (arrived.arrival_ns > now_ns) return false;
    if (!newest_ || arrived.sample.time_ns > newest_->sample.time_ns) newest_ = arrived;
    return true;
  });
  return newest_;
}

SnapshotLink::SnapshotLink(const PacketPath& path, std::size_t bytes, std::uint64_t seed,
                           std::size_t kept)
    : packets_(path, seed),
      fragments_(std::max<std::size_t>(1, (bytes + kFragment_bytes - 1) / kFragment_bytes)),
      kept_(kept) {}

void SnapshotLink::send(SentSnapshot snapshot) {
  const std::uint64_t sent_ns = snapshot.times.publish_ns;
  replaced_ += std::erase_if(in_flight_, [&](InFlight& older) {
    return ++older.newer >= kept_ && older.last_asked_ns > 0 && older.last_asked_ns >= sent_ns;
  });
  InFlight sent{{std::move(snapshot), sent_ns}};
  std::uint64_t round_ns = sent_ns;
  for (std::size_t missing = fragments_; missing > 0;) {
    std::size_t lost = 0;
    for (std::size_t i = 0; i < missing; ++i) {
      if (packets_.is_lost())
        ++lost;
      else
        sent.arrival_ns = std::max(sent.arrival_ns, round_ns + packets_.delay_ns());
    }
    missing = lost;
    // The receiver misses it a way later and asks; what it asks by may be lost as well.
    bool is_unheard = missing > 0;
    while (is_unheard) {
      round_ns += packets_.delay_ns() + packets_.delay_ns();
      is_unheard = packets_.is_lost();
      sent.last_asked_ns = round_ns;
    }
  }
  in_flight_.push_back(std::move(sent));
}

std::vector<ArrivedSnapshot> SnapshotLink::take(std::uint64_t now_ns) {
  const auto first_taken =
      std::stable_partition(in_flight_.begin(), in_flight_.end(),
                            [now_ns](const InFlight& sent) { return sent.arrival_ns > now_ns; });
  std::stable_sort(first_taken, in_flight_.end(), [](const InFlight& a, const InFlight& b) {
    return a.arrival_ns < b.arrival_ns;
  });
  std::vector<ArrivedSnapshot> taken;
  for (auto sent = first_taken; sent != in_flight_.end(); ++sent) {
    const std::uint64_t sent_ns = sent->snapshot.times.publish_ns;
    if (sent->arrival_ns - sent_ns > kOldestSnapshot_ns) {
      ++late_;
      continue;
    }
    if (has_shown_ && sent_ns <= shown_ns_) continue;
    has_shown_ = true;
    shown_ns_ = sent_ns;
    taken.push_back(std::move(*sent));
  }
  in_flight_.erase(first_taken, in_flight_.end());
  return taken;
}

}  // namespace stillgrid::laboratory
