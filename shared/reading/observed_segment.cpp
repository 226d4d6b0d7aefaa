#include "shared/reading/observed_segment.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <system_error>
#include <thread>
#include <utility>

#include "shared/publication/relay_figures.hpp"
#include "shared/reading/snapshot.hpp"
#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::reading {
namespace {

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
  segment.mouse.reset();
}

std::uint64_t layout_hash_of(proto::SegmentKind kind) {
  switch (kind) {
    case proto::SegmentKind::kScene:
      return proto::kSceneLayoutHash;
    case proto::SegmentKind::kTool:
      return proto::kToolLayoutHash;
    default:
      return proto::kMouseLayoutHash;
  }
}

void open_segment(ObservedSegment& segment, const std::string& path) {
  const auto& [session, kind] = segment.summary.file;
  auto reader = publication::SegmentReader::open(session, kind, layout_hash_of(kind));
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
  if (kind == proto::SegmentKind::kScene)
    segment.scene.emplace(std::move(*reader));
  else if (kind == proto::SegmentKind::kTool)
    segment.tool.emplace(std::move(*reader));
  else
    segment.mouse.emplace(std::move(*reader));
}

}  // namespace

const publication::SegmentReader* ObservedSegment::reader() const noexcept {
  if (scene) return &scene->reader();
  if (tool) return &tool->reader();
  return mouse ? &mouse->reader() : nullptr;
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
  } catch (const publication::OtherBuildError& error) {
    refuse(segment, error.what());
    segment.summary.is_other_build = true;
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
  summary.relay = publication::load_relay_figures(live);

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

}  // namespace stillgrid::reading
