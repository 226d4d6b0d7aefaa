#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <thread>
#include <vector>

#include "tests/shared/publication/other_process.hpp"
#include "tests/shared/publication/tampering.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::several_readers_test {
namespace {

constexpr auto kScene = proto::SegmentKind::kScene;
using Words = std::array<std::uint64_t, kSmallPayloadWords>;

/// What one reader has seen so far.
struct Seen {
  std::uint64_t accepted = 0, snapshots = 0, torn = 0, backwards = 0, last = 0;

  void read(const SegmentReader& reader) {
    Words words{};
    const double_buffer::ReadResult result = double_buffer::read_latest(
        reader.buffer(),
        [&](const std::uint64_t* payload) { words = double_buffer::load_struct<Words>(payload); });
    if (result.status != double_buffer::ReadStatus::kAccepted) return;
    ++accepted;
    const auto is_of_it = [&](std::uint64_t word) { return word == word_of(result.snapshot_id); };
    if (!std::all_of(words.begin(), words.end(), is_of_it)) ++torn;
    if (result.snapshot_id < last) ++backwards;
    if (result.snapshot_id > last)
      ++snapshots;
    else
      std::this_thread::yield();  // to the writer: on a small machine it may not be running
    last = result.snapshot_id;
  }
};

TEST_CASE("Of several readers at once each sees whole snapshots that never go back",
          "[several_readers]") {
  constexpr std::size_t kReaders = 6;
  constexpr std::uint64_t kSnapshots = 300;
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  std::array<Seen, kReaders> seen;
  std::atomic<std::size_t> done = 0;
  std::vector<std::jthread> threads;
  threads.reserve(kReaders);
  for (Seen& mine : seen)
    threads.emplace_back([&] {
      const auto reader = open_small(session);  // a mapping of its own
      while (reader && mine.snapshots < kSnapshots) mine.read(*reader);
      ++done;
    });

  std::uint64_t n = 0;
  while (done < kReaders) publish_small(writer.buffer(), ++n);
  threads.clear();

  for (const Seen& mine : seen) {
    CHECK(mine.snapshots == kSnapshots);
    CHECK(mine.torn == 0);
    CHECK(mine.backwards == 0);
    CHECK(mine.last <= n);
  }
}

TEST_CASE("A reader killed in mid-read changes nothing for the writer or other readers",
          "[several_readers]") {
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  publish_small(writer.buffer(), 1);
  const auto survivor = open_small(session);
  REQUIRE(survivor);
  OtherProcess killed([&](const auto& ready) {
    const auto reader = open_small(session);
    double_buffer::read_latest(reader->buffer(), [&](const std::uint64_t* payload) {
      static_cast<void>(double_buffer::load_word(payload, 0));
      ready();
      OtherProcess::rest();
    });
  });
  REQUIRE(killed.was_ready());
  const Tampering memory(session.path(kScene));
  const std::vector<std::byte> before(memory.bytes().begin(), memory.bytes().end());

  killed.kill();

  CHECK(std::equal(before.begin(), before.end(), memory.bytes().begin()));
  CHECK(survivor->writer_alive());
  Seen seen;
  for (std::uint64_t n = 2; n <= 5; ++n) {
    publish_small(writer.buffer(), n);
    seen.read(*survivor);
    CHECK(seen.last == n);
  }
  CHECK(seen.accepted == 4);
  CHECK(seen.torn == 0);
}

TEST_CASE("Readers killed one after the other while all read leave the others whole snapshots",
          "[several_readers]") {
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  std::jthread publishing([&](const std::stop_token& stop) {
    for (std::uint64_t n = 1; !stop.stop_requested(); ++n) publish_small(writer.buffer(), n);
  });
  const auto survivor = open_small(session);
  REQUIRE(survivor);
  Seen seen;
  for (int kill = 0; kill < 30; ++kill) {
    OtherProcess killed([&](const auto& ready) {
      const auto reader = open_small(session);
      Seen its;
      ready();
      for (;;) its.read(*reader);
    });
    REQUIRE(killed.was_ready());
    const std::uint64_t before = seen.snapshots;
    while (seen.snapshots < before + 5) seen.read(*survivor);
  }
  CHECK(seen.torn == 0);
  CHECK(seen.backwards == 0);
  CHECK(survivor->writer_alive());
}

/// The signal that ends a child which does this, or 0.
template <class Work>
int signal_that_ends(Work&& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGSEGV, SIG_DFL);
    work();
    ::_exit(0);
  }
  int status = 0;
  if (::waitpid(child, &status, 0) != child) return -1;
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST_CASE("A reader that writes is ended by SIGSEGV and nothing has changed", "[several_readers]") {
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  publish_small(writer.buffer(), 1);
  const auto reader = open_small(session);
  REQUIRE(reader);
  const Tampering memory(session.path(kScene));
  const std::vector<std::byte> before(memory.bytes().begin(), memory.bytes().end());
  const double_buffer::DoubleBuffer& buffer = reader->buffer();
  const auto* header = reinterpret_cast<const std::uint64_t*>(reader->bytes());

  for (const std::uint64_t* word : {header, static_cast<const std::uint64_t*>(buffer.latest),
                                    static_cast<const std::uint64_t*>(buffer.sequence[1]),
                                    static_cast<const std::uint64_t*>(buffer.payload[0])}) {
    static_cast<void>(double_buffer::load_word(word, 0));  // it may be read
    auto* const target = const_cast<std::uint64_t*>(word);
    CHECK(signal_that_ends([&] { *static_cast<volatile std::uint64_t*>(target) = 1; }) == SIGSEGV);
  }
  CHECK(signal_that_ends([&] { publish_small(buffer, 2); }) == SIGSEGV);
  CHECK(std::equal(before.begin(), before.end(), memory.bytes().begin()));
}

TEST_CASE("A reader cannot make its mapping writable", "[several_readers]") {
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  const auto reader = open_small(session);
  REQUIRE(reader);
  auto* const start = const_cast<std::byte*>(reader->bytes());
  CHECK(::mprotect(start, 4096, PROT_READ | PROT_WRITE) == -1);
  CHECK(errno == EACCES);
}

}  // namespace
}  // namespace stillgrid::publication::several_readers_test
