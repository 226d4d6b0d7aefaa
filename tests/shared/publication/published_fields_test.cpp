#include "shared/publication/published_fields.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <random>

#include "shared/collision/grid_query.hpp"
#include "tests/shared/publication/field_scene.hpp"
#include "tests/shared/publication/tampering.hpp"

namespace stillgrid::publication::published_fields_test {
namespace {

constexpr auto kScene = proto::SegmentKind::kScene;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

SceneView view_of(const TestSession& session) {
  auto reader = SegmentReader::open(session.name(), kScene, proto::kSceneLayoutHash);
  REQUIRE(reader);
  return SceneView(std::move(*reader));
}

/// A writer of that scene, without a snapshot yet.
struct FieldWriter {
  explicit FieldWriter(const TestSession& session, const StaticScene& scene = field_scene())
      : writer(session.name(), scene, kMovingSpheres, kPeriod_ns, proto::Clock::kVirtual, 0) {}
  SceneWriter writer;
  collision::VoxelGrid snapshot{sizeof(proto::SnapshotHeader), kMovingSpheres};

  void publish(std::uint64_t n) {
    const std::vector<proto::FieldRecord> records{field_record(1, n), field_record(2, n)};
    writer.publish(snapshot, {.state_ns = n * kPeriod_ns}, records);
  }
};

/// What a reader says of a fixed part whose fields were spoilt after its writer wrote it.
template <class Spoil>
std::string refusal_when(Spoil&& spoil) {
  const TestSession session;
  FieldWriter writer(session);
  writer.publish(1);
  const Tampering memory(session.path(kScene));
  spoil(memory.at<proto::SceneHeader>(sizeof(proto::SegmentHeader)), writer.writer.header());
  const std::string refusal = refusal_of([&] {
    auto reader = SegmentReader::open(session.name(), kScene, proto::kSceneLayoutHash);
    if (reader) const SceneView view(std::move(*reader));
  });
  CHECK(refusal.find('\n') == std::string::npos);
  return refusal;
}

/// Refused for what its field says.
template <class Spoil>
bool is_refused(std::size_t field, Spoil&& spoil) {
  return refusal_when([&](proto::SceneHeader& scene, auto&) {
           spoil(scene.fields[field]);
         }).find("its field " + std::to_string(field)) != std::string::npos;
}

}  // namespace

TEST_CASE("A reader samples what the writer's fields say", "[published_fields]") {
  const TestSession session;
  const FieldWriter writer(session);
  const SceneView view = view_of(session);
  const StaticScene scene = field_scene();
  std::mt19937 random(GENERATE(1U, 2U, 3U));
  std::uniform_real_distribution<double> place_m(-0.03, 0.03);

  REQUIRE(view.fields().size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& [body, field] = view.fields()[i];
    const proto::FieldBody& given = scene.fields[i].body;
    CHECK(body.material == given.material);
    CHECK(body.body == given.body);
    CHECK(body.moving == given.moving);
    CHECK(body.rest.position_m == given.rest.position_m);
    CHECK(field.words != scene.fields[i].field->words().data());
    for (int k = 0; k < 200; ++k) {
      const double x = place_m(random), y = place_m(random), z = place_m(random);
      const auto own = collision::sample(scene.fields[i].field->view(), {x, y, z});
      const auto read = collision::sample(field, {x, y, z});
      REQUIRE(read.has_value() == own.has_value());
      if (!own) continue;
      CHECK(read->distance_m == own->distance_m);
      CHECK(read->gradient == own->gradient);
      CHECK(read->stiffness_scale == own->stiffness_scale);
    }
  }
}

TEST_CASE("Bodies of one shape share its field", "[published_fields]") {
  const TestSession session, apart;
  const FieldWriter writer(session);
  const SceneView view = view_of(session);
  CHECK(view.fields()[0].field.words == view.fields()[2].field.words);
  CHECK(view.fields()[0].field.words != view.fields()[1].field.words);

  StaticScene scene = field_scene();
  const std::size_t field_bytes = scene.fields[2].field->bytes();
  scene.fields[2].field = std::make_shared<const collision::DistanceField>(*test_ball());
  FieldWriter other(apart, scene);
  CHECK(other.writer.header().slot_offset[0] - view.header().slot_offset[0] ==
        (field_bytes + 63) / 64 * 64);
}

TEST_CASE("Copies of a reader's fields are the writer's, shared as they are",
          "[published_fields]") {
  const TestSession session;
  const FieldWriter writer(session);
  const SceneView view = view_of(session);
  const StaticScene scene = field_scene();
  const auto copies = copy_fields(view.fields(), view.reader().fixed_bytes());
  REQUIRE(copies.size() == 3);
  CHECK(copies[0] == copies[2]);
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(std::ranges::equal(copies[i]->words(), scene.fields[i].field->words()));
  const std::size_t bytes = copies[0]->bytes() + copies[1]->bytes();
  CHECK_NOTHROW(copy_fields(view.fields(), bytes));
  CHECK_THROWS_AS(copy_fields(view.fields(), bytes - 8), SegmentError);
}

TEST_CASE("Exact shapes take no room and are told apart by their sides", "[published_fields]") {
  const TestSession session;
  StaticScene scene = small_scene();
  scene.fields = {published_field(0, 1, 7, test_box(0.01F)),
                  published_field(0, 0, 8, test_box(0.02F)),
                  published_field(0, 1, 9, test_box(0.01F))};
  for (PublishedField& field : scene.fields) field.body.rest.orientation_xyzw = {0, 0, 0, 1};
  const FieldWriter writer(session, scene);
  const SceneView view = view_of(session);
  const auto copies = copy_fields(view.fields(), 0);
  REQUIRE(copies.size() == 3);
  CHECK(copies[0] == copies[2]);
  CHECK(copies[0] != copies[1]);
  for (std::size_t i = 0; i < 3; ++i) {
    const proto::FieldShape own = copies[i]->shape(), given = scene.fields[i].field->shape();
    CHECK(std::memcmp(&own, &given, sizeof own) == 0);
  }
}

TEST_CASE("A slot tells of each moving field what its snapshot does", "[published_fields]") {
  const TestSession session;
  FieldWriter writer(session);
  const SceneView view = view_of(session);
  for (std::uint64_t n = 1; n <= 5; ++n) {
    writer.publish(n);
    const auto read = double_buffer::read_latest(view.buffer(), [&](const std::uint64_t* payload) {
      const collision::GridView grid = view.moving_grid(payload, load_snapshot(payload));
      REQUIRE(grid.field_count == 2);
      for (std::uint32_t moving = 1; moving <= 2; ++moving) {
        const proto::FieldRecord record = collision::load_field(grid, moving);
        const proto::FieldRecord given = field_record(moving, n);
        CHECK(std::memcmp(&record, &given, sizeof record) == 0);
      }
    });
    CHECK(read.status == double_buffer::ReadStatus::kAccepted);
  }
}

TEST_CASE("A rest that is nearly a unit quaternion is made one", "[published_fields]") {
  const TestSession session;
  StaticScene scene = field_scene();
  scene.fields[0].body.rest.orientation_xyzw = {0.48F, 0.0F, 0.6002F, 0.6402F};
  const FieldWriter writer(session, scene);

  const SceneView view = view_of(session);
  const auto& [x, y, z, w] = view.fields()[0].body.rest.orientation_xyzw;
  CHECK(double{x} * x + double{y} * y + double{z} * z + double{w} * w == Approx(1.0).epsilon(1e-7));
  CHECK(z / w == Approx(0.6002 / 0.6402).epsilon(1e-6));
}

TEST_CASE("Fields of a shape that none has are refused", "[published_fields]") {
  CHECK(refusal_when([](auto&, auto&) {}).empty());
  CHECK(is_refused(1, [](auto& field) { field.shape.bricks[0] = 0; }));
  CHECK(is_refused(1, [](auto& field) { field.shape.bricks[1] = 0xFFFFFFFF; }));
  CHECK(is_refused(1, [](auto& field) { field.shape.bricks = {4000, 4000, 4000}; }));
  CHECK(is_refused(0, [](auto& field) { field.shape.fine_count = 0xFFFFFFFF; }));
  CHECK(is_refused(0, [](auto& field) { field.shape.has_stiffness = 2; }));
  for (const std::uint32_t kind : {1U, 2U, 3U, proto::kFieldKinds, 0xFFFFFFFFU})
    CHECK(is_refused(0, [&](auto& field) { field.shape.kind = kind; }));
  for (const float bad : {kNaN, INFINITY, -INFINITY, 1e7F}) {
    CHECK(is_refused(2, [&](auto& field) { field.shape.brick_m = bad; }));
    CHECK(is_refused(2, [&](auto& field) { field.shape.bounding_radius_m = bad; }));
    CHECK(is_refused(2, [&](auto& field) { field.shape.lowest_m[1] = bad; }));
    CHECK(is_refused(2, [&](auto& field) { field.shape.centre_m[2] = bad; }));
  }
}

TEST_CASE("Fields that lead outside of the fixed part are refused", "[published_fields]") {
  CHECK(refusal_when([](auto& scene, auto&) {
          scene.field_count = proto::kMaxFields + 1;
        }).find("counts 513 fields") != std::string::npos);
  CHECK(is_refused(1, [](auto& field) { field.shape.bricks[2] += 400; }));
  CHECK(is_refused(0, [](auto& field) { field.offset += 8; }));
  CHECK(is_refused(0, [](auto& field) { field.offset = 0; }));
  CHECK(is_refused(0, [](auto& field) { field.offset -= 64; }));
  CHECK(is_refused(1, [](auto& field) { field.offset += 64; }));  // the last
  CHECK(is_refused(0, [](auto& field) { field.offset = UINT64_MAX - 63; }));
  CHECK(refusal_when([](auto&, auto& header) {
          header.payload_bytes -= 8;
        }).find("slots are too small") != std::string::npos);
}

TEST_CASE("Fields that name what there is not are refused", "[published_fields]") {
  CHECK(refusal_when([](auto& scene, auto&) { scene.field_count = 4; }).find("its field 3") !=
        std::string::npos);
  CHECK(is_refused(0, [](auto& field) { field.material = 2; }));
  CHECK(is_refused(0, [](auto& field) { field.moving = 2; }));
  CHECK(is_refused(1, [](auto& field) { field.moving = 2; }));
  CHECK(is_refused(2, [](auto& field) { field.moving = 1; }));
  CHECK(is_refused(2, [](auto& field) { field.moving = 0xFFFFFFFF; }));
}

TEST_CASE("A field at rest nowhere is refused", "[published_fields]") {
  for (const float bad : {kNaN, INFINITY, -INFINITY, -2e6F}) {
    CHECK(is_refused(0, [&](auto& field) { field.rest.position_m[2] = bad; }));
    CHECK(is_refused(0, [&](auto& field) { field.rest.orientation_xyzw[0] = bad; }));
    CHECK(is_refused(0, [&](auto& field) { field.rest.velocity_m_s[0] = bad; }));
    CHECK(is_refused(0, [&](auto& field) { field.rest.angular_velocity_rad_s[1] = bad; }));
  }
  CHECK(is_refused(0, [](auto& field) { field.rest.orientation_xyzw = {}; }));
  CHECK(is_refused(0, [](auto& field) { field.rest.orientation_xyzw[2] *= 1.1F; }));
}

}  // namespace stillgrid::publication::published_fields_test
