#include "shared/publication/snapshot_reader.hpp"

#include <catch2/catch.hpp>

#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid::publication::snapshot_reader_test {
namespace {

SceneView view_of(const TestSession& session) {
  return SceneView(
      *SegmentReader::open(session.name(), proto::SegmentKind::kScene, proto::kSceneLayoutHash));
}

SnapshotLook look(SnapshotReader& reader, const SceneView& view) {
  return reader.look(view, [](const proto::SnapshotHeader&, const collision::GridView&) {});
}

TEST_CASE("A snapshot is new once, and the first of its segment once", "[snapshot_reader]") {
  const TestSession session;
  SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  SnapshotReader reader;
  CHECK(reader.turn_to(view));
  CHECK_FALSE(reader.turn_to(view));
  CHECK(look(reader, view).status == double_buffer::ReadStatus::kEmpty);
  CHECK_FALSE(reader.has_snapshot());
  for (std::uint64_t n = 1; n <= 3; ++n) {
    writer.publish_next();
    const SnapshotLook first = look(reader, view), again = look(reader, view);
    CHECK((first.accepted() && again.accepted()));
    CHECK((first.is_new && !again.is_new));
    CHECK((first.is_first == (n == 1) && !again.is_first));
    CHECK(reader.snapshot().snapshot_id == n);
  }
}

TEST_CASE("The last snapshot stands when the latest is overtaken, or its memory is lost",
          "[snapshot_reader]") {
  const TestSession session, other;
  SmallSceneWriter writer(session), another(other);
  const SceneView view = view_of(session);
  const double_buffer::DoubleBuffer& buffer = writer.writer().segment().buffer();
  SnapshotReader reader;
  reader.turn_to(view);
  writer.publish_next();
  CHECK(look(reader, view).is_new);

  writer.publish_next();
  *buffer.sequence[0] = 3;  // the second's slot is being written
  CHECK(look(reader, view).status == double_buffer::ReadStatus::kContended);
  CHECK(reader.snapshot().snapshot_id == 1);
  *buffer.latest = 0;  // as a shrunk object reads
  CHECK(look(reader, view).status == double_buffer::ReadStatus::kEmpty);
  CHECK(reader.snapshot().snapshot_id == 1);

  CHECK(reader.turn_to(view_of(other)));
  CHECK_FALSE(reader.has_snapshot());
}

TEST_CASE("A snapshot under another number than its header's, or an earlier one, is not believed",
          "[snapshot_reader]") {
  const TestSession session;
  SmallSceneWriter writer(session);
  const SceneView view = view_of(session);
  const double_buffer::DoubleBuffer& buffer = writer.writer().segment().buffer();
  SnapshotReader reader;
  reader.turn_to(view);
  const std::uint64_t lie = GENERATE(as<std::uint64_t>{}, 0, 1, 4, 6, ~std::uint64_t{0});
  for (int n = 1; n <= 5; ++n) writer.publish_next();
  *buffer.payload[1] = lie;  // the fifth's header begins with its number
  CHECK(look(reader, view).status == double_buffer::ReadStatus::kContended);
  CHECK_FALSE(reader.has_snapshot());

  *buffer.payload[1] = 5;
  CHECK(look(reader, view).accepted());
  *buffer.latest = 4;  // whole, under its own number, but before the last
  CHECK(look(reader, view).status == double_buffer::ReadStatus::kContended);
  CHECK(reader.snapshot().snapshot_id == 5);
  *buffer.latest = 5;
  CHECK(look(reader, view).accepted());
}

}  // namespace
}  // namespace stillgrid::publication::snapshot_reader_test
