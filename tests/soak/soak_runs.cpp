#include "tests/soak/soak_runs.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <unordered_set>
#include <vector>

#include "shared/publication/segment.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "tests/soak/process.hpp"
#include "tests/soak/soak_processes.hpp"
#include "tests/soak/soak_snapshot.hpp"

namespace stillgrid::soak {
namespace {

constexpr proto::SegmentKind kKind = proto::SegmentKind::kScene;
constexpr std::uint64_t kPatience_ns = 10'000'000'000;
constexpr std::uint64_t kProgress_ns = 10'000'000'000;

void sleep_ns(std::uint64_t ns) {
  std::this_thread::sleep_for(std::chrono::nanoseconds(ns));
}

/// Says every 10 s how far it has come.
class Progress {
 public:
  void tell(std::uint64_t done, std::uint64_t all, const char* what) {
    if (realtime::monotonic_ns() < next_ns_) return;
    next_ns_ += kProgress_ns;
    std::fprintf(stderr, "publication_soak: %ju of %ju %s\n", std::uintmax_t{done},
                 std::uintmax_t{all}, what);
  }

 private:
  std::uint64_t next_ns_ = realtime::monotonic_ns() + kProgress_ns;
};

/// False when it did not come true in time or the user stopped it.
bool wait_until(const std::function<bool()>& condition) {
  const std::uint64_t give_up_ns = realtime::monotonic_ns() + kPatience_ns;
  while (!condition()) {
    if (realtime::stop_requested() || realtime::monotonic_ns() > give_up_ns) return false;
    sleep_ns(1'000'000);
  }
  return true;
}

bool ends_well(Process& process) {
  return wait_until([&] { return process.status().has_value(); }) && process.status() == 0;
}

/// Looks at what a killed writer left. `before`: the object that bore the name when it started.
Death examine(const SoakPlan& plan, const std::optional<publication::ObjectId>& before,
              KillTally& kills) {
  const auto id = publication::segment_id(plan.session, kKind);
  if (!id || id == before) return Death::kBeforeItsObject;
  const auto dead = publication::SegmentReader::open(plan.session, kKind, kSoakLayoutHash);
  if (!dead) return Death::kHalfMade;
  if (dead->writer_alive()) ++kills.locks_left;

  Gathered gathered;
  const double_buffer::ReadResult read = double_buffer::read_latest(
      dead->buffer(),
      [&](const std::uint64_t* payload) { gathered = gather_all(payload, plan.words()); });
  const bool is_whole = read.status == double_buffer::ReadStatus::kAccepted && read.attempts == 1 &&
                        judge(gathered, dead->header().epoch, read.snapshot_id) == Verdict::kWhole;
  if (read.status != double_buffer::ReadStatus::kEmpty && !is_whole) ++kills.snapshots_lost;
  for (const std::uint64_t* sequence : dead->buffer().sequence)
    if (double_buffer::load_word(sequence, 0) % 2 == 1) return Death::kInMidWrite;
  return read.status == double_buffer::ReadStatus::kEmpty ? Death::kBeforeAnSnapshot
                                                          : Death::kBetweenSnapshots;
}

/// One in five writers is killed while it starts, from its first instant on; the others live long
/// enough to be noticed.
std::uint64_t draw_life_ns(std::mt19937_64& random, bool is_last) {
  const bool dies_at_start = !is_last && random() % 5 == 0;
  std::uniform_int_distribution<std::uint64_t> start_ns(0, 3'000'000);
  std::uniform_int_distribution<std::uint64_t> run_ns(25'000'000, 65'000'000);
  return dies_at_start ? start_ns(random) : run_ns(random);
}

struct Killed {
  pid_t writer;
  std::uint64_t time_ns;
};

/// Kills one writer after another. False when the user stopped it or the reader has ended.
bool kill_writers(const SoakPlan& plan, SoakState& state, Process& reader, KillTally& kills,
                  std::vector<Killed>& killed) {
  std::mt19937_64 random(plan.seed);
  Progress progress;
  for (std::uint64_t i = 0; i < plan.kills && !realtime::stop_requested(); ++i) {
    const auto before = publication::segment_id(plan.session, kKind);
    Process writer([&] { write_snapshots(plan, state); });
    sleep_ns(draw_life_ns(random, i + 1 == plan.kills));
    if (writer.status() || reader.status()) return false;
    killed.push_back({writer.id(), realtime::monotonic_ns()});
    writer.kill();
    ++kills.deaths[static_cast<std::size_t>(examine(plan, before, kills))];
    progress.tell(i + 1, plan.kills, "writers killed");
  }
  return !realtime::stop_requested();
}

/// From each kill but the last to the first read of a later writer: the next one, or where that
/// died while it started, one after it. What follows the last kill waits for its death to be seen.
void measure_reads_after(const SoakState& state, const std::vector<Killed>& killed,
                         pid_t last_writer, KillTally& kills) {
  const auto* const end = state.first_reads.begin() + state.first_read_count;
  std::unordered_set<std::uint32_t> later{static_cast<std::uint32_t>(last_writer)};
  for (std::size_t i = killed.size(); i-- > 1;) {
    later.insert(static_cast<std::uint32_t>(killed[i].writer));
    const std::uint64_t kill_ns = killed[i - 1].time_ns;
    const auto* const after =
        std::partition_point(state.first_reads.begin(), end,
                             [&](const FirstRead& read) { return read.time_ns < kill_ns; });
    const auto* const read = std::find_if(
        after, end, [&](const FirstRead& first) { return later.contains(first.writer_pid); });
    if (read == end) continue;
    kills.read_ns.record(read->time_ns - kill_ns);
    kills.read_sum_ns += read->time_ns - kill_ns;
  }
}

std::uint64_t count_files(const std::string& session) {
  const auto files = publication::list_segments();
  return static_cast<std::uint64_t>(
      std::count_if(files.begin(), files.end(),
                    [&](const publication::SegmentFile& file) { return file.session == session; }));
}

/// Whatever way a soak ends, it leaves nothing in shared memory. Made before its processes, so that
/// these have ended when it goes.
struct Cleaner {
  const std::string& session;
  explicit Cleaner(const std::string& of) : session(of) {}
  Cleaner(const Cleaner&) = delete;
  Cleaner& operator=(const Cleaner&) = delete;
  ~Cleaner() {
    try {
      publication::remove_dead_segment(session, kKind);
    } catch (const publication::SegmentError& error) {
      std::fprintf(stderr, "publication_soak: %s\n", error.what());
    }
  }
};

}  // namespace

bool run_publications(const SoakPlan& plan, SoakState& state) {
  const Cleaner cleaner(plan.session);
  Process reader([&] { read_snapshots(plan, state); });
  Process writer([&] { write_snapshots(plan, state); });
  Progress progress;
  std::uint64_t last = 0, give_up_ns = realtime::monotonic_ns() + kPatience_ns;
  while (!reader.status()) {
    if (realtime::stop_requested() || writer.status() || realtime::monotonic_ns() > give_up_ns)
      return false;
    if (state.snapshot_id_read != last) give_up_ns = realtime::monotonic_ns() + kPatience_ns;
    last = state.snapshot_id_read;
    progress.tell(last, plan.publications, "publications");
    sleep_ns(5'000'000);
  }
  state.writer_may_end = true;
  return ends_well(reader) && ends_well(writer);
}

bool run_kills(const SoakPlan& plan, SoakState& state, KillTally& kills) {
  const Cleaner cleaner(plan.session);
  Process reader([&] { read_snapshots(plan, state); });
  std::vector<Killed> killed;
  if (!kill_writers(plan, state, reader, kills, killed)) return false;
  kills.last_death_seen = wait_until([&] { return !state.writer_alive; });
  bool is_well = true;
  {
    Process writer([&] { write_snapshots(plan, state); });
    kills.last_writer_read =
        wait_until([&] { return state.writer_read == static_cast<std::uint32_t>(writer.id()); });
    state.writer_may_end = true;
    state.reader_may_end = true;
    is_well = ends_well(writer) && ends_well(reader);
    measure_reads_after(state, killed, writer.id(), kills);
  }
  kills.leftovers = count_files(plan.session);
  return is_well;
}

}  // namespace stillgrid::soak
