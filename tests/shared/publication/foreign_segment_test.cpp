#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "shared/publication/segment.hpp"
#include "tests/shared/publication/tampering.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::foreign_segment_test {
namespace {

constexpr auto kScene = proto::SegmentKind::kScene;

std::string open_refusal(const TestSession& session) {
  const std::string refusal = refusal_of([&] { return open_small(session); });
  CHECK(refusal.find('\n') == std::string::npos);
  return refusal;
}

/// Puts an object of that size under the session's name; its bytes are `fill`.
void make_object(const TestSession& session, std::size_t size_bytes, std::byte fill) {
  const FileDescriptor file(
      ::open(session.path(kScene).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  REQUIRE(file.get() >= 0);
  REQUIRE((size_bytes == 0 || ::posix_fallocate(file.get(), 0, off_t(size_bytes)) == 0));
  if (size_bytes == 0) return;
  const Tampering object(session.path(kScene));
  std::fill(object.bytes().begin(), object.bytes().end(), fill);
}

/// An announced segment whose header a test may spoil.
struct Announced {
  TestSession session;
  SegmentWriter writer{session.name(), small_spec()};
  Announced() { writer.announce(); }
};

TEST_CASE("A segment of another version is refused and both versions are named",
          "[foreign_segment]") {
  Announced segment;
  segment.writer.header().version = 4711;

  const std::string refusal = open_refusal(segment.session);

  CHECK(refusal.find("4711") != std::string::npos);
  CHECK(refusal.find("this program version " + std::to_string(proto::kSegmentVersion)) !=
        std::string::npos);
}

TEST_CASE("A segment of another layout or kind is refused", "[foreign_segment]") {
  Announced segment;
  REQUIRE(open_refusal(segment.session).empty());
  SECTION("layout") {
    segment.writer.header().layout_hash ^= 1;
  }
  SECTION("kind") {
    segment.writer.header().kind = proto::SegmentKind::kTool;
  }
  CHECK(open_refusal(segment.session).find("another layout") != std::string::npos);
}

TEST_CASE("Foreign bytes under the name are refused", "[foreign_segment]") {
  const TestSession session;
  make_object(session, 8192, std::byte{0xAB});
  CHECK(open_refusal(session).find("not a Stillgrid segment") != std::string::npos);
}

TEST_CASE("An object without its bytes yet is not there yet", "[foreign_segment]") {
  const TestSession session;
  make_object(session, 0, std::byte{0});
  CHECK_FALSE(open_small(session));
  make_object(session, 8192, std::byte{0});
  CHECK_FALSE(open_small(session));
}

TEST_CASE("An object too short for a header is refused", "[foreign_segment]") {
  const TestSession session;
  const std::size_t size_bytes = GENERATE(1U, 8U, 447U);
  make_object(session, size_bytes, std::byte{0});
  CHECK(open_refusal(session).find(std::to_string(size_bytes) + " bytes") != std::string::npos);
}

TEST_CASE("A truncated segment is refused before it can be touched", "[foreign_segment]") {
  TestSession session;
  {
    SegmentWriter writer(session.name(), small_spec());
    writer.announce();
    // The same header in an object that ends within its first slot.
    const Tampering whole(session.path(kScene));
    const std::vector<std::byte> bytes(whole.bytes().begin(), whole.bytes().end());
    REQUIRE(::unlink(session.path(kScene).c_str()) == 0);
    make_object(session, 600, std::byte{0});
    const Tampering cut(session.path(kScene));
    std::copy_n(bytes.begin(), 600, cut.bytes().begin());

    CHECK(open_refusal(session).find("it has 600") != std::string::npos);
  }
}

TEST_CASE("A header whose slots lie outside the object is refused", "[foreign_segment]") {
  Announced segment;
  proto::SegmentHeader& header = segment.writer.header();
  const std::uint64_t size_bytes = header.size_bytes;
  const std::size_t slot = GENERATE(0U, 1U);

  SECTION("behind its end") {
    header.slot_offset[slot] = size_bytes;
  }
  SECTION("far behind its end") {
    header.slot_offset[slot] = UINT64_MAX - 63;
  }
  SECTION("across its end") {
    header.slot_offset[slot] = size_bytes - 64;
  }
  SECTION("over the header") {
    header.slot_offset[slot] = 0;
  }
  SECTION("not aligned") {
    header.slot_offset[slot] += 8;
  }
  SECTION("too large") {
    header.payload_bytes = size_bytes;
  }
  SECTION("far too large") {
    header.payload_bytes = UINT64_MAX - 7;
  }
  SECTION("of broken words") {
    header.payload_bytes -= 1;
  }

  CHECK(open_refusal(segment.session).find("slots do not fit") != std::string::npos);
}

TEST_CASE("A header that declares another size or no period is refused", "[foreign_segment]") {
  Announced segment;
  proto::SegmentHeader& header = segment.writer.header();
  SECTION("size") {
    header.size_bytes += 4096;
    CHECK(open_refusal(segment.session).find("its header says") != std::string::npos);
  }
  SECTION("no period") {
    header.period_ns = 0;
    CHECK(open_refusal(segment.session).find("its period is 0 ns") != std::string::npos);
  }
  SECTION("an endless period") {
    header.period_ns = UINT64_MAX;
    CHECK(open_refusal(segment.session).find("its period is") != std::string::npos);
  }
}

TEST_CASE("A header whose slots overlap is refused", "[foreign_segment]") {
  Announced segment;
  proto::SegmentHeader& header = segment.writer.header();
  header.slot_offset[1] = header.slot_offset[0] + 64;
  CHECK(open_refusal(segment.session).find("slots overlap") != std::string::npos);
}

TEST_CASE("An object with bytes that no memory stands behind is refused", "[foreign_segment]") {
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  const FileDescriptor object(::open(session.path(kScene).c_str(), O_RDWR | O_CLOEXEC));
  REQUIRE(::ftruncate(object.get(), off_t{1} << 40) == 0);
  CHECK(open_refusal(session).find("no memory stands behind") != std::string::npos);
}

TEST_CASE("A writer takes no name from a file that is not Stillgrid's", "[foreign_segment]") {
  const TestSession session;
  const std::size_t size_bytes = GENERATE(3U, 8192U);
  make_object(session, size_bytes, std::byte{0xAB});

  const std::string refusal =
      refusal_of([&] { const SegmentWriter writer(session.name(), small_spec()); });

  CHECK(refusal.find(session.path(kScene) + " is no segment") == 0);
  const Tampering still_there(session.path(kScene));
  CHECK(still_there.bytes().size() == size_bytes);
  CHECK(::access((session.path(kScene) + ".lock").c_str(), F_OK) != 0);
}

TEST_CASE("A pipe under the name is refused and keeps nobody waiting", "[foreign_segment]") {
  const TestSession session;
  REQUIRE(::mkfifo(session.path(kScene).c_str(), 0600) == 0);
  CHECK(open_refusal(session).find("not a file") != std::string::npos);
  CHECK(refusal_of([&] {
          const SegmentWriter writer(session.name(), small_spec());
        }).find("is no segment") != std::string::npos);
}

TEST_CASE("A writer whose lock file was removed by a stranger keeps its segment",
          "[foreign_segment]") {
  const Announced segment;
  REQUIRE(::unlink((segment.session.path(kScene) + ".lock").c_str()) == 0);
  CHECK(refusal_of([&] {
          const SegmentWriter second(segment.session.name(), small_spec());
        }).find("has a writer") != std::string::npos);
  CHECK_THROWS_AS(remove_dead_segment(segment.session.name(), kScene), SegmentError);
  CHECK(open_small(segment.session));
}

TEST_CASE("A writer replaces what a writer killed at its start had half made",
          "[foreign_segment]") {
  const TestSession session;
  make_object(session, GENERATE(0U, 8192U), std::byte{0});

  SegmentWriter writer(session.name(), small_spec());
  writer.announce();

  CHECK(open_small(session));
}

}  // namespace
}  // namespace stillgrid::publication::foreign_segment_test
