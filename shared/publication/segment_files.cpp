#include "shared/publication/segment_files.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <set>
#include <system_error>
#include <thread>

namespace stillgrid::publication {
namespace {

using std::chrono::milliseconds;

constexpr std::string_view kLock = ".lock";
/// A writer that was killed, or told to stop, takes a moment to be gone; whoever restarts it at
/// once need not know.
constexpr auto kWriterEnds = milliseconds(1000);
constexpr auto kLockPoll = milliseconds(5);
constexpr std::atomic<bool> kNoStop = false;

/// An open-file-description lock over a whole file: freed by the kernel however its holder ends,
/// and unlike flock() it can be asked for without being taken (F_OFD_GETLK).
struct flock write_lock() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

/// Nothing while another holds the lock.
std::optional<FileDescriptor> try_lock(const std::string& path) {
  for (;;) {
    FileDescriptor file(::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (file.get() < 0) throw SegmentError("cannot open " + path + ": " + error_text(errno));
    require_owner(file.get(), ::geteuid(), path);
    if (!lock_object(file.get())) {
      if (errno == EAGAIN || errno == EACCES) return std::nullopt;
      throw SegmentError("cannot lock " + path + ": " + error_text(errno));
    }
    // Its last holder may have removed the file meanwhile: a lock on that one excludes nobody.
    if (bears_name(file.get(), path)) return file;
  }
}

/// Adds what stands in a user's folder, if it may be listed.
void list_folder(const std::filesystem::path& folder, uid_t owner,
                 std::vector<SegmentFile>& found) {
  const std::string user = owner == ::geteuid() ? "" : std::to_string(owner) + "/";
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    std::string file = entry.path().filename();
    if (file.ends_with(kLock)) file.resize(file.size() - kLock.size());
    for (const auto kind :
         {proto::SegmentKind::kScene, proto::SegmentKind::kTool, proto::SegmentKind::kMouse}) {
      const std::string_view ending = ending_of(kind);
      if (file.ends_with(ending) && file.size() > ending.size())
        found.push_back({user + file.substr(0, file.size() - ending.size()), kind});
    }
  }
}

}  // namespace

std::optional<gid_t> group_named(const std::string& name) {
  const struct group* const found = ::getgrnam(name.c_str());
  if (found == nullptr) return std::nullopt;
  return found->gr_gid;
}

std::string group_complaint(const std::string& name) {
  return group_named(name) ? "" : "value '" + name + "': expected the name of a group of users";
}

FileDescriptor::~FileDescriptor() {
  if (fd_ >= 0) ::close(fd_);
}

FileDescriptor open_as_found(const std::string& path) noexcept {
  return FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
}

void require_owner(int fd, uid_t owner, const std::string& path) {
  struct stat status {};
  if (::fstat(fd, &status) != 0)
    throw SegmentError("cannot look at " + path + ": " + error_text(errno));
  if (status.st_uid != owner)
    throw SegmentError("shared memory " + path + " is refused: it belongs to user " +
                       std::to_string(status.st_uid) + ", expected user " + std::to_string(owner));
}

SessionLock::SessionLock(std::string segment_path, FileDescriptor file) noexcept
    : segment_path_(std::move(segment_path)), file_(std::move(file)) {}

SessionLock::SessionLock(std::string_view session, proto::SegmentKind kind)
    : SessionLock(*take(session, kind, kNoStop)) {}

std::optional<SessionLock> SessionLock::try_take(std::string_view session,
                                                 proto::SegmentKind kind) {
  std::string path = own_segment_path(session, kind);
  auto file = try_lock(path + std::string(kLock));
  if (!file) return std::nullopt;
  return SessionLock(std::move(path), std::move(*file));
}

std::optional<SessionLock> SessionLock::take(std::string_view session, proto::SegmentKind kind,
                                             const std::atomic<bool>& stop) {
  for (auto waited = milliseconds(0);; waited += kLockPoll) {
    if (auto lock = try_take(session, kind)) return lock;
    if (waited >= kWriterEnds)
      throw SegmentError("session '" + std::string(session) +
                         "' already has a writer: stop it, or choose another --session");
    if (stop) return std::nullopt;
    std::this_thread::sleep_for(kLockPoll);
  }
}

SessionLock::~SessionLock() {
  if (file_.get() < 0) return;
  const std::string path = segment_path_ + std::string(kLock);
  if (bears_name(file_.get(), path)) ::unlink(path.c_str());  // while it is still held
}

bool is_writer_loading(std::string_view session, proto::SegmentKind kind) {
  const std::string path = segment_path(session, kind);
  if (path.empty()) return false;
  const FileDescriptor lock = open_as_found(path + ".lock"), object = open_as_found(path);
  const auto is_held = [](const FileDescriptor& file) {
    return file.get() >= 0 && is_object_locked(file.get());
  };
  return is_held(lock) && !is_held(object);
}

bool bears_name(int fd, const std::string& path) noexcept {
  struct stat of_fd {};
  struct stat of_path {};
  return ::fstat(fd, &of_fd) == 0 && ::stat(path.c_str(), &of_path) == 0 &&
         of_fd.st_dev == of_path.st_dev && of_fd.st_ino == of_path.st_ino;
}

bool lock_object(int fd) noexcept {
  struct flock lock = write_lock();
  return ::fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

bool is_object_locked(int fd) noexcept {
  struct flock lock = write_lock();
  // A reader may hold a read lock; to write-lock it would have to be allowed to write.
  return ::fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type == F_WRLCK;
}

std::optional<ObjectId> segment_id(std::string_view session, proto::SegmentKind kind) {
  struct stat status {};
  const std::string path = segment_path(session, kind);
  if (path.empty() || ::stat(path.c_str(), &status) != 0) return std::nullopt;
  return ObjectId{status.st_dev, status.st_ino};
}

std::vector<SegmentFile> list_segments() {
  std::vector<SegmentFile> found;
  std::set<uid_t> owners;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(kSharedMemory, error)) {
    const std::string folder = entry.path().filename();
    if (!folder.starts_with(kFolderPrefix)) continue;
    const std::string_view rest = std::string_view(folder).substr(kFolderPrefix.size());
    const auto owner = number_of_user(rest.substr(0, rest.find('.')));
    if (owner) owners.insert(*owner);
  }
  for (const uid_t owner : owners)
    if (const std::string folder = folder_of(owner); !folder.empty())
      list_folder(folder, owner, found);
  if (error)
    throw SegmentError("cannot list " + std::string(kSharedMemory) + ": " + error.message());
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

void remove_debris(const std::string& path) {
  const FileDescriptor file = open_as_found(path);
  if (file.get() < 0 && errno == ENOENT) return;
  std::uint64_t magic = 0;
  if (file.get() < 0 && errno != ELOOP)
    throw SegmentError("cannot open " + path + ": " + error_text(errno));
  const ssize_t bytes = file.get() < 0 ? -1 : ::pread(file.get(), &magic, sizeof magic, 0);
  const bool is_half_made = bytes == 0 || (bytes == sizeof magic && magic == 0);
  const bool is_segment = bytes == sizeof magic && magic == proto::kSegmentMagic;
  if (!is_half_made && !is_segment)
    throw SegmentError(path +
                       " is no segment of Stillgrid: remove it, or choose another --session");
  if (is_object_locked(file.get()))
    throw SegmentError(path + " has a writer: stop it, or choose another --session");
  if (::unlink(path.c_str()) != 0)
    throw SegmentError("cannot remove " + path + ": " + error_text(errno));
}

bool remove_dead_segment(std::string_view session, proto::SegmentKind kind) {
  if (session_owner(session) != ::geteuid())
    throw SegmentError("session '" + std::string(session) +
                       "' is another user's, who alone may remove what is left of it");
  const std::string path = segment_path(session, kind), lock_path = path + std::string(kLock);
  if (path.empty()) return false;
  if (::access(path.c_str(), F_OK) != 0 && ::access(lock_path.c_str(), F_OK) != 0) return false;
  const auto lock = try_lock(lock_path);
  if (!lock) return false;
  remove_debris(path);
  if (::unlink(lock_path.c_str()) != 0)
    throw SegmentError("cannot remove " + lock_path + ": " + error_text(errno));
  return true;
}

}  // namespace stillgrid::publication
