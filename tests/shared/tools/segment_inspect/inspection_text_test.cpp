#include "shared/tools/segment_inspect/inspection_text.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "shared/tools/segment_inspect/inspection_json.hpp"
#include "tests/shared/publication/field_scene.hpp"
#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid::segment_inspect::inspection_text_test {
namespace {

using Json = nlohmann::ordered_json;
constexpr auto kScene = proto::SegmentKind::kScene;

reading::SegmentSummary refused(const std::string& session, const std::string& why) {
  reading::SegmentSummary summary;
  summary.file = {session, kScene};
  summary.state = reading::SegmentState::kRefused;
  summary.refusal = why;
  return summary;
}

TEST_CASE("A size is told in the unit that suits it", "[inspection_text]") {
  CHECK(size_text(0) == "0 B");
  CHECK(size_text(1023) == "1023 B");
  CHECK(size_text(4096) == "4.0 KiB");
  CHECK(size_text(1024 * 1024 - 1) == "1.0 MiB");
  CHECK(size_text(3ULL << 29U) == "1.5 GiB");
  CHECK(size_text(UINT64_MAX) == "16777216.0 TiB");
}

TEST_CASE("A table has one line for each segment whatever its name holds", "[inspection_text]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const std::array summaries{refused("a\n\x1B[2J", "it is not ours"),
                             reading::observe({session.name(), kScene}).summary};

  const std::string table = table_of(json_of(summaries));

  CHECK(std::count(table.begin(), table.end(), '\n') == 3);
  CHECK(table.find('\x1B') == std::string::npos);
  CHECK(table.find("refused: it is not ours\n") != std::string::npos);
  CHECK(table.find(session.name()) != std::string::npos);
  CHECK(table.find("33.3 Hz") != std::string::npos);
  CHECK(table.find(" 7+10 ") != std::string::npos);
  CHECK(table.find("virtual") != std::string::npos);
}

TEST_CASE("A table of nothing says so", "[inspection_text]") {
  CHECK(table_of(Json::array()) == "no session in shared memory\n");
}

TEST_CASE("A long refusal does not widen the other rows", "[inspection_text]") {
  const publication::TestSession session;
  const publication::SmallSceneWriter writer(session);
  const std::array summaries{refused("a", std::string(300, 'x')),
                             reading::observe({session.name(), kScene}).summary};
  const std::string table = table_of(json_of(summaries));
  CHECK(table.find('\n') < 150);
}

TEST_CASE("A session in detail tells the scene, its snapshot and what is absent",
          "[inspection_text]") {
  const publication::TestSession session;
  publication::SmallSceneWriter writer(session);
  const auto detail = [&] {
    const reading::ObservedSegment scene = reading::observe({session.name(), kScene});
    return detail_of(json_of(session.name(), &scene, nullptr, {.max_spheres = 0}));
  };
  CHECK(detail().find("snapshot: none\n") != std::string::npos);
  writer.publish_next();
  const std::string text = detail();
  for (const char* words : {"name: small", "stiffness_N_per_m 500,", "stiffness_N_per_m 2000,",
                            "normal (0, 0, 1)", "tool_spheres 1: ", "scale: 2", "moving_spheres: 7",
                            "static_spheres: 10", "contacts: 1", "tool: none"})
    CHECK(text.find(words) != std::string::npos);
}

TEST_CASE("A session in detail tells each field's cells and bytes", "[inspection_text]") {
  const publication::TestSession session;
  const publication::StaticScene fixed = publication::field_scene();
  const publication::SceneWriter writer(session.name(), fixed, 0, publication::kPeriod_ns,
                                        proto::Clock::kVirtual, 0);
  const reading::ObservedSegment scene = reading::observe({session.name(), kScene});
  const std::string text = detail_of(json_of(session.name(), &scene, nullptr, {}));
  CHECK(text.find("moves false, cell_m 0.0021,") != std::string::npos);
  CHECK(text.find("moves true, cell_m 0.0019,") != std::string::npos);
  CHECK(text.find("bytes " + std::to_string(fixed.fields[1].field->bytes())) != std::string::npos);
}

}  // namespace
}  // namespace stillgrid::segment_inspect::inspection_text_test
