#include "shared/publication/segment.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "tests/shared/publication/other_process.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::segment_test {
namespace {

constexpr auto kScene = proto::SegmentKind::kScene;

/// Whether the newest snapshot is there and all its words are of one snapshot.
bool shows_whole_snapshot(const SegmentReader& reader) {
  std::array<std::uint64_t, kSmallPayloadWords> words{};
  const double_buffer::ReadResult result =
      double_buffer::read_latest(reader.buffer(), [&](const std::uint64_t* payload) {
        words = double_buffer::load_struct<decltype(words)>(payload);
      });
  return result.status == double_buffer::ReadStatus::kAccepted &&
         std::all_of(words.begin(), words.end(),
                     [&](std::uint64_t word) { return word == word_of(result.snapshot_id); });
}

/// What a writer does that is to be killed when it has published one snapshot.
template <class Ready>
void publish_and_rest(const TestSession& session, const Ready& ready) {
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  publish_small(writer.buffer(), 1);
  ready();
  OtherProcess::rest();
}

TEST_CASE("A session is named by 1 to 64 letters, digits, '_', '-' or '.'", "[segment]") {
  CHECK(segment_name("a", kScene) == "a-scene");
  CHECK(segment_name("Lab_2-b.c", proto::SegmentKind::kTool) == "Lab_2-b.c-tool");
  CHECK_NOTHROW(segment_name(std::string(64, 'x'), kScene));

  const std::string bad =
      GENERATE("", ".", ".hidden", "../etc", "a/b", "a b", "a\n", "\xC3\xA9", "a*", "/a", "1000/",
               "-1/a", "1000/a/b", "4294967296/a", "1000/../a", "+1/a", " 1/a");
  CHECK(refusal_of([&] { return segment_name(bad, kScene); }).find("value '" + bad) == 0);
  CHECK_THROWS_AS(segment_name(std::string(65, 'x'), kScene), SegmentError);
  CHECK_THROWS_AS(segment_name(std::string("a\0b", 3), kScene), SegmentError);
}

TEST_CASE("A session is being loaded while its lock is held and no segment lives", "[segment]") {
  const TestSession session;
  CHECK_FALSE(is_writer_loading(session.name(), kScene));
  {
    const SessionLock loading(session.name(), kScene);
    CHECK(is_writer_loading(session.name(), kScene));
    CHECK_FALSE(is_writer_loading(session.name(), proto::SegmentKind::kTool));
  }
  CHECK_FALSE(is_writer_loading(session.name(), kScene));
  const SegmentWriter writer(session.name(), small_spec());
  CHECK_FALSE(is_writer_loading(session.name(), kScene));
}

TEST_CASE("A reader sees what the writer declared and published", "[segment]") {
  const TestSession session;
  SegmentSpec spec = small_spec();
  spec.period_ns = 30'303'030;
  spec.start_ns = 99;
  SegmentWriter writer(session.name(), spec);
  writer.announce();
  publish_small(writer.buffer(), 1);

  const auto reader = open_small(session);

  REQUIRE(reader);
  const proto::SegmentHeader& header = reader->header();
  CHECK(header.version == proto::kSegmentVersion);
  CHECK(header.kind == kScene);
  CHECK(header.epoch != 0);
  CHECK(header.period_ns == 30'303'030);
  CHECK(header.clock == proto::Clock::kVirtual);
  CHECK(header.start_ns == 99);
  CHECK(header.writer_pid == static_cast<std::uint32_t>(::getpid()));
  CHECK(header.payload_bytes == kSmallPayloadWords * 8);
  CHECK(reader->fixed_bytes() == sizeof(proto::SegmentHeader));
  CHECK(reader->writer_alive());
  CHECK(shows_whole_snapshot(*reader));
}

TEST_CASE("Without a writer there is no segment and before announce() nothing to read",
          "[segment]") {
  const TestSession session;
  CHECK_FALSE(open_small(session));
  CHECK_FALSE(segment_id(session.name(), kScene));

  SegmentWriter writer(session.name(), small_spec());
  CHECK(segment_id(session.name(), kScene));
  CHECK_FALSE(open_small(session));

  writer.announce();
  CHECK(open_small(session));
}

TEST_CASE("A segment is for its owner alone", "[segment]") {
  const TestSession session;
  const SegmentWriter writer(session.name(), small_spec());
  for (const std::string& path : {session.path(kScene), session.path(kScene) + ".lock"}) {
    struct stat status {};
    REQUIRE(::stat(path.c_str(), &status) == 0);
    CHECK((status.st_mode & 0777) == 0600);
  }
}

TEST_CASE("A group may read a segment that was opened to it and no more", "[segment]") {
  const TestSession session;
  SegmentSpec spec = small_spec();
  spec.readers = ::getegid();
  const SegmentWriter writer(session.name(), spec);
  struct stat status {};
  REQUIRE(::stat(session.path(kScene).c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == 0640);
  CHECK(status.st_gid == ::getegid());
}

TEST_CASE("A group is known by its name", "[segment]") {
  CHECK(group_named("root") == gid_t{0});
  CHECK(group_complaint("root").empty());
  CHECK(group_complaint("no-such-group").find("value 'no-such-group'") == 0);
}

TEST_CASE("A writer that ends leaves nothing in shared memory", "[segment]") {
  const TestSession session;
  { const SegmentWriter writer(session.name(), small_spec()); }
  for (const std::string& path : {session.path(kScene), session.path(kScene) + ".lock"})
    CHECK(::access(path.c_str(), F_OK) != 0);
}

TEST_CASE("Of many who want to write at once one does", "[segment]") {
  // The last holder removes the lock's file, so that two files could bear its name in turn.
  const TestSession session;
  std::atomic<int> writing = 0, most = 0;
  std::vector<std::jthread> rivals;
  for (int rival = 0; rival < 8; ++rival)
    rivals.emplace_back([&] {
      for (int i = 0; i < 200; ++i) try {
          const SessionLock lock(session.name(), kScene);
          most = std::max<int>(most, ++writing);
          --writing;
        } catch (const SegmentError&) {
          std::this_thread::yield();
        }
    });
  rivals.clear();
  CHECK(most == 1);
}

TEST_CASE("What a killed writer left can be removed and what lives cannot", "[segment]") {
  const TestSession session, other;
  const auto is_listed = [&] {
    const auto found = list_segments();
    return std::any_of(found.begin(), found.end(), [&](const SegmentFile& file) {
      return file.session == session.name() && file.kind == kScene;
    });
  };
  CHECK_FALSE(remove_dead_segment(session.name(), kScene));
  OtherProcess killed([&](const auto& ready) { publish_and_rest(session, ready); });
  REQUIRE(killed.was_ready());
  CHECK(is_listed());
  CHECK_FALSE(remove_dead_segment(session.name(), kScene));
  CHECK(is_listed());

  killed.kill();

  CHECK(remove_dead_segment(session.name(), kScene));
  CHECK_FALSE(is_listed());
  CHECK(::access((session.path(kScene) + ".lock").c_str(), F_OK) != 0);
}

TEST_CASE("A second writer is refused while the first lives and disturbs nothing", "[segment]") {
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  publish_small(writer.buffer(), 1);
  const auto id = segment_id(session.name(), kScene);

  const std::string refusal =
      refusal_of([&] { const SegmentWriter second(session.name(), small_spec()); });

  CHECK(refusal.find("'" + session.name() + "'") != std::string::npos);
  CHECK(refusal.find('\n') == std::string::npos);
  CHECK(segment_id(session.name(), kScene) == id);
  REQUIRE(open_small(session));
  CHECK(open_small(session)->writer_alive());
  CHECK(shows_whole_snapshot(*open_small(session)));
}

TEST_CASE("A writer that is about to end is waited for", "[segment]") {
  const TestSession session;
  std::optional<SegmentWriter> first(std::in_place, session.name(), small_spec());
  std::thread ending([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    first.reset();
  });

  CHECK_NOTHROW(SegmentWriter(session.name(), small_spec()));

  ending.join();
}

TEST_CASE("A stop ends the wait for another writer, who keeps the session", "[segment]") {
  const TestSession session;
  const SessionLock held(session.name(), kScene);
  std::atomic<bool> stop = false;
  std::thread stopping([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    stop = true;
  });
  const auto begin = std::chrono::steady_clock::now();

  CHECK_FALSE(SessionLock::take(session.name(), kScene, stop));

  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(500));
  stopping.join();
  CHECK(is_writer_loading(session.name(), kScene));
}

TEST_CASE("A lock that was handed on is free once its last holder ends, no sooner", "[segment]") {
  const TestSession session;
  {
    SessionLock first(session.name(), kScene);
    const SegmentWriter writer(std::move(first), small_spec());
    CHECK_THROWS_AS(SegmentWriter(session.name(), small_spec()), SegmentError);
  }
  CHECK_NOTHROW(SegmentWriter(session.name(), small_spec()));
}

TEST_CASE("The two segments of a session and those of other sessions have writers of their own",
          "[segment]") {
  const TestSession session, other;
  const SegmentWriter scene(session.name(), small_spec());
  CHECK_NOTHROW(SegmentWriter(session.name(), small_spec(proto::SegmentKind::kTool)));
  CHECK_NOTHROW(SegmentWriter(other.name(), small_spec()));
}

TEST_CASE("When a writer ends its segment's name is free and readers keep the last snapshot",
          "[segment]") {
  const TestSession session;
  std::optional<SegmentReader> reader;
  {
    SegmentWriter writer(session.name(), small_spec());
    writer.announce();
    publish_small(writer.buffer(), 1);
    reader.emplace(std::move(*open_small(session)));
  }
  CHECK_FALSE(segment_id(session.name(), kScene));
  CHECK_FALSE(open_small(session));
  CHECK_FALSE(reader->writer_alive());
  CHECK(shows_whole_snapshot(*reader));
  CHECK_NOTHROW(SegmentWriter(session.name(), small_spec()));
}

TEST_CASE("Asking whether a writer lives never keeps a writer out", "[segment]") {
  const TestSession session;
  std::optional<SegmentReader> reader;
  for (int restart = 0; restart < 3; ++restart) {
    SegmentWriter writer(session.name(), small_spec());
    writer.announce();
    if (reader) CHECK_FALSE(reader->writer_alive());  // of the object before
    reader.emplace(std::move(*open_small(session)));
    CHECK(reader->writer_alive());
  }
}

TEST_CASE("A reader that locks the object keeps no writer out and no dead one alive", "[segment]") {
  const TestSession session;
  OtherProcess killed([&](const auto& ready) { publish_and_rest(session, ready); });
  REQUIRE(killed.was_ready());
  const auto reader = open_small(session);
  REQUIRE(reader);
  killed.kill();
  const FileDescriptor meddler(::open(session.path(kScene).c_str(), O_RDONLY | O_CLOEXEC));
  struct flock lock {};
  lock.l_type = F_RDLCK;
  lock.l_whence = SEEK_SET;
  REQUIRE(::fcntl(meddler.get(), F_OFD_SETLK, &lock) == 0);

  CHECK_FALSE(reader->writer_alive());
  CHECK_NOTHROW(SegmentWriter(session.name(), small_spec()));
}

TEST_CASE("A writer whose files were removed leaves those of the next one alone", "[segment]") {
  const TestSession session;
  std::optional<SegmentWriter> first(std::in_place, session.name(), small_spec());
  for (const std::string& path : {session.path(kScene), session.path(kScene) + ".lock"})
    REQUIRE(::unlink(path.c_str()) == 0);
  SegmentWriter second(session.name(), small_spec());
  second.announce();

  first.reset();

  CHECK(open_small(session));
  CHECK_THROWS_AS(SegmentWriter(session.name(), small_spec()), SegmentError);
}

TEST_CASE("A killed writer is known to be dead and the next one makes a fresh segment",
          "[segment]") {
  const TestSession session;
  OtherProcess killed([&](const auto& ready) { publish_and_rest(session, ready); });
  REQUIRE(killed.was_ready());
  const auto reader = open_small(session);
  REQUIRE(reader);
  CHECK(reader->writer_alive());

  killed.kill();

  CHECK_FALSE(reader->writer_alive());
  CHECK(shows_whole_snapshot(*reader));
  const std::uint64_t epoch_before = reader->header().epoch;

  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  const auto again = open_small(session);
  REQUIRE(again);
  CHECK_FALSE(again->id() == reader->id());
  CHECK(again->header().epoch != epoch_before);
  CHECK(again->header().latest == 0);  // nothing of the old snapshot
  CHECK(again->writer_alive());
  CHECK_FALSE(reader->writer_alive());
  CHECK(shows_whole_snapshot(*reader));
}

TEST_CASE("A writer killed at any instant leaves a whole snapshot", "[segment]") {
  int whole = 0;
  for (int kill = 0; kill < 50; ++kill) {
    const TestSession session;
    OtherProcess killed([&](const auto& ready) {
      SegmentWriter writer(session.name(), small_spec());
      writer.announce();
      publish_small(writer.buffer(), 1);
      ready();
      for (std::uint64_t n = 2;; ++n) publish_small(writer.buffer(), n);
    });
    const auto reader = open_small(session);
    REQUIRE(reader);
    killed.kill();
    if (shows_whole_snapshot(*reader) && !reader->writer_alive()) ++whole;
  }
  CHECK(whole == 50);
}

}  // namespace
}  // namespace stillgrid::publication::segment_test
