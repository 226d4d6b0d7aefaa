#include "shared/tools/segment_inspect/segment_summary.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <thread>

#include "shared/realtime/periodic_timer.hpp"
#include "tests/shared/publication/other_process.hpp"
#include "tests/shared/publication/small_scene.hpp"
#include "tests/shared/publication/tampering.hpp"

namespace stillgrid::segment_inspect::segment_summary_test {
namespace {

constexpr auto kScene = proto::SegmentKind::kScene;
constexpr auto kTool = proto::SegmentKind::kTool;

/// Puts an object of these bytes under the session's name.
void make_object(const publication::TestSession& session, proto::SegmentKind kind,
                 const std::string& bytes) {
  const publication::FileDescriptor file(
      ::open(session.path(kind).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  REQUIRE(::write(file.get(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
}

/// What another user calls a session of root's; only root can become another user.
std::string name_to_others(const publication::TestSession& session) {
  return (::getuid() == 0 ? "0/" : "") + session.name();
}

/// Leaves a scene segment whose writer was killed.
void leave_dead_scene(const publication::TestSession& session) {
  publication::OtherProcess killed([&](const auto& ready) {
    publication::SmallSceneWriter writer(session);
    writer.publish_next();
    ready();
    publication::OtherProcess::rest();
  });
  REQUIRE(killed.was_ready());
}

reading::SegmentSummary summary_of(const publication::TestSession& session,
                                   proto::SegmentKind kind = kScene) {
  return reading::observe({session.name(), kind}).summary;
}

TEST_CASE("A living scene is summed up as its writer declared and published it",
          "[segment_summary]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  CHECK_FALSE(summary_of(session).moving_spheres);
  writer.publish_next();
  writer.publish_next();

  const reading::SegmentSummary summary = summary_of(session);

  CHECK(summary.state == reading::SegmentState::kAlive);
  CHECK(summary.refusal.empty());
  CHECK_FALSE(summary.is_leftover);
  REQUIRE(summary.header);
  CHECK(summary.header->latest == 2);
  CHECK(summary.header->writer_pid == static_cast<std::uint32_t>(::getpid()));
  CHECK(summary.header->period_ns == publication::kPeriod_ns);
  CHECK(summary.size_bytes == summary.header->size_bytes);
  CHECK(summary.moving_spheres == publication::kMovingSpheres);
  CHECK(summary.static_spheres == 10U);
  CHECK_FALSE(summary.age_s);  // virtual time has no age
}

TEST_CASE("The age of a state is the time since its writer stamped it", "[segment_summary]") {
  const publication::TestSession session;
  publication::ToolWriter writer(session.name(), 1'000'000, proto::Clock::kMonotonic,
                                 realtime::monotonic_ns());
  proto::ToolState state{};
  state.time_ns = realtime::monotonic_ns() - 50'000'000;
  writer.publish(state);

  const reading::SegmentSummary summary = summary_of(session, kTool);

  REQUIRE(summary.age_s);
  CHECK(*summary.age_s >= 0.05);
  CHECK(*summary.age_s < 2.0);
  CHECK_FALSE(summary.moving_spheres);
}

TEST_CASE("A stamp that is none or lies ahead has no age", "[segment_summary]") {
  constexpr auto kMonotonic = proto::Clock::kMonotonic;
  CHECK(reading::age_of(1'000'000'000, kMonotonic, 1'500'000'000) == 0.5);
  CHECK_FALSE(reading::age_of(0, kMonotonic, 5));
  CHECK_FALSE(reading::age_of(6, kMonotonic, 5));
  CHECK_FALSE(reading::age_of(UINT64_MAX, kMonotonic, 5));
  CHECK_FALSE(reading::age_of(1, proto::Clock::kVirtual, 5));
  CHECK_FALSE(reading::age_of(1, static_cast<proto::Clock>(77), 5));
}

TEST_CASE("A killed writer's segment is shown as dead and can be removed", "[segment_summary]") {
  const publication::TestSession session;
  leave_dead_scene(session);
  const reading::SegmentSummary summary = summary_of(session);
  CHECK(summary.state == reading::SegmentState::kDead);
  CHECK(summary.is_leftover);
  CHECK(summary.moving_spheres == publication::kMovingSpheres);

  CHECK(remove_leftover(summary.file));

  CHECK(summary_of(session).state == reading::SegmentState::kGone);
  CHECK_FALSE(remove_leftover(summary.file));
}

TEST_CASE("What lives is never removed", "[segment_summary]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  CHECK_FALSE(remove_leftover({session.name(), kScene}));
  SECTION("although its lock file was deleted") {
    REQUIRE(::unlink((session.path(kScene) + ".lock").c_str()) == 0);
    CHECK_FALSE(remove_leftover({session.name(), kScene}));
  }
  SECTION("although it is of another version") {
    writer.writer().header().version = 4711;
    CHECK(summary_of(session).state == reading::SegmentState::kRefused);
    CHECK_FALSE(remove_leftover({session.name(), kScene}));
  }
  writer.publish_next();
  CHECK(::access(session.path(kScene).c_str(), F_OK) == 0);
}

TEST_CASE("A segment before its announcement is starting or half made", "[segment_summary]") {
  const publication::TestSession session;
  {
    publication::SegmentSpec spec = publication::small_spec();
    spec.layout_hash = proto::kSceneLayoutHash;
    const publication::SegmentWriter writer(session.name(), spec);
    CHECK(summary_of(session).state == reading::SegmentState::kStarting);
    CHECK_FALSE(remove_leftover({session.name(), kScene}));
  }
  make_object(session, kScene, std::string(GENERATE(0U, 4096U), '\0'));
  CHECK(summary_of(session).state == reading::SegmentState::kHalfMade);
  CHECK(remove_leftover({session.name(), kScene}));
  CHECK(summary_of(session).state == reading::SegmentState::kGone);
}

TEST_CASE("A starting segment is starting to a reader of its group too", "[segment_summary]") {
  const publication::TestSession session;
  constexpr gid_t kNoGroup = 65534;
  constexpr uid_t kNobody = 65534;
  publication::SegmentSpec spec = publication::small_spec();
  spec.layout_hash = proto::kSceneLayoutHash;
  spec.readers = ::getuid() == 0 ? kNoGroup : ::getgid();
  const publication::SegmentWriter writer(session.name(), spec);
  const publication::OtherProcess reader([&](const auto& ready) {
    const std::string name = name_to_others(session);
    if (::getuid() == 0 && (::setgid(kNoGroup) != 0 || ::setuid(kNobody) != 0)) return;
    const reading::SegmentSummary summary = reading::observe({name, kScene}).summary;
    if (summary.state == reading::SegmentState::kStarting && !remove_leftover(summary.file))
      ready();
  });
  CHECK(reader.was_ready());
}

TEST_CASE("A lock file that a killed writer left alone is removed too", "[segment_summary]") {
  const publication::TestSession session;
  const publication::SegmentFile file{session.name(), kScene};
  const std::string path = session.path(kScene) + ".lock";
  {
    const publication::SessionLock lock(session.name(), kScene);
    CHECK_FALSE(remove_leftover(file));
    CHECK(::access(path.c_str(), F_OK) == 0);
  }
  ::close(::open(path.c_str(), O_CREAT | O_CLOEXEC, 0600));
  const auto listed = publication::list_segments();
  CHECK(std::count(listed.begin(), listed.end(), file) == 1);
  CHECK(remove_leftover(file));
  CHECK(::access(path.c_str(), F_OK) != 0);
}

TEST_CASE("What cannot be ours is refused in one line and never removed", "[segment_summary]") {
  const publication::TestSession session;
  const std::string path = session.path(kScene);
  std::string words;
  SECTION("foreign bytes") {
    make_object(session, kScene, std::string(8192, 'x'));
    words = "not a Stillgrid segment";
  }
  SECTION("too short") {
    make_object(session, kScene, "short");
    words = "only 5 bytes";
  }
  SECTION("a hole instead of memory") {
    make_object(session, kScene, "x");
    REQUIRE(::truncate(path.c_str(), off_t{1} << 40) == 0);
    words = "no memory stands behind";
  }
  SECTION("a pipe") {
    REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
    words = "no shared-memory object";
  }
  SECTION("a link") {
    REQUIRE(::symlink("/etc/passwd", path.c_str()) == 0);
    words = "no shared-memory object";
  }
  const reading::SegmentSummary summary = summary_of(session);
  CHECK(summary.state == reading::SegmentState::kRefused);
  CHECK(summary.refusal.find(words) != std::string::npos);
  CHECK(summary.refusal.find('\n') == std::string::npos);
  CHECK_FALSE(summary.header);
  CHECK_FALSE(remove_leftover(summary.file));
  struct stat status {};
  CHECK(::lstat(path.c_str(), &status) == 0);
}

TEST_CASE("What may not be read is a refusal too", "[segment_summary]") {
  const publication::TestSession session;
  const publication::SmallSceneWriter writer(session);
  REQUIRE(::chmod(session.path(kScene).c_str(), 0) == 0);
  const publication::OtherProcess stranger([&](const auto& ready) {
    constexpr uid_t kNobody = 65534;
    const std::string name = name_to_others(session);
    if (::getuid() == 0 && ::setuid(kNobody) != 0) return;
    const reading::SegmentSummary summary = reading::observe({name, kScene}).summary;
    if (summary.state != reading::SegmentState::kRefused || summary.is_leftover) return;
    if (summary.refusal.find("ermission denied") != std::string::npos) ready();
  });
  CHECK(stranger.was_ready());
}

TEST_CASE("A dead segment of another version is refused and can be removed", "[segment_summary]") {
  const publication::TestSession session;
  leave_dead_scene(session);
  publication::Tampering(session.path(kScene)).at<proto::SegmentHeader>(0).version = 4711;

  const reading::SegmentSummary summary = summary_of(session);

  CHECK(summary.state == reading::SegmentState::kRefused);
  CHECK(summary.refusal.find("version 4711") != std::string::npos);
  CHECK(remove_leftover(summary.file));
}

TEST_CASE("A name that no session can have is refused", "[segment_summary]") {
  const reading::SegmentSummary summary = reading::observe({"a\nb", kScene}).summary;
  CHECK(summary.state == reading::SegmentState::kRefused);
  CHECK_FALSE(remove_leftover(summary.file));
}

TEST_CASE("An object that is shrunk while it is watched is refused", "[segment_summary]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  reading::ObservedSegment segment = reading::observe({session.name(), kScene});
  REQUIRE(segment.scene);

  REQUIRE(::truncate(session.path(kScene).c_str(), 0) == 0);
  measure_rates({&segment, 1}, 0.01);
  reading::look_again(segment);

  CHECK(segment.summary.state == reading::SegmentState::kRefused);
  CHECK(segment.summary.refusal.find("shrunk") != std::string::npos);
  CHECK(segment.reader() == nullptr);
}

TEST_CASE("A survey has a row for each segment however many there are", "[segment_summary]") {
  constexpr std::size_t kMany = publication::MappingGuard::kMax + 10;
  const std::vector<publication::TestSession> sessions(kMany);
  leave_dead_scene(sessions[0]);
  std::vector<publication::SegmentFile> files;
  for (const publication::TestSession& session : sessions) {
    files.push_back({session.name(), kScene});
    if (session.name() != sessions[0].name())
      std::filesystem::copy_file(sessions[0].path(kScene), session.path(kScene));
  }
  make_object(sessions[1], kTool, "foreign");
  files.insert(files.begin() + 2, {sessions[1].name(), kTool});
  files.push_back({"absent", kTool});

  const std::vector<reading::SegmentSummary> summaries = survey(files, {});

  REQUIRE(summaries.size() == kMany + 1);
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    CHECK(summaries[i].file.session == files[i].session);
    CHECK(summaries[i].state ==
          (i == 2 ? reading::SegmentState::kRefused : reading::SegmentState::kDead));
  }
}

TEST_CASE("A measured rate is that of the publications", "[segment_summary]") {
  const publication::TestSession session, silent;
  const publication::ToolWriter silent_writer(silent.name(), 1'000'000, proto::Clock::kMonotonic,
                                              1);
  publication::ToolWriter writer(session.name(), 1'000'000, proto::Clock::kMonotonic, 1);
  std::atomic<std::uint64_t> published = 0;
  std::jthread thread([&](const std::stop_token& stop) {
    realtime::PeriodicTimer timer(5'000'000);
    while (!stop.stop_requested()) {
      timer.wait();
      writer.publish({});
      ++published;
    }
  });
  std::vector<reading::ObservedSegment> segments;
  segments.push_back(reading::observe({session.name(), kTool}));
  segments.push_back(reading::observe({silent.name(), kTool}));
  const std::uint64_t before = published, began_ns = realtime::monotonic_ns();

  measure_rates(segments, 0.4);

  // By the count beside it: a machine may stall.
  const double rate_hz = static_cast<double>(published - before) /
                         (static_cast<double>(realtime::monotonic_ns() - began_ns) * 1e-9);
  REQUIRE(segments[0].summary.measured_rate_hz);
  CHECK(*segments[0].summary.measured_rate_hz == Approx(rate_hz).epsilon(0.1));
  CHECK(segments[1].summary.measured_rate_hz == 0.0);
}

}  // namespace
}  // namespace stillgrid::segment_inspect::segment_summary_test
