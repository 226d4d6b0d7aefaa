#include "shared/publication/segment_files.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace stillgrid {
namespace {

constexpr std::string_view kPrefix = "stillgrid-", kScene = "-scene", kTool = "-tool",
                           kLock = ".lock";

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
    if (!lock_object(file.get())) {
      if (errno == EAGAIN || errno == EACCES) return std::nullopt;
      throw SegmentError("cannot lock " + path + ": " + error_text(errno));
    }
    // Its last holder may have removed the file meanwhile: a lock on that one excludes nobody.
    if (bears_name(file.get(), path)) return file;
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
  return std::string(kPrefix) + std::string(session) +
         std::string(kind == proto::SegmentKind::kScene ? kScene : kTool);
}

std::string segment_path(std::string_view session, proto::SegmentKind kind) {
  return std::string(kSegmentFolder) + segment_name(session, kind);
}

std::string error_text(int code) {
  return std::generic_category().message(code);
}

std::string session_complaint(std::string_view session) {
  try {
    (void)segment_name(session, proto::SegmentKind::kScene);
    return {};
  } catch (const SegmentError& error) {
    return error.what();
  }
}

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

SessionLock::SessionLock(std::string_view session, proto::SegmentKind kind)
    : path_(segment_path(session, kind) + ".lock") {
  auto file = try_lock(path_);
  if (!file)
    throw SegmentError("session '" + std::string(session) +
                       "' already has a writer: stop it, or choose another --session");
  file_ = std::move(*file);
}

SessionLock::~SessionLock() {
  if (bears_name(file_.get(), path_)) ::unlink(path_.c_str());  // while it is still held
}

bool is_writer_loading(std::string_view session, proto::SegmentKind kind) {
  const std::string path = segment_path(session, kind);
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
  if (::stat(segment_path(session, kind).c_str(), &status) != 0) return std::nullopt;
  return ObjectId{status.st_dev, status.st_ino};
}

std::vector<SegmentFile> list_segments() {
  std::vector<SegmentFile> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(kSegmentFolder, error)) {
    std::string file = entry.path().filename();
    if (!file.starts_with(kPrefix)) continue;
    if (file.ends_with(kLock)) file.resize(file.size() - kLock.size());
    for (const auto& [ending, kind] : {std::pair{kScene, proto::SegmentKind::kScene},
                                       std::pair{kTool, proto::SegmentKind::kTool}}) {
      if (!file.ends_with(ending) || file.size() <= kPrefix.size() + ending.size()) continue;
      found.push_back(
          {file.substr(kPrefix.size(), file.size() - kPrefix.size() - ending.size()), kind});
    }
  }
  if (error)
    throw SegmentError("cannot list " + std::string(kSegmentFolder) + ": " + error.message());
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
  const std::string path = segment_path(session, kind), lock_path = path + ".lock";
  if (::access(path.c_str(), F_OK) != 0 && ::access(lock_path.c_str(), F_OK) != 0) return false;
  const auto lock = try_lock(lock_path);
  if (!lock) return false;
  remove_debris(path);
  if (::unlink(lock_path.c_str()) != 0)
    throw SegmentError("cannot remove " + lock_path + ": " + error_text(errno));
  return true;
}

}  // namespace stillgrid
