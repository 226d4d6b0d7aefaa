#pragma once

#include <sys/types.h>

#include <atomic>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/segment_header.hpp"
#include "shared/publication/segment_place.hpp"

namespace stillgrid::publication {

/// The number of a group of users, if there is one of that name.
[[nodiscard]] std::optional<gid_t> group_named(const std::string& name);

/// What is wrong with a group's name, or nothing: a check for command lines.
[[nodiscard]] std::string group_complaint(const std::string& name);

/// A file descriptor that closes itself.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) noexcept : fd_(fd) {}
  ~FileDescriptor();
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  [[nodiscard]] int get() const noexcept { return fd_; }

 private:
  int fd_ = -1;
};

/// Opens a file to read what is there, or holds no descriptor: errno says why. Follows no link, and
/// never waits, as for the other end of a pipe.
[[nodiscard]] FileDescriptor open_as_found(const std::string& path) noexcept;

/// Throws SegmentError unless that user owns the open file, whatever its mode lets others do.
void require_owner(int fd, uid_t owner, const std::string& path);

/// The right to write a session's segment: a kernel lock on a file beside it, freed however its
/// holder ends. Removes that file at the end. Thread: any.
class SessionLock {
 public:
  /// Waits up to a second for a holder that is about to end. Throws SegmentError where another
  /// still holds it then, and where its file is another user's.
  SessionLock(std::string_view session, proto::SegmentKind kind);

  /// The same; nothing where stop is set in the wait, which it ends within 5 ms.
  static std::optional<SessionLock> take(std::string_view session, proto::SegmentKind kind,
                                         const std::atomic<bool>& stop);

  /// The same without a wait: nothing where another holds it.
  static std::optional<SessionLock> try_take(std::string_view session, proto::SegmentKind kind);

  ~SessionLock();
  SessionLock(SessionLock&&) noexcept = default;
  SessionLock& operator=(SessionLock&&) = delete;
  SessionLock(const SessionLock&) = delete;
  SessionLock& operator=(const SessionLock&) = delete;

  /// Where its holder makes the segment's object.
  [[nodiscard]] const std::string& segment_path() const noexcept { return segment_path_; }

 private:
  SessionLock(std::string segment_path, FileDescriptor file) noexcept;

  std::string segment_path_;
  FileDescriptor file_;  // none: moved from
};

/// Whether somebody who lives holds a session's lock and has made no segment yet: sim_server, while
/// it loads its scene. Asking takes nothing.
[[nodiscard]] bool is_writer_loading(std::string_view session, proto::SegmentKind kind);

/// Whether the open file is the one that now stands at path.
[[nodiscard]] bool bears_name(int fd, const std::string& path) noexcept;

/// Takes the lock that tells readers of an object that its writer lives; false if it is held.
[[nodiscard]] bool lock_object(int fd) noexcept;

/// Whether somebody holds that lock. Asking never takes it. One system call.
[[nodiscard]] bool is_object_locked(int fd) noexcept;

/// Identity of a shared-memory object: a name made anew has another.
struct ObjectId {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  bool operator==(const ObjectId&) const = default;
};

/// The object that now bears the name, if any.
[[nodiscard]] std::optional<ObjectId> segment_id(std::string_view session, proto::SegmentKind kind);

/// A segment's object that stands in a user's folder, or its lock file alone.
struct SegmentFile {
  std::string session;
  proto::SegmentKind kind;
  auto operator<=>(const SegmentFile&) const = default;
};

/// Those of all users, by session. Throws SegmentError if shared memory cannot be listed.
[[nodiscard]] std::vector<SegmentFile> list_segments();

/// Removes an object that a killed writer left, if one is there. Throws SegmentError if it is
/// somebody else's file, if its writer lives, or if it may not. Pre: the session's lock is held.
void remove_debris(const std::string& path);

/// Removes what a killed writer of this user left, object and lock; false when its writer lives or
/// nothing was there. Throws SegmentError as remove_debris(), and for another user's session.
bool remove_dead_segment(std::string_view session, proto::SegmentKind kind);

}  // namespace stillgrid::publication
