#pragma once

#include <boost/interprocess/mapped_region.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "proto/segment_header.hpp"
#include "shared/double_buffer/double_buffer.hpp"
#include "shared/publication/mapping_guard.hpp"
#include "shared/publication/segment_files.hpp"

namespace stillgrid::publication {

/// A number that no other writer has, not 0; of the system's own.
[[nodiscard]] std::uint64_t random_epoch() noexcept;

/// The properties of a segment, as its writer declares them.
struct SegmentSpec {
  proto::SegmentKind kind;
  std::uint64_t layout_hash;
  std::uint64_t period_ns;
  proto::Clock clock;
  std::uint64_t start_ns;
  std::size_t fixed_bytes;    // from the segment's start to the first slot: header and static part
  std::size_t payload_bytes;  // of each slot
  std::optional<gid_t> readers = std::nullopt;  // a group that may read it too
};

/// The writer's end. Holds two kernel locks for its life: on the session's lock file, so that there
/// is one writer, and on the object it made, so that readers know of that very object whether its
/// writer lives. Makes a fresh object, never reuses one, and removes both files when it ends.
///
/// Use: construct, write the fixed part, announce(), publish.
/// Thread: one. Not real-time, but for publish() on buffer().
class SegmentWriter {
 public:
  /// Throws SegmentError if memory is short; nothing of others is touched. Pre: the lock is that of
  /// a segment of the spec's kind.
  SegmentWriter(SessionLock lock, const SegmentSpec& spec);

  /// The same by a lock of its own. Throws SegmentError also if another writer lives.
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
  [[nodiscard]] const double_buffer::DoubleBuffer& buffer() const noexcept { return buffer_; }

  /// Throws SegmentError once somebody has shrunk the object, for then nobody is reached any more.
  /// Realtime: yes, until it throws.
  void require_whole() const;

 private:
  std::string path_;
  SessionLock session_lock_;
  FileDescriptor object_lock_;
  boost::interprocess::mapped_region region_;
  std::optional<MappingGuard> guard_;
  double_buffer::DoubleBuffer buffer_;
};

/// A segment of another version or layout; its writer may be long dead.
class OtherBuildError : public SegmentError {
 public:
  OtherBuildError(const std::string& line, bool writer_is_alive)
      : SegmentError(line), writer_alive(writer_is_alive) {}
  bool writer_alive;
};

/// A reader's mapping, read-only. Checked before it is used: size, magic, version, layout, bounds.
/// Once somebody has shrunk the object it reads as zeros, and its writer counts as dead.
/// Thread: any.
class SegmentReader {
 public:
  SegmentReader(SegmentReader&&) noexcept = default;
  SegmentReader& operator=(SegmentReader&&) = delete;
  SegmentReader(const SegmentReader&) = delete;
  SegmentReader& operator=(const SegmentReader&) = delete;
  ~SegmentReader() = default;

  /// Maps the segment of that kind, or nothing while there is none or it is not announced yet.
  /// Throws SegmentError if what stands there cannot be ours: another user's than the session's
  /// owner, foreign, truncated, another version (both versions are named, OtherBuildError), or not
  /// permitted.
  static std::optional<SegmentReader> open(std::string_view session, proto::SegmentKind kind,
                                           std::uint64_t layout_hash);

  /// Maps the segment as open(). Throws SegmentError also where it is missing.
  static SegmentReader require(std::string_view session, proto::SegmentKind kind,
                               std::uint64_t layout_hash);

  /// Returns the copy of the header's constant part that open() checked.
  [[nodiscard]] const proto::SegmentHeader& header() const noexcept { return header_; }

  /// The header in place, of which only the atomic words may be loaded.
  [[nodiscard]] const proto::SegmentHeader& live() const noexcept;

  [[nodiscard]] const std::byte* bytes() const noexcept;
  [[nodiscard]] const double_buffer::DoubleBuffer& buffer() const noexcept { return buffer_; }
  [[nodiscard]] ObjectId id() const noexcept { return id_; }
  /// Name under which it was opened.
  [[nodiscard]] const std::string& session() const noexcept { return session_; }

  /// Bytes before the first slot.
  [[nodiscard]] std::size_t fixed_bytes() const noexcept;

  /// Whether the process that made this object still holds its lock, and the object is whole.
  /// Asking never takes the lock, so it cannot keep a writer out. One system call.
  [[nodiscard]] bool writer_alive() const noexcept;

  /// Whether somebody shrank the object. Realtime: yes.
  [[nodiscard]] bool is_lost() const noexcept { return guard_->is_lost(); }

 private:
  SegmentReader() = default;
  std::string session_;
  FileDescriptor object_;
  boost::interprocess::mapped_region region_;
  std::optional<MappingGuard> guard_;  // after the mapping: it stands for it
  proto::SegmentHeader header_{};
  double_buffer::DoubleBuffer buffer_;
  ObjectId id_;
};

/// Returns the line that refuses a segment of another clock than ours.
[[nodiscard]] std::string clock_refusal(std::string_view session, proto::SegmentKind kind,
                                        proto::Clock ours);

}  // namespace stillgrid::publication
