#include "shared/publication/segment_watch.hpp"

#include <catch2/catch.hpp>
#include <optional>
#include <vector>

#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::segment_watch_test {
namespace {

/// A view that counts how many of it there are.
class CountedView {
 public:
  static inline int alive = 0;

  explicit CountedView(SegmentReader&& reader) : reader_(std::move(reader)) { ++alive; }
  ~CountedView() { --alive; }
  CountedView(const CountedView&) = delete;
  CountedView& operator=(const CountedView&) = delete;

  [[nodiscard]] const SegmentReader& reader() const noexcept { return reader_; }

 private:
  SegmentReader reader_;
};

/// A writer that can be restarted, and a watch on its session.
struct Watched {
  TestSession session;
  std::vector<std::string> reports;
  SegmentWatch<CountedView> watch{
      session.name(), proto::SegmentKind::kScene, kSmallLayoutHash, proto::Clock::kVirtual,
      [this](const std::string& refusal) { reports.push_back(refusal); }};
  std::optional<SegmentWriter> writer;

  /// Ends the writer that is there and starts another; returns its epoch.
  std::uint64_t restart() {
    writer.reset();
    writer.emplace(session.name(), small_spec());
    writer->announce();
    return writer->header().epoch;
  }
};

TEST_CASE("A watch has nothing to give until a writer announces itself", "[segment_watch]") {
  Watched it;
  it.watch.poll();
  CHECK(it.watch.acquire() == nullptr);
  CHECK_FALSE(it.watch.writer_alive());

  it.writer.emplace(it.session.name(), small_spec());
  it.watch.poll();
  CHECK(it.watch.acquire() == nullptr);

  it.writer->announce();
  it.watch.poll();
  REQUIRE(it.watch.acquire() != nullptr);
  CHECK(it.watch.writer_alive());
  CHECK(it.reports.empty());
}

TEST_CASE("A restarted writer is picked up", "[segment_watch]") {
  Watched it;
  for (int restart = 0; restart < 5; ++restart) {
    const std::uint64_t epoch = it.restart();
    it.watch.poll();
    REQUIRE(it.watch.acquire() != nullptr);
    CHECK(it.watch.acquire()->reader().header().epoch == epoch);
    CHECK(it.watch.writer_alive());
    it.watch.poll();
    CHECK(CountedView::alive == 1);
  }
}

TEST_CASE("When a writer ends its last mapping stays and is known to be orphaned",
          "[segment_watch]") {
  Watched it;
  it.restart();
  it.watch.poll();
  const CountedView* view = it.watch.acquire();
  REQUIRE(view != nullptr);

  it.writer.reset();
  it.watch.poll();

  CHECK(it.watch.acquire() == view);
  CHECK_FALSE(it.watch.writer_alive());
}

TEST_CASE("An old mapping lives until the reader has taken the new one", "[segment_watch]") {
  Watched it;
  it.restart();
  it.watch.poll();
  const bool was_acquired = GENERATE(true, false);  // else a reader may be about to
  if (was_acquired) REQUIRE(it.watch.acquire() != nullptr);

  for (int restart = 0; restart < 3; ++restart) {
    it.restart();
    for (int round = 0; round < 3; ++round) it.watch.poll();
    CHECK(CountedView::alive == 2);
  }

  for (int round = 0; round < 2; ++round) {  // the one in between, then the newest
    REQUIRE(it.watch.acquire() != nullptr);
    it.watch.poll();
  }
  const CountedView* newest = it.watch.acquire();
  REQUIRE(newest != nullptr);
  it.watch.poll();
  CHECK(newest->reader().header().epoch == it.writer->header().epoch);
  CHECK(CountedView::alive == 1);
}

TEST_CASE("What is refused is reported once and does not disturb the mapping in use",
          "[segment_watch]") {
  Watched it;
  it.restart();
  it.watch.poll();
  const CountedView* view = it.watch.acquire();

  it.restart();
  it.writer->header().version = 4711;
  for (int round = 0; round < 3; ++round) it.watch.poll();

  CHECK(it.watch.acquire() == view);
  REQUIRE(it.reports.size() == 1);
  CHECK(it.reports[0].find("4711") != std::string::npos);
}

TEST_CASE("What a killed writer left behind is not taken up", "[segment_watch]") {
  Watched it;
  {
    SegmentWriter dead(it.session.name(), small_spec());
    dead.announce();
    // Its name stays when it is killed; here it comes back by a link to the same object.
    REQUIRE(::link(it.session.path(proto::SegmentKind::kScene).c_str(),
                   (it.session.path(proto::SegmentKind::kTool)).c_str()) == 0);
  }
  REQUIRE(::rename(it.session.path(proto::SegmentKind::kTool).c_str(),
                   it.session.path(proto::SegmentKind::kScene).c_str()) == 0);

  it.watch.poll();

  CHECK(it.watch.acquire() == nullptr);
}

TEST_CASE("A segment on another clock is reported and not taken up", "[segment_watch]") {
  Watched it;
  SegmentSpec spec = small_spec();
  spec.clock = proto::Clock::kMonotonic;
  it.writer.emplace(it.session.name(), spec);
  it.writer->announce();
  for (int round = 0; round < 3; ++round) it.watch.poll();

  CHECK(it.watch.acquire() == nullptr);
  REQUIRE(it.reports.size() == 1);
  CHECK(it.reports[0].find("real time: start it with --lockstep too") != std::string::npos);
}

TEST_CASE("The same refusal is reported again after a good segment", "[segment_watch]") {
  Watched it;
  for (int writer = 0; writer < 2; ++writer) {
    it.restart();
    it.watch.poll();
    static_cast<void>(it.watch.acquire());
    it.restart();
    it.writer->header().version = 4711;
    it.watch.poll();
  }
  CHECK(it.reports.size() == 2);
}

TEST_CASE("A shrunk segment counts as dead and is reported once until a new one comes",
          "[segment_watch]") {
  Watched it;
  it.restart();
  it.watch.poll();
  const CountedView* view = it.watch.acquire();
  REQUIRE(::truncate(it.session.path(proto::SegmentKind::kScene).c_str(), 0) == 0);

  CHECK(double_buffer::read_latest(view->reader().buffer(), [](const std::uint64_t*) {}).status ==
        double_buffer::ReadStatus::kEmpty);
  for (int round = 0; round < 3; ++round) it.watch.poll();

  CHECK(it.watch.acquire() == view);
  CHECK_FALSE(it.watch.writer_alive());
  REQUIRE(it.reports.size() == 1);
  CHECK(it.reports[0].find("was shrunk") != std::string::npos);
  const std::uint64_t epoch = it.restart();
  it.watch.poll();
  CHECK(it.watch.acquire()->reader().header().epoch == epoch);
  CHECK(it.watch.writer_alive());
}

TEST_CASE("A loss and a refusal that stay are each reported once", "[segment_watch]") {
  Watched it;
  it.restart();
  it.watch.poll();
  static_cast<void>(it.watch.acquire());
  REQUIRE(::truncate(it.session.path(proto::SegmentKind::kScene).c_str(), 0) == 0);
  static_cast<void>(
      double_buffer::read_latest(it.watch.acquire()->reader().buffer(), [](const auto*) {}));
  it.restart();
  it.writer->header().version = 4711;

  for (int round = 0; round < 10; ++round) it.watch.poll();

  CHECK(it.reports.size() == 2);
}

TEST_CASE("What a killed writer of another version left keeps nobody from waiting",
          "[segment_watch]") {
  Watched it;
  it.restart();
  it.writer->header().version = 4711;
  const std::string path = it.session.path(proto::SegmentKind::kScene);
  REQUIRE(::rename(path.c_str(), (path + ".kept").c_str()) == 0);
  it.writer.reset();
  REQUIRE(::rename((path + ".kept").c_str(), path.c_str()) == 0);

  it.watch.poll();
  CHECK(it.reports.empty());

  it.restart();
  it.watch.poll();
  CHECK(it.watch.acquire() != nullptr);
}

TEST_CASE("A watch with its own thread follows restarts while the reader reads",
          "[segment_watch]") {
  Watched it;
  it.watch.start();
  for (int restart = 0; restart < 10; ++restart) {
    const std::uint64_t epoch = it.restart();
    const CountedView* view = nullptr;
    do {
      view = it.watch.acquire();
    } while (view == nullptr || view->reader().header().epoch != epoch);
  }
  CHECK(CountedView::alive <= 2);
  CHECK(it.reports.empty());
}

}  // namespace
}  // namespace stillgrid::publication::segment_watch_test
