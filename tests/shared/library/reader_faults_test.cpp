#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>

#include "shared/publication/scene_segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "tests/shared/collision/sphere_state.hpp"
#include "tests/shared/library/published_session.hpp"
#include "tests/shared/publication/other_process.hpp"

namespace stillgrid::library::reader_faults_test {
namespace {

constexpr auto kScene = proto::SegmentKind::kScene;

bool last_error_has(const char* words) {
  const std::string line = stillgrid_last_error();
  CHECK(line.find('\n') == std::string::npos);
  return line.find(words) != std::string::npos;
}

TEST_CASE("Calls out of order, without a place or of another size are refused in a line each",
          "[library]") {
  const publication::TestSession session;
  stillgrid_reader* none = nullptr;
  CHECK(stillgrid_reader_open("a/b/c", nullptr, &none) == STILLGRID_E_ARGUMENT);
  CHECK(stillgrid_reader_open("a+b", nullptr, &none) == STILLGRID_E_ARGUMENT);
  CHECK(stillgrid_reader_open(session.name().c_str(), "a b", &none) == STILLGRID_E_ARGUMENT);
  CHECK(last_error_has("hand: value 'a b'"));
  CHECK(stillgrid_reader_open(session.name().c_str(), nullptr, nullptr) == STILLGRID_E_ARGUMENT);
  CHECK(none == nullptr);
  stillgrid_reader_close(nullptr);

  Reader reader(session.name().c_str());
  Spheres spheres(1);
  stillgrid_tool tool = Tool();
  Sized<stillgrid_fixed> fixed;
  CHECK(stillgrid_reader_snapshot(reader.handle(), &spheres) == STILLGRID_E_ORDER);
  CHECK(last_error_has("expected poll() first"));
  CHECK(stillgrid_reader_displayed(reader.handle(), &spheres) == STILLGRID_E_ORDER);
  CHECK(stillgrid_reader_static(reader.handle(), &spheres) == STILLGRID_E_ORDER);
  CHECK(stillgrid_reader_tool(reader.handle(), &tool) == STILLGRID_E_ORDER);
  CHECK(stillgrid_reader_fixed(reader.handle(), &fixed) == STILLGRID_E_ORDER);
  CHECK(stillgrid_reader_poll(reader.handle(), nullptr) == STILLGRID_E_ARGUMENT);
  CHECK(last_error_has("state: expected a struct, not null"));
  CHECK(stillgrid_reader_poll(nullptr, nullptr) == STILLGRID_E_ARGUMENT);
  SessionState state;
  state.struct_size = sizeof state - 1;
  CHECK(stillgrid_reader_poll(reader.handle(), &state) == STILLGRID_E_ARGUMENT);
  CHECK(last_error_has("state.struct_size: "));
  CHECK(stillgrid_reader_tool(reader.handle(), &tool) == STILLGRID_E_ORDER);  // no poll succeeded
}

TEST_CASE("A caller that knows more of a struct gets what the library knows", "[library]") {
  const publication::TestSession session;
  Reader reader(session.name().c_str());
  struct {
    SessionState known;
    std::uint64_t later = 77;
  } larger;
  larger.known.struct_size = sizeof larger;
  CHECK(stillgrid_reader_poll(reader.handle(), &larger.known) == STILLGRID_OK);
  CHECK(larger.known.struct_size == sizeof larger);
  CHECK(larger.later == 77);
}

TEST_CASE("Writers come, go and are started again under a reader", "[library]") {
  Fixture fixture;
  Reader reader(fixture.session.name().c_str());
  Spheres spheres(kMoving);
  SessionState state = reader.poll();
  CHECK(state.is_published == 0);
  CHECK(state.scene_epoch == 0);
  CHECK_FALSE(reader.snapshot(spheres));
  CHECK_FALSE(reader.tool());
  CHECK_FALSE(reader.fixed(state));

  std::uint64_t first_epoch = 0;
  {
    Publisher publisher(fixture.scene);
    state = reader.poll();
    CHECK(state.is_published == 1);
    CHECK_FALSE(reader.snapshot(spheres));  // none yet
    declare(publisher);
    publish(publisher, 1);
    CHECK(reader.snapshot(spheres));
    first_epoch = state.scene_epoch;
  }
  state = reader.poll();
  CHECK(state.is_published == 0);
  CHECK(state.scene_epoch == first_epoch);  // what was seen last
  CHECK_FALSE(reader.snapshot(spheres));

  Publisher publisher(fixture.scene);
  declare(publisher);
  publish(publisher, 1);
  state = reader.poll();
  CHECK(state.is_published == 1);
  CHECK(state.scene_epoch != first_epoch);
  CHECK(reader.snapshot(spheres));
}

TEST_CASE("A publisher that is killed is gone, and so is one whose memory was shrunk",
          "[library]") {
  Fixture fixture;
  Reader reader(fixture.session.name().c_str());
  Spheres spheres(kMoving);
  publication::OtherProcess other([&](const auto& ready) {
    Publisher publisher(fixture.scene);
    declare(publisher);
    publish(publisher, 1);
    ready();
    publication::OtherProcess::rest();
  });
  REQUIRE(other.was_ready());
  CHECK(reader.poll().is_published == 1);
  REQUIRE(reader.snapshot(spheres));
  SECTION("killed") {
    other.kill();
    CHECK(reader.snapshot(spheres));  // until the next poll
  }
  SECTION("shrunk") {
    REQUIRE(::truncate(fixture.session.path(kScene).c_str(), 0) == 0);
    CHECK_FALSE(reader.snapshot(spheres));
    stillgrid_reader_static(reader.handle(), &spheres);  // ends no process
  }
  CHECK(reader.poll().is_published == 0);
  CHECK_FALSE(reader.snapshot(spheres));
}

TEST_CASE("A simulation of another version is named, while the tool is read", "[library]") {
  const publication::TestSession session;
  auto spec = publication::small_spec();
  publication::SegmentWriter scene(session.name(), spec);
  scene.header().version = 4711;
  scene.announce();
  publication::ToolWriter tool(session.name(), 1'000'000, proto::Clock::kMonotonic, 0);
  proto::ToolState state{};
  state.orientation_xyzw[3] = 1.0;
  tool.publish(state);
  Reader reader(session.name().c_str());

  CHECK(code_of([&] { reader.poll(); }) == STILLGRID_E_VERSION);
  CHECK(last_error_has("4711"));
  Spheres spheres(1);
  CHECK_FALSE(reader.snapshot(spheres));
  CHECK(reader.tool());
}

TEST_CASE("What a killed simulation of another version left is no error", "[library]") {
  const publication::TestSession session;
  publication::OtherProcess other([&](const auto& ready) {
    publication::SegmentWriter scene(session.name(), publication::small_spec());
    scene.header().version = 4711;
    scene.announce();
    ready();
    publication::OtherProcess::rest();
  });
  REQUIRE(other.was_ready());
  other.kill();
  Reader reader(session.name().c_str());
  CHECK(reader.poll().is_published == 0);
}

TEST_CASE("A hand that the session does not have is named with those that it has", "[library]") {
  Fixture fixture;
  fixture.hand.name = "left";
  Publisher publisher(fixture.scene);
  Reader left(fixture.session.name().c_str(), "left"), right(fixture.session.name().c_str(), "rig");
  CHECK(left.poll().is_published == 1);
  CHECK(code_of([&] { right.poll(); }) == STILLGRID_E_ARGUMENT);
  CHECK(last_error_has("'left'"));
}

TEST_CASE("A sphere of a material that there is not is told to nobody", "[library]") {
  const publication::TestSession session;
  publication::StaticScene scene;
  scene.name = "liar";
  scene.materials = {{500.0F, 1.0F, 0.2F, 1e-3F}};
  scene.tool = {{{0.0F, 0.0F, 0.0F}, 0.005F}};
  scene.device = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}, 1.0};
  publication::SceneWriter writer(session.name(), scene, 1, 30'000'000, proto::Clock::kVirtual, 0);
  collision::VoxelGrid grid(sizeof(proto::SnapshotHeader), 1);
  grid.records()[0].radius_m = 0.01F;
  grid.records()[0].material = 1;
  const std::vector<proto::SphereState> states{
      collision::sphere_state({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0})};
  grid.push_snapshot(states);
  grid.enter(collision::history_bounds(grid.records()), 1.0F);
  writer.publish(grid, {});
  Reader reader(session.name().c_str());
  reader.poll();
  Spheres spheres(1);
  spheres.radii[0] = -1.0F;
  CHECK(code_of([&] { reader.snapshot(spheres); }) == STILLGRID_E_SESSION);
  CHECK(last_error_has("material 1: expected less than 1"));
  CHECK(spheres.radii[0] == -1.0F);
}

TEST_CASE("A second thread inside a reader is turned away", "[library]") {
  Fixture fixture;
  Publisher publisher(fixture.scene);
  Reader reader(fixture.session.name().c_str());
  std::atomic<bool> is_over = false;
  std::atomic<int> refused = 0, wrong = 0;
  const auto poll = [&] {
    while (!is_over) {
      SessionState state;
      const int code = stillgrid_reader_poll(reader.handle(), &state);
      if (code == STILLGRID_E_THREAD) ++refused;
      if (code != STILLGRID_OK && code != STILLGRID_E_THREAD) ++wrong;
    }
  };
  std::jthread first(poll), second(poll);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (refused == 0 && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  is_over = true;
  first.join();
  second.join();
  CHECK(refused > 0);
  CHECK(wrong == 0);
}

}  // namespace
}  // namespace stillgrid::library::reader_faults_test
