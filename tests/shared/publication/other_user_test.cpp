#include <fcntl.h>
#include <grp.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "shared/publication/segment.hpp"
#include "tests/shared/publication/other_process.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::other_user_test {
namespace {

constexpr auto kScene = proto::SegmentKind::kScene;
constexpr uid_t kUser = 64321, kStranger = 65534;  // neither runs anything of ours
const std::string kFolder = "/dev/shm/stillgrid-64321";

/// Two users who leave nothing, of one test at a time: tests run beside one another. Only root can
/// be both: elsewhere a test says that it was skipped.
struct TwoUsers {
  TwoUsers() : turn_(::open("/tmp/stillgrid-two-users", O_CREAT | O_RDWR | O_CLOEXEC, 0600)) {
    REQUIRE(::flock(turn_, LOCK_EX) == 0);
    clear();
  }
  ~TwoUsers() {
    clear();
    ::flock(turn_, LOCK_UN);  // for children that hold it too
    ::close(turn_);
  }
  TwoUsers(const TwoUsers&) = delete;
  TwoUsers& operator=(const TwoUsers&) = delete;
  TwoUsers(TwoUsers&&) = delete;
  TwoUsers& operator=(TwoUsers&&) = delete;

  static bool are_possible() {
    if (::geteuid() == 0) return true;
    WARN("skipped: needs root, to act as two other users");
    return false;
  }
  static void clear() {
    for (const char* left : {"64321", "64321.1", "64321.2", "65534"})
      std::filesystem::remove_all(std::string("/dev/shm/stillgrid-") + left);
  }

 private:
  int turn_;
};

/// Work that returns ends the process.
template <class Work>
OtherProcess as_user(uid_t user, const Work& work) {
  return OtherProcess([&](const auto& ready) {
    ::umask(0);
    if (::setgroups(0, nullptr) != 0 || ::setgid(user) != 0 || ::setuid(user) != 0) return;
    work(ready);
  });
}

/// Publishes one snapshot in a session of the user's own until it is killed.
OtherProcess publisher(uid_t user, const std::string& session, mode_t mode = 0600) {
  return as_user(user, [=](const auto& ready) {
    SegmentWriter writer(session, small_spec());
    writer.announce();
    publish_small(writer.buffer(), 1);
    ::chmod(segment_path(session, kScene).c_str(), mode);
    ready();
    OtherProcess::rest();
  });
}

/// Whether that user finds a living segment there.
bool finds(uid_t user, const std::string& session) {
  const OtherProcess reader = as_user(user, [&](const auto& ready) {
    const auto found = SegmentReader::open(session, kScene, kSmallLayoutHash);
    if (found && found->writer_alive()) ready();
  });
  return reader.was_ready();
}

/// Whether what that user does is refused with these words.
template <class Call>
bool is_refused(uid_t user, const std::string& words, const Call& call) {
  const OtherProcess refused = as_user(user, [&](const auto& ready) {
    if (refusal_of(call).find(words) != std::string::npos) ready();
  });
  return refused.was_ready();
}

void open_to_all(const std::string& path) {
  std::filesystem::permissions(path, std::filesystem::perms::all);
}

TEST_CASE("Who takes another user's names first keeps that user out of nothing", "[other_user]") {
  if (!TwoUsers::are_possible()) return;
  const TwoUsers users;
  const OtherProcess squatter = as_user(kStranger, [&](const auto& ready) {
    if (::mkdir(kFolder.c_str(), 0777) != 0) return;
    std::ofstream(kFolder + ".1") << "taken";
    SegmentWriter writer("demo", small_spec());  // one's own, put where the user would look
    writer.announce();
    std::filesystem::rename(segment_path("demo", kScene), kFolder + "/demo-scene");
    open_to_all(kFolder + "/demo-scene");
    ready();
    OtherProcess::rest();
  });
  REQUIRE(squatter.was_ready());
  CHECK_FALSE(finds(kUser, "demo"));
  CHECK_FALSE(finds(0, "64321/demo"));

  const OtherProcess writer = publisher(kUser, "demo");

  REQUIRE(writer.was_ready());
  CHECK(finds(kUser, "demo"));
  CHECK(finds(0, "64321/demo"));
  CHECK(is_refused(kUser, "already has a writer",
                   [] { const SegmentWriter second("demo", small_spec()); }));
  CHECK(folder_of(kUser) == kFolder + ".2/");
}

TEST_CASE("A segment of another user is refused whatever its mode lets one do", "[other_user]") {
  if (!TwoUsers::are_possible()) return;
  const TwoUsers users;
  REQUIRE(publisher(kUser, "first").was_ready());  // the folder is there from now on
  open_to_all(kFolder);                            // as no program of ours leaves it
  const OtherProcess stranger = as_user(kStranger, [&](const auto& ready) {
    SegmentWriter writer("demo", small_spec());
    writer.announce();
    for (const char* ending : {"demo-scene", "demo-scene.lock"}) {
      std::filesystem::rename("/dev/shm/stillgrid-65534/" + std::string(ending),
                              kFolder + "/" + ending);
      open_to_all(kFolder + "/" + ending);
    }
    ready();
    OtherProcess::rest();
  });
  REQUIRE(stranger.was_ready());
  constexpr const char* kWords = "belongs to user 65534, expected user 64321";
  CHECK(is_refused(kUser, kWords,
                   [] { (void)SegmentReader::open("demo", kScene, kSmallLayoutHash); }));
  CHECK(is_refused(kUser, kWords, [] { const SegmentWriter writer("demo", small_spec()); }));
  CHECK(is_refused(0, kWords,
                   [] { (void)SegmentReader::open("64321/demo", kScene, kSmallLayoutHash); }));
  CHECK(std::filesystem::exists(kFolder + "/demo-scene"));
}

TEST_CASE("Another user's session is read where it was opened and is nobody else's to write",
          "[other_user]") {
  if (!TwoUsers::are_possible()) return;
  const TwoUsers users;
  const OtherProcess closed = publisher(kUser, "closed"), opened = publisher(kUser, "open", 0644);
  REQUIRE((closed.was_ready() && opened.was_ready()));
  CHECK(finds(kStranger, "64321/open"));
  CHECK_FALSE(finds(kStranger, "open"));
  CHECK(is_refused(kStranger, "Permission denied",
                   [] { (void)SegmentReader::open("64321/closed", kScene, kSmallLayoutHash); }));
  CHECK(is_refused(kStranger, "another user's",
                   [] { (void)remove_dead_segment("64321/closed", kScene); }));
  const OtherProcess own = publisher(kStranger, "64321/open");
  CHECK(own.was_ready());
  CHECK(std::filesystem::exists("/dev/shm/stillgrid-65534/open-scene"));
}

TEST_CASE("A user is named by name or number before a session", "[other_user]") {
  const std::string own = std::to_string(::geteuid());
  for (const auto& [given, settled] : {std::pair<std::string, std::string>{"demo", "demo"},
                                       {own + "/demo", "demo"},
                                       {"nobody/demo", "65534/demo"},
                                       {"64321/demo", "64321/demo"}}) {
    std::string session = given;
    CHECK(settle_session(session).empty());
    CHECK(session == settled);
  }
  for (const char* bad : {"nobody/", "/demo", "no such user/demo", "nobody/a/b", "-1/demo"}) {
    std::string session = bad;
    CHECK(settle_session(session).find("value '") == 0);
  }
}

}  // namespace
}  // namespace stillgrid::publication::other_user_test
