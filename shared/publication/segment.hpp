#pragma once

#include <boost/interprocess/mapped_region.hpp>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "proto/segment_header.hpp"
#include "shared/publication/double_buffer.hpp"

namespace stillgrid {

/// A segment cannot be made or must be refused; what() is one line for the user.
class SegmentError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a session's segment is called in shared memory. Throws SegmentError unless the session is 1
/// to 64 letters, digits, '_', '-' or '.', with no '.' first.
[[nodiscard]] std::string segment_name(std::string_view session, proto::SegmentKind kind);

/// What is wrong with a session's name, or nothing: a check for command lines.
[[nodiscard]] std::string session_complaint(std::string_view session);

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

/// What a writer declares of its segment.
struct SegmentSpec {
  proto::SegmentKind kind;
  std::uint64_t layout_hash;
  std::uint64_t period_ns;
  proto::Clock clock;
  std::uint64_t start_ns;
  std::size_t fixed_bytes;    // from the segment's start to the first slot: header and static part
  std::size_t payload_bytes;  // of each slot
};

/// The writer's end. Holds two kernel locks for its life: on the session's permanent lock file, so
/// that there is one writer, and on the object it made, so that readers know of that very object
/// whether its writer lives. Makes a fresh object, never reuses one, and removes the name when it
/// ends.
///
/// Use: construct, write the fixed part, announce(), publish.
/// Thread: one. Not real-time, but for publish() on buffer().
class SegmentWriter {
 public:
  /// Throws SegmentError if another writer lives or memory is short; nothing of others is touched.
  SegmentWriter(std::string_view session, const SegmentSpec& spec);
  ~SegmentWriter();
  SegmentWriter(const SegmentWriter&) = delete;
  SegmentWriter& operator=(const SegmentWriter&) = delete;
  SegmentWriter(SegmentWriter&&) = delete;
  SegmentWriter& operator=(SegmentWriter&&) = delete;

  /// Lets readers in: stores the magic, after everything else.
  void announce() noexcept;

  [[nodiscard]] proto::SegmentHeader& header() noexcept;
  [[nodiscard]] std::byte* bytes() noexcept;
  [[nodiscard]] const DoubleBuffer& buffer() const noexcept { return buffer_; }

 private:
  std::string name_;
  FileDescriptor session_lock_;
  FileDescriptor object_lock_;
  boost::interprocess::mapped_region region_;
  DoubleBuffer buffer_;
};

/// Identity of a shared-memory object: a name made anew has another.
struct ObjectId {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  bool operator==(const ObjectId&) const = default;
};

/// A reader's mapping, read-only. Checked before it is used: size, magic, version, layout, bounds.
/// Thread: any.
class SegmentReader {
 public:
  /// Maps the segment of that kind, or nothing while there is none or it is not announced yet.
  /// Throws SegmentError if what stands there cannot be ours: foreign, truncated, another version
  /// (both versions are named), or not permitted.
  static std::optional<SegmentReader> open(std::string_view session, proto::SegmentKind kind,
                                           std::uint64_t layout_hash);

  [[nodiscard]] const proto::SegmentHeader& header() const noexcept;
  [[nodiscard]] const std::byte* bytes() const noexcept;
  [[nodiscard]] const DoubleBuffer& buffer() const noexcept { return buffer_; }
  [[nodiscard]] ObjectId id() const noexcept { return id_; }

  /// Bytes before the first slot.
  [[nodiscard]] std::size_t fixed_bytes() const noexcept;

  /// Whether the process that made this object still holds its lock. Asking never takes the lock,
  /// so it cannot keep a writer out. One system call.
  [[nodiscard]] bool writer_alive() const noexcept;

 private:
  SegmentReader() = default;
  FileDescriptor object_;
  boost::interprocess::mapped_region region_;
  DoubleBuffer buffer_;
  ObjectId id_;
};

/// The object that now bears the name, if any.
[[nodiscard]] std::optional<ObjectId> segment_id(std::string_view session, proto::SegmentKind kind);

}  // namespace stillgrid
