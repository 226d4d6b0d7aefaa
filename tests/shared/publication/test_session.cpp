#include "tests/shared/publication/test_session.hpp"

#include <unistd.h>

#include <array>

namespace stillgrid::publication {

TestSession::TestSession() {
  static int counter = 0;
  name_ = "test-" + std::to_string(::getpid()) + "-" + std::to_string(++counter);
}

TestSession::~TestSession() {
  for (const auto kind : {proto::SegmentKind::kScene, proto::SegmentKind::kTool}) {
    ::unlink(path(kind).c_str());
    ::unlink((path(kind) + ".lock").c_str());
  }
}

std::string TestSession::path(proto::SegmentKind kind) const {
  return own_segment_path(name_, kind);
}

SegmentSpec small_spec(proto::SegmentKind kind) {
  return {.kind = kind,
          .layout_hash = kSmallLayoutHash,
          .period_ns = 1'000'000,
          .clock = proto::Clock::kVirtual,
          .start_ns = 0,
          .fixed_bytes = sizeof(proto::SegmentHeader),
          .payload_bytes = kSmallPayloadWords * 8};
}

std::optional<SegmentReader> open_small(const TestSession& session) {
  return SegmentReader::open(session.name(), proto::SegmentKind::kScene, kSmallLayoutHash);
}

std::uint64_t word_of(std::uint64_t snapshot_id) {
  return (snapshot_id + 1) * 0x9E3779B97F4A7C15ULL;
}

void publish_small(const double_buffer::DoubleBuffer& buffer, std::uint64_t n) {
  std::array<std::uint64_t, kSmallPayloadWords> words{};
  words.fill(word_of(n));
  double_buffer::publish(buffer, n, {{0, words}});
}

}  // namespace stillgrid::publication
