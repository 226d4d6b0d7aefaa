#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "shared/publication/relay_figures.hpp"
#include "shared/reading/segment_follower.hpp"
#include "shared/tools/segment_inspect/inspection_json.hpp"
#include "shared/tools/segment_inspect/inspection_text.hpp"
#include "tests/shared/publication/other_process.hpp"
#include "tests/shared/publication/relay_words.hpp"
#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid::segment_inspect::relay_test {
namespace {

using Json = nlohmann::ordered_json;
constexpr auto kScene = proto::SegmentKind::kScene;
constexpr auto kTool = proto::SegmentKind::kTool;

/// The text of a session's one segment, and its row.
std::string detail_of_scene(const publication::TestSession& session) {
  const reading::ObservedSegment scene = reading::observe({session.name(), kScene});
  return detail_of(json_of(session.name(), &scene, nullptr, {.max_spheres = 0}));
}
Json row_of_scene(const publication::TestSession& session) {
  return json_of(reading::observe({session.name(), kScene}).summary);
}

TEST_CASE("How a relay's scene came is a line of its text and an object of its row", "[relay]") {
  const publication::TestSession session;
  publication::SmallSceneWriter scene(session);
  CHECK(detail_of_scene(session).find("relay: none\n") != std::string::npos);
  CHECK(row_of_scene(session)["relay"].is_null());

  publication::store_relay_figures(scene.writer().header(), publication::lossy_figures());

  CHECK(detail_of_scene(session).find(
            "relay:\n    connected: true\n    round_trip_ns: 20340000\n") != std::string::npos);
  CHECK(row_of_scene(session)["relay"] == Json{{"connected", true},
                                               {"round_trip_ns", 20'340'000},
                                               {"clock_offset_ns", -1'234'567'890'123},
                                               {"clock_bound_ns", 104'000},
                                               {"received", 1'234'567},
                                               {"received_bytes", 3ULL << 29U},
                                               {"lost", 1'002},
                                               {"repeated", 7},
                                               {"out_of_order", 0},
                                               {"late", 3},
                                               {"refused", 1},
                                               {"partitions", 2},
                                               {"longest_silence_ns", 3'140'000'000}});
}

TEST_CASE("A relay's tool that was looked at before tells its newest figures", "[relay]") {
  const publication::TestSession session;
  publication::ToolWriter writer(session.name(), 1'000'000, proto::Clock::kVirtual, 0);
  reading::ObservedSegment tool = reading::observe({session.name(), kTool});
  CHECK_FALSE(tool.summary.relay);
  proto::RelayFigures figures = publication::lossy_figures();
  for (figures.lost = 1; figures.lost < 4; ++figures.lost) {
    publication::store_relay_figures(writer.header(), figures);
    reading::look_again(tool);
    REQUIRE(tool.summary.relay);
    CHECK(tool.summary.relay->lost == figures.lost);
  }
}

TEST_CASE("What was not measured is not told", "[relay]") {
  const publication::TestSession session;
  publication::SmallSceneWriter scene(session);
  publication::store_relay_figures(scene.writer().header(), publication::lonely_figures());

  CHECK(detail_of_scene(session).find("    round_trip_ns: none\n") != std::string::npos);
  const Json relay = row_of_scene(session)["relay"];
  CHECK(relay["connected"] == false);
  for (const char* name : {"round_trip_ns", "clock_offset_ns", "clock_bound_ns"})
    CHECK(relay[name].is_null());
}

TEST_CASE("Whatever words stand for a relay its text and its row are bounded", "[relay]") {
  const publication::TestSession session;
  publication::SmallSceneWriter scene(session);
  const std::size_t without = detail_of_scene(session).size();
  std::mt19937_64 random(GENERATE(1U, 2U, 3U));
  int shown = 0;
  for (int round = 0; round < 200; ++round) {
    std::array<std::uint64_t, sizeof(proto::RelayFigures) / 8> words;
    // Of any length: few of 64 random bits are small.
    for (std::uint64_t& word : words) word = random() >> (random() % 64);
    words[1] = round % 2 == 0 ? words[1] % 2 : words[1];
    publication::store_relay_figures(scene.writer().header(),
                                     std::bit_cast<proto::RelayFigures>(words));
    const std::string text = detail_of_scene(session);
    REQUIRE(text.size() < without + 800);
    for (const char* none : {": nan", ": inf"}) REQUIRE(text.find(none) == std::string::npos);
    const Json relay = row_of_scene(session)["relay"];
    REQUIRE(relay.is_null() == (text.find("relay: none\n") != std::string::npos));
    if (relay.is_null()) continue;
    ++shown;
    REQUIRE(relay["lost"].get<std::uint64_t>() <= publication::kLargestRelayCount);
  }
  CHECK(shown > 5);
}

TEST_CASE("A writer is silent while its relay hears nothing, and dead once it is killed",
          "[relay]") {
  const publication::TestSession session;
  reading::SegmentFollower follower(session.name(), kScene);
  const auto look = [&] {
    follower.look();
    return std::string(name_of(follower.life()));
  };
  CHECK(look() == "absent");
  {
    publication::SmallSceneWriter scene(session);
    CHECK(look() == "alive");
    publication::store_relay_figures(scene.writer().header(), publication::lossy_figures());
    CHECK(look() == "alive");
    REQUIRE(follower.relay());
    CHECK(follower.relay()->late == 3);
    publication::store_relay_figures(scene.writer().header(), publication::lonely_figures());
    CHECK(look() == "silent");
  }
  CHECK(look() == "absent");
  publication::OtherProcess killed([&](const auto& ready) {
    publication::SmallSceneWriter scene(session);
    publication::store_relay_figures(scene.writer().header(), publication::lonely_figures());
    ready();
    publication::OtherProcess::rest();
  });
  REQUIRE(killed.was_ready());
  killed.kill();
  CHECK(look() == "dead");
}

}  // namespace
}  // namespace stillgrid::segment_inspect::relay_test
