#include "shared/tools/segment_inspect/segment_summary.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <system_error>
#include <thread>
#include <utility>

#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/segment_inspect/snapshot.hpp"

namespace stillgrid::segment_inspect {
namespace {

constexpr std::size_t kMappedAtOnce = 16;

/// Nothing if the file cannot be opened.
std::optional<bool> is_locked(const std::string& path) {
  const publication::FileDescriptor file = publication::open_as_found(path);
  if (file.get() < 0) return std::nullopt;
  return publication::is_object_locked(file.get());
}

/// What can be said of an object before it is mapped.
struct RawObject {
  bool is_there = false;
  bool is_regular = false;
  bool is_locked = false;
  std::uint64_t size_bytes = 0;
  std::uint64_t magic = 0;
};

RawObject raw_object(const std::string& path) {
  RawObject raw;
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return raw;
  raw.is_there = true;
  raw.is_regular = S_ISREG(status.st_mode);
  if (!raw.is_regular) return raw;
  raw.size_bytes = static_cast<std::uint64_t>(status.st_size);
  const publication::FileDescriptor file = publication::open_as_found(path);
  if (file.get() < 0) return raw;
  raw.is_locked = publication::is_object_locked(file.get());
  if (::pread(file.get(), &raw.magic, sizeof raw.magic, 0) != sizeof raw.magic) raw.magic = 0;
  return raw;
}

/// Refusals open with the object's name, which a summary has already.
std::string reason_in(const std::string& refusal) {
  constexpr std::string_view kOpening = " is refused: ";
  const std::size_t at = refusal.find(kOpening);
  return printable(at == std::string::npos ? refusal : refusal.substr(at + kOpening.size()));
}

void refuse(ObservedSegment& segment, const std::string& why) {
  segment.summary.state = SegmentState::kRefused;
  segment.summary.refusal = reason_in(why);
  segment.scene.reset();
  segment.tool.reset();
}

void open_segment(ObservedSegment& segment, const std::string& path) {
  const auto& [session, kind] = segment.summary.file;
  const bool is_scene = kind == proto::SegmentKind::kScene;
  auto reader = publication::SegmentReader::open(
      session, kind, is_scene ? proto::kSceneLayoutHash : proto::kToolLayoutHash);
  if (!reader) {
    const bool is_there = publication::segment_id(session, kind).has_value();
    // The lock file is its owner's alone: a group's reader can only ask the object.
    const bool has_writer =
        is_locked(path).value_or(false) || is_locked(path + ".lock").value_or(false);
    segment.summary.state = !is_there    ? SegmentState::kGone
                            : has_writer ? SegmentState::kStarting
                                         : SegmentState::kHalfMade;
    return;
  }
  if (is_scene)
    segment.scene.emplace(std::move(*reader));
  else
    segment.tool.emplace(std::move(*reader));
}

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

double time_to_watch_s(std::span<ObservedSegment* const> living) {
  std::uint64_t longest_ns = 0;
  for (const ObservedSegment* segment : living)
    longest_ns = std::max(longest_ns, segment->reader()->header().period_ns);
  return std::clamp(3.5 * static_cast<double>(longest_ns) * 1e-9, 0.3, 2.0);
}

}  // namespace

const publication::SegmentReader* ObservedSegment::reader() const noexcept {
  if (scene) return &scene->reader();
  return tool ? &tool->reader() : nullptr;
}

ObservedSegment observe(const publication::SegmentFile& file) {
  ObservedSegment segment;
  segment.summary.file = file;
  std::string path;
  try {
    path = publication::segment_path(file.session, file.kind);
  } catch (const publication::SegmentError&) {
    refuse(segment, "its name is none that a session can have");
    return segment;
  }
  if (path.empty()) return segment;  // its owner has no folder any more
  const RawObject raw = raw_object(path);
  segment.summary.size_bytes = raw.size_bytes;
  if (raw.is_there && !raw.is_regular) {  // to open a pipe would wait for its other end
    refuse(segment, "it is no shared-memory object");
    return segment;
  }
  try {
    open_segment(segment, path);
    look_again(segment);
  } catch (const std::exception& error) {
    refuse(segment, error.what());
  }
  const SegmentState state = segment.summary.state;
  segment.summary.is_leftover =
      state == SegmentState::kDead || state == SegmentState::kHalfMade ||
      (state == SegmentState::kGone && is_locked(path + ".lock") == false) ||
      (state == SegmentState::kRefused && raw.magic == proto::kSegmentMagic && !raw.is_locked);
  return segment;
}

void look_again(ObservedSegment& segment) {
  const publication::SegmentReader* reader = segment.reader();
  if (reader == nullptr) return;
  SegmentSummary& summary = segment.summary;
  const bool is_alive = reader->writer_alive();
  summary.state = is_alive ? SegmentState::kAlive : SegmentState::kDead;
  summary.header = reader->header();
  const proto::SegmentHeader& live = reader->live();
  for (const auto word :
       {&proto::SegmentHeader::latest, &proto::SegmentHeader::heartbeat_ns,
        &proto::SegmentHeader::lockstep_sample_ns, &proto::SegmentHeader::lockstep_event_ns})
    *summary.header.*word =
        double_buffer::HardwareAtomics::load(live.*word, std::memory_order_acquire);

  std::uint64_t stamp_ns = 0;
  summary.moving_spheres.reset();
  if (segment.scene) {
    summary.static_spheres = segment.scene->static_grid().shape.sphere_count;
    if (const auto snapshot = read_snapshot(*segment.scene, 0)) {
      summary.moving_spheres = snapshot->header.grid.sphere_count;
      stamp_ns = snapshot->header.publish_time_ns[0];
    }
  } else if (const auto snapshot = read_tool(*segment.tool)) {
    stamp_ns = snapshot->state.time_ns;
  }
  summary.age_s = age_of(stamp_ns, summary.header->clock, realtime::monotonic_ns());
  if (reader->is_lost()) refuse(segment, "it was shrunk by another program");
}

void measure_rates(std::span<ObservedSegment> segments, std::optional<double> watch_s) {
  std::vector<ObservedSegment*> living;
  std::vector<Count> counts;
  for (ObservedSegment& segment : segments)
    if (segment.summary.state == SegmentState::kAlive) living.push_back(&segment);
  const double length_s = watch_s.value_or(time_to_watch_s(living));
  if (living.empty() || length_s <= 0.0) return;
  for (const ObservedSegment* segment : living) {
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

std::vector<SegmentSummary> survey(std::span<const publication::SegmentFile> files,
                                   std::optional<double> watch_s) {
  std::vector<SegmentSummary> summaries;
  for (std::size_t begin = 0; begin < files.size(); begin += kMappedAtOnce) {
    std::vector<ObservedSegment> observed;
    for (const publication::SegmentFile& file :
         files.subspan(begin, std::min(kMappedAtOnce, files.size() - begin)))
      observed.push_back(observe(file));
    measure_rates(observed, watch_s);
    for (ObservedSegment& segment : observed) {
      look_again(segment);
      if (segment.summary.state != SegmentState::kGone) summaries.push_back(segment.summary);
    }
  }
  return summaries;
}

bool remove_leftover(const publication::SegmentFile& file) {
  // The object's own lock is asked too: who deletes a lock file does not kill its holder.
  return observe(file).summary.is_leftover &&
         publication::session_owner(file.session) == ::geteuid() &&
         publication::remove_dead_segment(file.session, file.kind);
}

std::optional<double> age_of(std::uint64_t stamp_ns, proto::Clock clock,
                             std::uint64_t now_ns) noexcept {
  if (clock != proto::Clock::kMonotonic || stamp_ns == 0 || stamp_ns > now_ns) return std::nullopt;
  return static_cast<double>(now_ns - stamp_ns) * 1e-9;
}

std::string printable(std::string_view text) {
  std::string line(text);
  for (char& c : line)
    if (c < ' ' || c > '~') c = '?';
  return line;
}

}  // namespace stillgrid::segment_inspect
