#include <algorithm>
#include <cstdio>
#include <optional>

#include "shared/publication/segment_watch.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/rights/realtime_rights.hpp"
#include "tests/soak/soak_processes.hpp"
#include "tests/soak/soak_snapshot.hpp"

namespace stillgrid::soak {
namespace {

struct SoakView {
  explicit SoakView(publication::SegmentReader&& opened) : reader_(std::move(opened)) {}
  [[nodiscard]] const publication::SegmentReader& reader() const noexcept { return reader_; }

 private:
  publication::SegmentReader reader_;
};

/// The reader without its last check: what follows the fence R4 is answered with what R2 saw.
struct WithoutLastCheck : double_buffer::HardwareAtomics {
  static inline std::uint64_t seen = 0;
  static inline bool is_fenced = false;
  static std::uint64_t load(const std::uint64_t& word, std::memory_order order) {
    if (!std::exchange(is_fenced, false)) seen = double_buffer::HardwareAtomics::load(word, order);
    return seen;
  }
  static void fence(std::memory_order order) {
    double_buffer::HardwareAtomics::fence(order);
    is_fenced = true;
  }
};

template <class Atomics>
class SoakReader {
 public:
  SoakReader(const SoakPlan& plan, SoakState& state)
      : plan_(plan), state_(state), tally_(state.reader) {}

  void tick(const publication::SegmentReader& segment, bool writer_alive) {
    take_up(segment);
    if (was_alive_ && !writer_alive) ++tally_.deaths_seen;
    was_alive_ = writer_alive;
    Gathered gathered;
    const std::uint64_t began_ns = realtime::monotonic_ns();
    const double_buffer::ReadResult read =
        double_buffer::read_latest<Atomics>(segment.buffer(), [&](const auto* payload) {
          gathered = plan_.words_a_tick == 0
                         ? gather_all(payload, plan_.words())
                         : gather_strewn(payload, plan_.words(), plan_.words_a_tick, tally_.ticks);
        });
    const std::uint64_t ended_ns = realtime::monotonic_ns();
    if (read.status == double_buffer::ReadStatus::kEmpty) {
      ++(last_snapshot_id_ == 0 ? tally_.ticks_before_a_snapshot : tally_.backwards);
      return;
    }
    ++tally_.ticks;
    tally_.read_ns.record(ended_ns - began_ns);
    const bool is_accepted = read.status == double_buffer::ReadStatus::kAccepted;
    ++tally_.failed_attempts.at(static_cast<std::size_t>(read.attempts - (is_accepted ? 1 : 0)));
    if (!is_accepted) {
      if (last_snapshot_id_ == 0) ++tally_.nothing_shown;
    } else {
      ++tally_.accepted;
      if (last_snapshot_id_ == 0) note_first_read(segment, ended_ns);
      count(gathered, read.snapshot_id);
    }
    if (plan_.kills > 0) inspect(segment);
  }

 private:
  void take_up(const publication::SegmentReader& segment) {
    if (segment.header().epoch == epoch_) return;
    epoch_ = segment.header().epoch;
    last_snapshot_id_ = 0;
    was_alive_ = false;
    ++tally_.segments;
  }

  void note_first_read(const publication::SegmentReader& segment, std::uint64_t time_ns) {
    if (state_.first_read_count == state_.first_reads.size()) return;
    state_.first_reads[state_.first_read_count++] = {segment.header().writer_pid, time_ns};
    state_.writer_read = segment.header().writer_pid;
  }

  void count(const Gathered& gathered, std::uint64_t snapshot_id) {
    const Verdict verdict = judge(gathered, epoch_, snapshot_id);
    if (verdict != Verdict::kWhole) ++tally_.torn;
    if (verdict == Verdict::kMixed) ++tally_.mixed;
    if (snapshot_id < last_snapshot_id_) ++tally_.backwards;
    if (snapshot_id > last_snapshot_id_) ++tally_.snapshots;
    last_snapshot_id_ = snapshot_id;
    state_.snapshot_id_read = snapshot_id;
  }

  /// Every word of the snapshot, where a tick reads only some. No tick waits for it: beside a
  /// writer at full speed it is often rejected, beside a dead one never.
  void inspect(const publication::SegmentReader& segment) {
    Gathered gathered;
    const double_buffer::ReadResult read = double_buffer::read_latest<Atomics>(
        segment.buffer(),
        [&](const auto* payload) { gathered = gather_all(payload, plan_.words()); });
    ++(read.status == double_buffer::ReadStatus::kAccepted ? tally_.inspected
                                                           : tally_.inspections_rejected);
    if (read.status == double_buffer::ReadStatus::kAccepted) count(gathered, read.snapshot_id);
  }

  const SoakPlan& plan_;
  SoakState& state_;
  ReaderTally& tally_;
  std::uint64_t epoch_ = 0, last_snapshot_id_ = 0;
  bool was_alive_ = false;
};

template <class Atomics>
void run_reader(const SoakPlan& plan, SoakState& state) {
  SoakReader<Atomics> reader(plan, state);
  publication::SegmentWatch<SoakView> watch(
      plan.session, proto::SegmentKind::kScene, kSoakLayoutHash, proto::Clock::kMonotonic,
      [&](const std::string& line) {
        ++state.reader.refusals;
        std::fprintf(stderr, "publication_soak: %s\n", line.c_str());
      });
  watch.start();
  std::optional<realtime::PeriodicTimer> timer;
  // A real-time thread that never rests would keep its processor from everybody else.
  if (plan.spacing_ns > 0 || plan.kills > 0) {
    const realtime::RealtimeRights rights = realtime::take_rights({});
    state.reader.realtime_missing = (rights.way == realtime::RealtimeRights::Way::kNone ? 1U : 0U) +
                                    (rights.is_memory_locked ? 0U : 1U);
    timer.emplace(kSoakTick_ns);
  }
  while (!state.reader_may_end) {
    if (timer) {
      const realtime::PeriodicTimer::Wake wake = timer->wait();
      state.reader.missed_ticks += wake.skipped > 0 ? 1 : 0;
      state.reader.wake_ns.record(wake.now_ns - wake.deadline_ns);
    }
    const SoakView* const view = watch.acquire();
    if (view == nullptr) continue;
    state.writer_alive = watch.writer_alive();
    reader.tick(view->reader(), state.writer_alive);
    if (plan.publications > 0 && state.snapshot_id_read == plan.publications) break;
  }
}

}  // namespace

void read_snapshots(const SoakPlan& plan, SoakState& state) {
  if (plan.skips_last_check) return run_reader<WithoutLastCheck>(plan, state);
  run_reader<double_buffer::HardwareAtomics>(plan, state);
}

}  // namespace stillgrid::soak
