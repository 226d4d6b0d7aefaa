#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <thread>

#include "shared/publication/tool_segment.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::tool_path_test {
namespace {

/// All of whose numbers tell which it is.
proto::ToolState state_of(std::uint64_t n) {
  const auto x = 1e-6 * static_cast<double>(n);
  const double half_rad = 1e-3 * static_cast<double>(n % 1000);
  proto::ToolState state{};
  state.path_number = n;
  state.position_m = {x, 2.0 * x, 3.0 * x};
  state.orientation_xyzw = {0.0, std::sin(half_rad), 0.0, std::cos(half_rad)};
  state.velocity_m_s = {-x, -2.0 * x, -3.0 * x};
  return state;
}

bool is_sample_of(const proto::PathSample& sample, std::uint64_t n) {
  const proto::ToolState state = state_of(n);
  return sample.number == n && sample.position_m == state.position_m &&
         sample.orientation_xyzw == state.orientation_xyzw &&
         sample.velocity_m_s == state.velocity_m_s;
}

/// A tool's segment and a reader of it.
class PathBed {
 public:
  void publish(std::uint64_t n) { publish(state_of(n)); }
  void publish(const proto::ToolState& state) { writer_.publish(state); }
  [[nodiscard]] const ToolView& view() const noexcept { return view_; }
  [[nodiscard]] PathView path() const noexcept { return view_.path(); }
  [[nodiscard]] bool has(std::uint64_t n) const {
    const auto sample = path().sample(n);
    return sample && is_sample_of(*sample, n);
  }
  /// What a hostile writer may change.
  [[nodiscard]] proto::ToolPath& shared() {
    return *reinterpret_cast<proto::ToolPath*>(reinterpret_cast<std::byte*>(&writer_.header()) +
                                               sizeof(proto::SegmentHeader));
  }

 private:
  TestSession session_;
  ToolWriter writer_{session_.name(), 1'000'000, proto::Clock::kVirtual, 0};
  ToolView view_{
      *SegmentReader::open(session_.name(), proto::SegmentKind::kTool, proto::kToolLayoutHash)};
};

TEST_CASE("A path without samples has none, not even the number of none", "[tool_path]") {
  PathBed bed;
  CHECK_FALSE(bed.path().newest());
  for (const std::uint64_t n : {std::uint64_t{0}, std::uint64_t{1}, proto::kNever})
    CHECK_FALSE(bed.path().sample(n));

  bed.publish(proto::kNever);
  CHECK_FALSE(bed.path().newest());
  CHECK_FALSE(bed.path().sample(proto::kNever));
  bed.publish(0);
  CHECK(bed.path().newest() == 0);
  CHECK(bed.has(0));
}

TEST_CASE("A path keeps its last samples and no overwritten one", "[tool_path]") {
  PathBed bed;
  constexpr std::uint64_t kLast = 2 * proto::kPathLength + 100;
  for (std::uint64_t n = 0; n <= kLast; ++n) bed.publish(n);
  CHECK(bed.path().newest() == kLast);
  std::uint64_t kept = 0;
  for (std::uint64_t n = 0; n <= kLast + proto::kPathLength; ++n) {
    if (bed.has(n) != (n <= kLast && n + proto::kPathLength > kLast)) FAIL_CHECK(n);
    if (bed.has(n)) ++kept;
  }
  CHECK(kept == proto::kPathLength);
}

TEST_CASE("Of two states in one tick the path takes the first, and it never goes back",
          "[tool_path]") {
  PathBed bed;
  bed.publish(7);
  proto::ToolState state = state_of(8);
  state.path_number = 7;
  bed.publish(state);
  CHECK(bed.has(7));
  CHECK(bed.view().read()->position_m == state.position_m);  // it is the newest state all the same
  bed.publish(9);
  bed.publish(8);
  CHECK(bed.path().newest() == 9);
  CHECK_FALSE(bed.path().sample(8));
}

TEST_CASE("A sample that is being written, is none or lies is as if there were none",
          "[tool_path]") {
  PathBed bed;
  const auto is_taken = [&](auto&& spoil) {
    proto::PathSample& sample = bed.shared().samples[5];
    const proto::ToolState sound = state_of(5);
    sample = {5, sound.position_m, sound.orientation_xyzw, sound.velocity_m_s};
    spoil(sample);
    return bed.path().sample(5).has_value();
  };
  REQUIRE(is_taken([](auto&) {}));
  CHECK_FALSE(is_taken([](auto& sample) { sample.number = proto::kNever; }));
  CHECK_FALSE(is_taken([](auto& sample) { sample.number = 5 + proto::kPathLength; }));
  for (const double bad : {std::nan(""), double{INFINITY}, -double{INFINITY}, -1.1e6, 1e300})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK_FALSE(is_taken([&](auto& sample) { sample.position_m[axis] = bad; }));
      CHECK_FALSE(is_taken([&](auto& sample) { sample.velocity_m_s[axis] = bad; }));
      CHECK_FALSE(is_taken([&](auto& sample) { sample.orientation_xyzw[axis] = bad; }));
    }
  CHECK_FALSE(is_taken([](auto& sample) { sample.orientation_xyzw = {}; }));
  CHECK_FALSE(is_taken([](auto& sample) { sample.orientation_xyzw[3] = 1.1; }));
}

TEST_CASE("A path of any bytes gives sound samples alone", "[tool_path]") {
  PathBed bed;
  for (std::uint64_t n = 0; n < 100; ++n) bed.publish(n);
  std::mt19937_64 random(11);
  auto* const bytes = reinterpret_cast<unsigned char*>(&bed.shared());
  std::size_t taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::size_t at = random() % (8 + 100 * sizeof(proto::PathSample));
    const unsigned char before = bytes[at];
    bytes[at] = static_cast<unsigned char>(random());
    const auto newest = bed.path().newest();
    for (const std::uint64_t n : {newest.value_or(0), at / sizeof(proto::PathSample), random()}) {
      const auto sample = bed.path().sample(n);
      if (!sample) continue;
      ++taken;
      REQUIRE(sample->number == n);
      REQUIRE(is_sound(*sample));
    }
    if (i % 2 == 0) bytes[at] = before;
  }
  CHECK(taken > 1000);
}

TEST_CASE("A tool segment without room for a path is refused", "[tool_path]") {
  const TestSession session;
  SegmentSpec spec = small_spec(proto::SegmentKind::kTool);
  spec.layout_hash = proto::kToolLayoutHash;
  spec.payload_bytes = 2 * sizeof(proto::ToolPath);  // the segment is large enough, not its start
  spec.fixed_bytes = sizeof(proto::SegmentHeader) + sizeof(proto::ToolPath) - 64;
  SegmentWriter writer(session.name(), spec);
  writer.announce();
  CHECK(refusal_of([&] {
          const ToolView view(*SegmentReader::open(session.name(), proto::SegmentKind::kTool,
                                                   proto::kToolLayoutHash));
        }).find("no room for the tool's path") != std::string::npos);
}

TEST_CASE("Beside a writer that never rests every taken sample is whole", "[tool_path]") {
  constexpr std::uint64_t kSamples = 400'000;
  PathBed bed;
  std::atomic<bool> is_over{false};
  std::thread writer([&] {
    for (std::uint64_t n = 0; n < kSamples; ++n) bed.publish(n);
    is_over = true;
  });
  std::uint64_t taken = 0, torn = 0, last = 0, backwards = 0;
  std::mt19937_64 random(5);
  while (!is_over) {
    const auto newest = bed.path().newest();
    if (!newest) continue;
    if (*newest < last) ++backwards;
    last = *newest;
    // The newest, and those that the writer is about to overwrite.
    const std::uint64_t kept = last - std::min<std::uint64_t>(last, proto::kPathLength - 1);
    for (const std::uint64_t n : {last, kept, kept + random() % 4})
      if (const auto sample = bed.path().sample(n)) {
        ++taken;
        if (!is_sample_of(*sample, n)) ++torn;
      }
  }
  writer.join();
  CHECK(taken > 100);
  CHECK(torn == 0);
  CHECK(backwards == 0);
  CHECK(bed.path().newest() == kSamples - 1);
}

}  // namespace
}  // namespace stillgrid::publication::tool_path_test
