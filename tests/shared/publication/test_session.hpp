#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "shared/publication/segment.hpp"

namespace stillgrid::publication {

/// A session name that nobody else uses; what it left in shared memory goes with this object.
class TestSession {
 public:
  TestSession();
  ~TestSession();
  TestSession(const TestSession&) = delete;
  TestSession& operator=(const TestSession&) = delete;

  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  /// File of the object that bears the session's name.
  [[nodiscard]] std::string path(proto::SegmentKind kind) const;

 private:
  std::string name_;
};

/// A small segment of 64-bit numbers, for tests of what all segments have in common.
[[nodiscard]] SegmentSpec small_spec(proto::SegmentKind kind = proto::SegmentKind::kScene);
inline constexpr std::uint64_t kSmallLayoutHash = 0x5EED;
inline constexpr std::size_t kSmallPayloadWords = 64;

[[nodiscard]] std::optional<SegmentReader> open_small(const TestSession& session);

/// Publishes snapshot n of a small segment: every word is word_of(n).
void publish_small(const double_buffer::DoubleBuffer& buffer, std::uint64_t n);
[[nodiscard]] std::uint64_t word_of(std::uint64_t snapshot_id);

/// What a refusal says; empty if the call does not refuse.
template <class Call>
std::string refusal_of(Call&& call) {
  try {
    call();
  } catch (const SegmentError& error) {
    return error.what();
  }
  return {};
}

}  // namespace stillgrid::publication
