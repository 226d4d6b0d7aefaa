#include "shared/publication/segment.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/interprocess/shared_memory_object.hpp>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace stillgrid {
namespace {

namespace bip = boost::interprocess;

constexpr std::size_t kSlotHeaderBytes = sizeof(proto::SlotHeader);

std::size_t round_up(std::size_t bytes, std::size_t multiple) {
  return (bytes + multiple - 1) / multiple * multiple;
}

std::string error_text(int code) {
  return std::generic_category().message(code);
}

std::string lock_path(std::string_view session, proto::SegmentKind kind) {
  return "/dev/shm/" + segment_name(session, kind) + ".lock";
}

/// An open-file-description lock over a whole file: freed by the kernel however its holder ends,
/// and unlike flock() it can be asked for without being taken (F_OFD_GETLK).
struct flock write_lock() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

FileDescriptor lock_session(const std::string& path, std::string_view session) {
  FileDescriptor file(::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (file.get() < 0) throw SegmentError("cannot open " + path + ": " + error_text(errno));
  struct flock lock = write_lock();
  if (::fcntl(file.get(), F_OFD_SETLK, &lock) == 0) return file;
  const int code = errno;
  if (code == EAGAIN || code == EACCES)
    throw SegmentError("session '" + std::string(session) +
                       "' already has a writer: stop it, or choose another --session");
  throw SegmentError("cannot lock " + path + ": " + error_text(code));
}

FileDescriptor open_object(const std::string& name, int flags) {
  return FileDescriptor(::open(("/dev/shm/" + name).c_str(), flags | O_CLOEXEC | O_NOFOLLOW));
}

std::uint64_t random_epoch() {
  std::uint64_t epoch = 0;
  if (::getrandom(&epoch, sizeof epoch, 0) != sizeof epoch) epoch = 1;
  return std::max<std::uint64_t>(epoch, 1);
}

template <class Header>
DoubleBuffer buffer_over(Header& header, std::byte* base) {
  DoubleBuffer buffer;
  buffer.latest = const_cast<std::uint64_t*>(&header.latest);  // NOLINT: readers only load
  for (std::size_t slot = 0; slot < 2; ++slot) {
    std::byte* start = base + header.slot_offset[slot];
    buffer.sequence[slot] = reinterpret_cast<std::uint64_t*>(start);
    buffer.payload[slot] = reinterpret_cast<std::uint64_t*>(start + kSlotHeaderBytes);
  }
  return buffer;
}

/// A new object of that size, its pages reserved: memory that is short must be a message here, not
/// a SIGBUS later.
bip::mapped_region create_object(const std::string& name, std::size_t size_bytes) {
  try {
    bip::shared_memory_object::remove(name.c_str());
    bip::permissions owner_only(0600);
    bip::shared_memory_object object(bip::create_only, name.c_str(), bip::read_write, owner_only);
    const int fd = object.get_mapping_handle().handle;
    if (const int code = ::posix_fallocate(fd, 0, static_cast<off_t>(size_bytes)); code != 0) {
      bip::shared_memory_object::remove(name.c_str());
      throw SegmentError("cannot reserve " + std::to_string(size_bytes) +
                         " bytes of shared memory for " + name + ": " + error_text(code));
    }
    return {object, bip::read_write, 0, size_bytes};
  } catch (const bip::interprocess_exception& error) {
    throw SegmentError("cannot make shared memory " + name + ": " + error.what());
  }
}

void refuse(const std::string& name, const std::string& why) {
  throw SegmentError("shared memory " + name + " is refused: " + why);
}

void check_header(const proto::SegmentHeader& header, const std::string& name,
                  proto::SegmentKind kind, std::uint64_t layout_hash, std::size_t size_bytes) {
  if (header.version != proto::kSegmentVersion)
    refuse(name, "its writer speaks version " + std::to_string(header.version) +
                     ", this program version " + std::to_string(proto::kSegmentVersion));
  if (header.layout_hash != layout_hash || header.kind != kind)
    refuse(name, "its writer was built with another layout of the same version");
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
}

}  // namespace

std::string segment_name(std::string_view session, proto::SegmentKind kind) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  if (session.empty() || session.size() > 64 || session.front() == '.' ||
      !std::all_of(session.begin(), session.end(), is_allowed))
    throw SegmentError("value '" + std::string(session) +
                       "': expected 1 to 64 letters, digits, '_', '-' or '.'");
  return "stillgrid-" + std::string(session) +
         (kind == proto::SegmentKind::kScene ? "-scene" : "-tool");
}

FileDescriptor::~FileDescriptor() {
  if (fd_ >= 0) ::close(fd_);
}

std::string session_complaint(std::string_view session) {
  try {
    (void)segment_name(session, proto::SegmentKind::kScene);
    return {};
  } catch (const SegmentError& error) {
    return error.what();
  }
}

SegmentWriter::SegmentWriter(std::string_view session, const SegmentSpec& spec)
    : name_(segment_name(session, spec.kind)) {
  const std::size_t first_slot = round_up(spec.fixed_bytes, 64);
  const std::size_t slot_bytes = kSlotHeaderBytes + round_up(spec.payload_bytes, 64);
  const std::size_t size_bytes = round_up(first_slot + 2 * slot_bytes, 4096);

  session_lock_ = lock_session(lock_path(session, spec.kind), session);
  region_ = create_object(name_, size_bytes);
  object_lock_ = open_object(name_, O_RDWR);
  struct flock lock = write_lock();
  if (::fcntl(object_lock_.get(), F_OFD_SETLK, &lock) != 0) {
    bip::shared_memory_object::remove(name_.c_str());
    throw SegmentError("cannot lock shared memory " + name_ + ": " + error_text(errno));
  }
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
  // remove.
  bip::shared_memory_object::remove(name_.c_str());
}

void SegmentWriter::announce() noexcept {
  HardwareAtomics::store(header().magic, proto::kSegmentMagic, std::memory_order_release);
}

proto::SegmentHeader& SegmentWriter::header() noexcept {
  return *reinterpret_cast<proto::SegmentHeader*>(bytes());
}
std::byte* SegmentWriter::bytes() noexcept {
  return static_cast<std::byte*>(region_.get_address());
}

std::optional<SegmentReader> SegmentReader::open(std::string_view session, proto::SegmentKind kind,
                                                 std::uint64_t layout_hash) {
  const std::string name = segment_name(session, kind);
  SegmentReader reader;
  try {
    bip::shared_memory_object object(bip::open_only, name.c_str(), bip::read_only);
    struct stat status {};
    if (::fstat(object.get_mapping_handle().handle, &status) != 0) return std::nullopt;
    const auto size_bytes = static_cast<std::size_t>(status.st_size);
    if (size_bytes == 0) return std::nullopt;  // created, not sized yet
    if (size_bytes < sizeof(proto::SegmentHeader))
      refuse(name, "it has only " + std::to_string(size_bytes) + " bytes");
    reader.object_ =
        FileDescriptor(::fcntl(object.get_mapping_handle().handle, F_DUPFD_CLOEXEC, 0));
    reader.id_ = {status.st_dev, status.st_ino};
    // Faults are for now, not for the real-time loop's first tick.
    reader.region_ =
        bip::mapped_region(object, bip::read_only, 0, size_bytes, nullptr, MAP_POPULATE);
  } catch (const bip::interprocess_exception& error) {
    if (error.get_error_code() == bip::not_found_error) return std::nullopt;
    throw SegmentError("cannot open shared memory " + name + ": " + error.what());
  }
  const proto::SegmentHeader& header = reader.header();
  const std::uint64_t magic = HardwareAtomics::load(header.magic, std::memory_order_acquire);
  if (magic == 0) return std::nullopt;  // sized, not announced yet
  if (magic != proto::kSegmentMagic) refuse(name, "it is not a Stillgrid segment");
  check_header(header, name, kind, layout_hash, reader.region_.get_size());
  reader.buffer_ =
      buffer_over(header, const_cast<std::byte*>(reader.bytes()));  // NOLINT: loads only
  return reader;
}

const proto::SegmentHeader& SegmentReader::header() const noexcept {
  return *reinterpret_cast<const proto::SegmentHeader*>(bytes());
}
const std::byte* SegmentReader::bytes() const noexcept {
  return static_cast<const std::byte*>(region_.get_address());
}
std::size_t SegmentReader::fixed_bytes() const noexcept {
  return static_cast<std::size_t>(std::min(header().slot_offset[0], header().slot_offset[1]));
}

bool SegmentReader::writer_alive() const noexcept {
  struct flock lock = write_lock();
  return ::fcntl(object_.get(), F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

std::optional<ObjectId> segment_id(std::string_view session, proto::SegmentKind kind) {
  struct stat status {};
  if (::stat(("/dev/shm/" + segment_name(session, kind)).c_str(), &status) != 0)
    return std::nullopt;
  return ObjectId{status.st_dev, status.st_ino};
}

}  // namespace stillgrid
