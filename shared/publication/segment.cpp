#include "shared/publication/segment.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <span>
#include <utility>

namespace stillgrid::publication {
namespace {

namespace bip = boost::interprocess;

constexpr std::size_t kSlotHeaderBytes = sizeof(proto::SlotHeader);

std::size_t round_up(std::size_t bytes, std::size_t multiple) {
  return (bytes + multiple - 1) / multiple * multiple;
}

double_buffer::DoubleBuffer buffer_over(const proto::SegmentHeader& header, std::byte* start) {
  double_buffer::DoubleBuffer buffer;
  buffer.latest = reinterpret_cast<std::uint64_t*>(start + offsetof(proto::SegmentHeader, latest));
  for (std::size_t slot = 0; slot < 2; ++slot) {
    std::byte* const slot_start = start + header.slot_offset[slot];
    buffer.sequence[slot] = reinterpret_cast<std::uint64_t*>(slot_start);
    buffer.payload[slot] = reinterpret_cast<std::uint64_t*>(slot_start + kSlotHeaderBytes);
  }
  return buffer;
}

/// A descriptor as Boost's mapped_region takes it.
struct Mappable {
  int fd;
  [[nodiscard]] bip::mapping_handle_t get_mapping_handle() const { return {fd, false}; }
};

struct Object {
  FileDescriptor file;
  bip::mapped_region region;
};

/// A new object, its pages reserved: memory that is short must be a message here, not a SIGBUS
/// later. Its lock is held, and the group may read it.
Object create_object(const std::string& path, std::size_t size_bytes,
                     std::optional<gid_t> readers) {
  remove_debris(path);
  FileDescriptor file(
      ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (file.get() < 0) throw SegmentError("cannot make " + path + ": " + error_text(errno));
  const auto require = [&](bool is_done, const std::string& what) {
    if (is_done) return;
    const int code = errno;
    ::unlink(path.c_str());
    throw SegmentError("cannot " + what + " for " + path + ": " + error_text(code));
  };
  errno = ::posix_fallocate(file.get(), 0, static_cast<off_t>(size_bytes));
  require(errno == 0, "reserve " + std::to_string(size_bytes) + " bytes of shared memory");
  require(lock_object(file.get()), "take the lock");
  require(!readers || ::fchown(file.get(), static_cast<uid_t>(-1), *readers) == 0, "set the group");
  require(!readers || ::fchmod(file.get(), 0640) == 0, "set the mode");
  bip::mapped_region region(Mappable{file.get()}, bip::read_write, 0, size_bytes);
  return {std::move(file), std::move(region)};
}

void refuse(const std::string& name, const std::string& why) {
  throw SegmentError("shared memory " + name + " is refused: " + why);
}

void check_build(const proto::SegmentHeader& header, const std::string& name,
                 proto::SegmentKind kind, std::uint64_t layout_hash, int object) {
  std::string why;
  if (header.version != proto::kSegmentVersion)
    why = "its writer speaks version " + std::to_string(header.version) +
          ", this program version " + std::to_string(proto::kSegmentVersion);
  else if (header.layout_hash != layout_hash || header.kind != kind)
    why = "its writer was built with another layout of the same version";
  if (!why.empty())
    throw OtherBuildError("shared memory " + name + " is refused: " + why,
                          is_object_locked(object));
}

void check_header(const proto::SegmentHeader& header, const std::string& name,
                  std::size_t size_bytes) {
  if (header.size_bytes != size_bytes)
    refuse(name, "its header says " + std::to_string(header.size_bytes) + " bytes, it has " +
                     std::to_string(size_bytes));
  if (header.period_ns == 0 || header.period_ns > 100'000'000'000ULL)
    refuse(name, "its period is " + std::to_string(header.period_ns) + " ns");
  if (header.payload_bytes % 8 != 0 || header.payload_bytes > size_bytes)
    refuse(name, "its slots do not fit");
  for (const std::uint64_t offset : header.slot_offset) {
    const bool fits = offset % 64 == 0 && offset >= sizeof(proto::SegmentHeader) &&
                      offset <= size_bytes &&
                      size_bytes - offset >= kSlotHeaderBytes + header.payload_bytes;
    if (!fits) refuse(name, "its slots do not fit");
  }
  const auto [low, high] = std::minmax(header.slot_offset[0], header.slot_offset[1]);
  if (high - low < kSlotHeaderBytes + header.payload_bytes) refuse(name, "its slots overlap");
}

/// Has every page mapped now, so that the real-time loop meets no fault.
void touch_pages(std::span<const std::byte> bytes) {
  for (std::size_t i = 0; i < bytes.size(); i += 4096)
    static_cast<void>(*static_cast<const volatile std::byte*>(&bytes[i]));
}

}  // namespace

std::uint64_t random_epoch() noexcept {
  std::uint64_t epoch = 0;
  if (::getrandom(&epoch, sizeof epoch, 0) != sizeof epoch) epoch = 1;
  return std::max<std::uint64_t>(epoch, 1);
}

SegmentWriter::SegmentWriter(std::string_view session, const SegmentSpec& spec)
    : SegmentWriter(SessionLock(session, spec.kind), spec) {}

SegmentWriter::SegmentWriter(SessionLock lock, const SegmentSpec& spec)
    : path_(lock.segment_path()), session_lock_(std::move(lock)) {
  const std::size_t first_slot = round_up(spec.fixed_bytes, 64);
  const std::size_t slot_bytes = kSlotHeaderBytes + round_up(spec.payload_bytes, 64);
  const std::size_t size_bytes = round_up(first_slot + 2 * slot_bytes, 4096);

  try {
    Object object = create_object(path_, size_bytes, spec.readers);
    object_lock_ = std::move(object.file);
    region_ = std::move(object.region);
  } catch (const bip::interprocess_exception& error) {
    throw SegmentError("cannot map " + path_ + ": " + error.what());
  }
  guard_.emplace(std::span(bytes(), size_bytes), MappingGuard::Access::kWrite);
  proto::SegmentHeader& fresh = header();
  fresh.version = proto::kSegmentVersion;
  fresh.kind = spec.kind;
  fresh.layout_hash = spec.layout_hash;
  fresh.epoch = random_epoch();
  fresh.size_bytes = size_bytes;
  fresh.period_ns = spec.period_ns;
  fresh.clock = spec.clock;
  fresh.writer_pid = static_cast<std::uint32_t>(::getpid());
  fresh.start_ns = spec.start_ns;
  fresh.slot_offset = {first_slot, first_slot + slot_bytes};
  fresh.payload_bytes = round_up(spec.payload_bytes, 8);
  buffer_ = buffer_over(fresh, bytes());
}

SegmentWriter::~SegmentWriter() {
  // The locks go last, with their descriptors: nobody may take the name over while it is ours to
  // remove. A stranger may have removed it before, and another writer have made its own.
  if (bears_name(object_lock_.get(), path_)) ::unlink(path_.c_str());
}

void SegmentWriter::require_whole() const {
  if (guard_->is_lost())
    throw SegmentError("shared memory " + path_ + " was shrunk by another program while in use");
}

void SegmentWriter::announce() noexcept {
  double_buffer::HardwareAtomics::store(header().magic, proto::kSegmentMagic,
                                        std::memory_order_release);
}

proto::SegmentHeader& SegmentWriter::header() noexcept {
  return *reinterpret_cast<proto::SegmentHeader*>(bytes());
}
std::byte* SegmentWriter::bytes() noexcept {
  return static_cast<std::byte*>(region_.get_address());
}

std::optional<SegmentReader> SegmentReader::open(std::string_view session, proto::SegmentKind kind,
                                                 std::uint64_t layout_hash) {
  const std::string name = segment_path(session, kind);
  if (name.empty()) return std::nullopt;
  SegmentReader reader;
  reader.session_ = session;
  // Not by the library, which would wait at a pipe for its other end.
  reader.object_ = open_as_found(name);
  if (reader.object_.get() < 0 && errno == ENOENT) return std::nullopt;
  struct stat status {};
  if (reader.object_.get() < 0 && errno == EACCES)
    throw SegmentError(
        "cannot open shared memory " + name +
        ": Permission denied: expected its writer to have --group, a group of yours");
  if (reader.object_.get() < 0 || ::fstat(reader.object_.get(), &status) != 0)
    throw SegmentError("cannot open shared memory " + name + ": " + error_text(errno));
  if (!S_ISREG(status.st_mode)) refuse(name, "it is not a file");
  require_owner(reader.object_.get(), session_owner(session), name);
  const auto size_bytes = static_cast<std::size_t>(status.st_size);
  if (size_bytes == 0) return std::nullopt;  // created, not sized yet
  if (size_bytes < sizeof(proto::SegmentHeader))
    refuse(name, "it has only " + std::to_string(size_bytes) + " bytes");
  if (status.st_blocks * 512 < status.st_size)  // to touch them may be a SIGBUS, or fill memory
    refuse(name, "no memory stands behind some of its bytes");
  reader.id_ = {status.st_dev, status.st_ino};
  try {
    reader.region_ =
        bip::mapped_region(Mappable{reader.object_.get()}, bip::read_only, 0, size_bytes);
  } catch (const bip::interprocess_exception& error) {
    throw SegmentError("cannot map shared memory " + name + ": " + error.what());
  }
  reader.guard_.emplace(std::span(reader.bytes(), size_bytes), MappingGuard::Access::kRead);
  const proto::SegmentHeader& live = reader.live();
  const std::uint64_t magic =
      double_buffer::HardwareAtomics::load(live.magic, std::memory_order_acquire);
  if (magic == 0) return std::nullopt;  // sized, not announced yet
  if (magic != proto::kSegmentMagic) refuse(name, "it is not a Stillgrid segment");
  // A copy, for what is checked here must be what is used later.
  reader.header_ = double_buffer::load_struct<proto::SegmentHeader>(
      reinterpret_cast<const std::uint64_t*>(&live));
  check_build(reader.header_, name, kind, layout_hash, reader.object_.get());
  check_header(reader.header_, name, reader.region_.get_size());
  touch_pages({reader.bytes(), reader.region_.get_size()});
  if (reader.is_lost()) refuse(name, "it was shrunk by another program");
  auto* const start = const_cast<std::byte*>(reader.bytes());  // NOLINT: loads only
  reader.buffer_ = buffer_over(reader.header_, start);
  return reader;
}

SegmentReader SegmentReader::require(std::string_view session, proto::SegmentKind kind,
                                     std::uint64_t layout_hash) {
  std::optional<SegmentReader> reader = open(session, kind, layout_hash);
  if (!reader) throw SegmentError("the session '" + std::string(session) + "' is gone");
  return std::move(*reader);
}

const proto::SegmentHeader& SegmentReader::live() const noexcept {
  return *reinterpret_cast<const proto::SegmentHeader*>(bytes());
}
const std::byte* SegmentReader::bytes() const noexcept {
  return static_cast<const std::byte*>(region_.get_address());
}
std::size_t SegmentReader::fixed_bytes() const noexcept {
  return static_cast<std::size_t>(std::min(header_.slot_offset[0], header_.slot_offset[1]));
}

bool SegmentReader::writer_alive() const noexcept {
  return !is_lost() && is_object_locked(object_.get());
}

std::string clock_refusal(std::string_view session, proto::SegmentKind kind, proto::Clock ours) {
  const bool is_scene = kind == proto::SegmentKind::kScene;
  const std::string theirs = is_scene ? "sim_server" : "haptic_server";
  return "the " + theirs + " of session '" + std::string(session) + "' runs in " +
         (ours == proto::Clock::kVirtual
              ? "real time: start it with --lockstep too"
              : "lockstep: start " + std::string(is_scene ? "haptic_server" : "sim_server") +
                    " with --lockstep too");
}

}  // namespace stillgrid::publication
