#include "shared/tools/segment_inspect/segment_summary.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::segment_inspect {
namespace {

constexpr std::size_t kMappedAtOnce = 16;

/// Publications seen by polling one segment.
struct Count {
  std::uint64_t start, first, last;  // snapshots: before, at the first change, at the last
  std::uint64_t first_ns = 0, last_ns = 0;

  void note(std::uint64_t snapshot_id, std::uint64_t now_ns) {
    if (snapshot_id <= last) return;
    last = snapshot_id;
    last_ns = now_ns;
    if (first_ns != 0) return;
    first = snapshot_id;
    first_ns = now_ns;
  }

  /// From the first change to the last, so that neither end of the watch cuts a period.
  [[nodiscard]] double rate_hz(double watch_s) const {
    if (last > first && last_ns > first_ns)
      return static_cast<double>(last - first) / (static_cast<double>(last_ns - first_ns) * 1e-9);
    return static_cast<double>(last - start) / watch_s;
  }
};

std::uint64_t latest_of(const publication::SegmentReader& reader) {
  return double_buffer::HardwareAtomics::load(*reader.buffer().latest, std::memory_order_acquire);
}

double time_to_watch_s(std::span<reading::ObservedSegment* const> living) {
  std::uint64_t longest_ns = 0;
  for (const reading::ObservedSegment* segment : living)
    longest_ns = std::max(longest_ns, segment->reader()->header().period_ns);
  return std::clamp(3.5 * static_cast<double>(longest_ns) * 1e-9, 0.3, 2.0);
}

}  // namespace

void measure_rates(std::span<reading::ObservedSegment> segments, std::optional<double> watch_s) {
  std::vector<reading::ObservedSegment*> living;
  std::vector<Count> counts;
  for (reading::ObservedSegment& segment : segments)
    if (segment.summary.state == reading::SegmentState::kAlive) living.push_back(&segment);
  const double length_s = watch_s.value_or(time_to_watch_s(living));
  if (living.empty() || length_s <= 0.0) return;
  for (const reading::ObservedSegment* segment : living) {
    const std::uint64_t n = latest_of(*segment->reader());
    counts.push_back({n, n, n});
  }
  const std::uint64_t end_ns = realtime::monotonic_ns() + realtime::to_ns(length_s);
  for (std::uint64_t now_ns = 0; now_ns < end_ns;) {
    std::this_thread::sleep_for(std::chrono::microseconds(500));
    now_ns = realtime::monotonic_ns();
    for (std::size_t i = 0; i < living.size(); ++i)
      counts[i].note(latest_of(*living[i]->reader()), now_ns);
  }
  for (std::size_t i = 0; i < living.size(); ++i)
    living[i]->summary.measured_rate_hz = counts[i].rate_hz(length_s);
}

std::vector<reading::SegmentSummary> survey(std::span<const publication::SegmentFile> files,
                                            std::optional<double> watch_s) {
  std::vector<reading::SegmentSummary> summaries;
  for (std::size_t begin = 0; begin < files.size(); begin += kMappedAtOnce) {
    std::vector<reading::ObservedSegment> observed;
    for (const publication::SegmentFile& file :
         files.subspan(begin, std::min(kMappedAtOnce, files.size() - begin)))
      observed.push_back(reading::observe(file));
    measure_rates(observed, watch_s);
    for (reading::ObservedSegment& segment : observed) {
      reading::look_again(segment);
      if (segment.summary.state != reading::SegmentState::kGone)
        summaries.push_back(segment.summary);
    }
  }
  return summaries;
}

bool remove_leftover(const publication::SegmentFile& file) {
  // The object's own lock is asked too: who deletes a lock file does not kill its holder.
  return reading::observe(file).summary.is_leftover &&
         publication::session_owner(file.session) == ::geteuid() &&
         publication::remove_dead_segment(file.session, file.kind);
}

}  // namespace stillgrid::segment_inspect
