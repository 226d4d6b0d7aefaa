#include "tests/fuzz/valid_segment.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "shared/publication/tool_segment.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/fuzz/hostile_object.hpp"
#include "tests/shared/collision/sphere_state.hpp"

namespace stillgrid::fuzz {
namespace {

constexpr std::uint64_t kPeriod_ns = 30'000'000;
constexpr std::uint32_t kMovingSpheres = 32;  // enough for a level of small ones

/// A ball whose fields are fine near its surface only: one at rest, and one that moves.
std::vector<publication::PublishedField> small_fields() {
  const Eigen::AlignedBox3d box_m(Eigen::Vector3d::Constant(-0.02),
                                  Eigen::Vector3d::Constant(0.02));
  const auto field = std::make_shared<collision::DistanceField>(collision::make_field(
      box_m, {0.004, 0.003, 0.02}, [](const Eigen::Vector3d& p) { return p.norm() - 0.02; },
      [](const Eigen::Vector3d& p) { return 1.0 + 10.0 * p.x(); }));
  std::vector<publication::PublishedField> fields(2, {proto::FieldBody{}, field});
  fields[0].body.rest.position_m = {0.0F, 0.03F, 0.0F};
  fields[0].body.rest.orientation_xyzw = {0.0F, 0.6F, 0.0F, 0.8F};
  fields[1].body.moving = 1;
  fields[1].body.material = 1;
  return fields;
}

/// Turning.
proto::FieldRecord field_record(std::uint64_t n) {
  proto::FieldRecord record{};
  const auto x = 0.004F * static_cast<float>(n);
  record.history.fill(
      {{x, -0.02F, 0.0F}, {0.6F, 0.0F, 0.0F, 0.8F}, {0.1F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}, 0.0F});
  return record;
}

publication::StaticScene small_scene() {
  publication::StaticScene scene;
  scene.name = "fuzz";
  scene.materials = {{500.0F, 1.0F, 0.2F, 1e-3F}, {2000.0F, 4.0F, 0.4F, 2e-3F}};
  scene.planes = {{{0.0F, 0.0F, 1.0F}, -0.02F, 1, 5}};
  scene.tool = {{{0.0F, 0.0F, 0.0F}, 0.02F}, {{0.0F, 0.0F, 0.01F}, 0.01F}};
  scene.spheres = {collision::static_sphere({0.0F, 0.0F, -0.03F}, 0.02F),
                   collision::static_sphere({0.02F, 0.0F, -0.03F}, 0.01F),
                   collision::static_sphere({0.0F, 0.0F, -0.03F}, 0.2F)};
  for (proto::SphereRecord& sphere : scene.spheres) sphere.material = 1;
  scene.fields = small_fields();
  scene.device = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.6, 0.8}, 2.0};
  return scene;
}

/// What a writer of this process has put under its name.
std::vector<std::byte> published(proto::SegmentKind kind, std::uint64_t layout_hash) {
  const auto reader = publication::SegmentReader::open(HostileObject::session(), kind, layout_hash);
  require(reader.has_value(), "a writer's segment can be read");
  const auto size_bytes = static_cast<std::size_t>(reader->header().size_bytes);
  return {reader->bytes(), reader->bytes() + size_bytes};
}

/// The same segment with gaps, and without what differs from run to run.
std::vector<std::byte> with_gaps(const std::vector<std::byte>& tight) {
  proto::SegmentHeader header = header_of(tight);
  const auto slot_bytes =
      static_cast<std::size_t>(sizeof(proto::SlotHeader) + header.payload_bytes + 63) / 64 * 64;
  const auto fixed_bytes = static_cast<std::size_t>(header.slot_offset[0]);
  const std::array<std::uint64_t, 2> before = header.slot_offset;
  header.slot_offset = {fixed_bytes + kGapBytes, fixed_bytes + slot_bytes + 2 * kGapBytes};
  header.size_bytes = fixed_bytes + 2 * slot_bytes + 3 * kGapBytes;
  header.epoch = 1;
  header.writer_pid = 1;
  header.relay.relay_id = header.relay.connected = 1;  // so that its figures are looked at
  std::vector<std::byte> bytes(static_cast<std::size_t>(header.size_bytes));
  std::copy_n(tight.begin(), fixed_bytes, bytes.begin());
  for (std::size_t slot = 0; slot < 2; ++slot)
    std::memcpy(&bytes[header.slot_offset[slot]], &tight[before[slot]],
                sizeof(proto::SlotHeader) + static_cast<std::size_t>(header.payload_bytes));
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

}  // namespace

const proto::SegmentHeader& header_of(std::span<const std::byte> segment) {
  return *reinterpret_cast<const proto::SegmentHeader*>(segment.data());
}

std::vector<std::byte> valid_scene() {
  publication::SceneWriter writer(HostileObject::session(), small_scene(), kMovingSpheres,
                                  kPeriod_ns, proto::Clock::kVirtual, 0);
  collision::VoxelGrid snapshot(sizeof(proto::SnapshotHeader), kMovingSpheres);
  for (std::uint32_t i = 0; i < kMovingSpheres; ++i) {
    snapshot.records()[i].radius_m = i >= kMovingSpheres / 2 ? 0.1F : 0.01F;  // of two levels
    snapshot.records()[i].material = i % 2;
    snapshot.records()[i].body = i;
  }
  for (std::uint64_t n = 1; n <= 3; ++n) {
    std::vector<proto::SphereState> snapshots;
    for (std::size_t i = 0; i < kMovingSpheres; ++i)
      snapshots.push_back(collision::sphere_state(
          {0.01 * static_cast<double>(i), 0.004 * static_cast<double>(n), 0.0}, {0.5, 0.0, 0.1}));
    snapshot.push_snapshot(snapshots);
    snapshot.enter(collision::history_bounds(snapshot.records()), 1.0F);
    const std::array records{field_record(n)};
    writer.publish(snapshot, {.state_ns = n * kPeriod_ns, .publish_ns = n * kPeriod_ns + 5},
                   records);
  }
  return with_gaps(published(proto::SegmentKind::kScene, proto::kSceneLayoutHash));
}

std::vector<std::byte> valid_tool() {
  publication::ToolWriter writer(HostileObject::session(), 1'000'000, proto::Clock::kVirtual, 0);
  for (std::uint64_t tick = 1; tick <= 2; ++tick)
    writer.publish({.time_ns = tick * 1'000'000,
                    .tick = tick,
                    .path_number = tick,
                    .position_m = {0.0, 0.0, 0.02},
                    .orientation_xyzw = {0.0, 0.6, 0.0, 0.8},
                    .velocity_m_s = {0.0, 0.0, -0.1},
                    .force_N = {0.0, 0.0, 1.0},
                    .buttons = 0,
                    .before = {},
                    .device = {}});
  return with_gaps(published(proto::SegmentKind::kTool, proto::kToolLayoutHash));
}

std::vector<std::span<std::byte>> changing_parts(std::span<std::byte> segment) {
  const proto::SegmentHeader& header = header_of(segment);
  std::vector<std::size_t> starts{0};  // of a payload's parts
  if (header.kind == proto::SegmentKind::kScene) {
    proto::SceneHeader scene{};
    std::memcpy(&scene, &segment[sizeof header], sizeof scene);
    const collision::GridLayout layout =
        collision::grid_layout(sizeof(proto::SnapshotHeader), scene.moving_capacity);
    for (const std::size_t word :
         {layout.records, layout.cell_starts, layout.swept_bounds, layout.numbers})
      starts.push_back(8 * word);
    starts.push_back(static_cast<std::size_t>(header.payload_bytes) - sizeof(proto::FieldRecord));
  }
  starts.push_back(static_cast<std::size_t>(header.payload_bytes));
  std::vector<std::span<std::byte>> parts{
      segment.subspan(offsetof(proto::SegmentHeader, latest), 8)};
  for (const std::uint64_t offset : header.slot_offset) {
    const auto slot = segment.subspan(static_cast<std::size_t>(offset));
    parts.push_back(slot.first(8));
    for (std::size_t i = 0; i + 1 < starts.size(); ++i)
      parts.push_back(
          slot.subspan(sizeof(proto::SlotHeader) + starts[i], starts[i + 1] - starts[i]));
  }
  if (header.kind == proto::SegmentKind::kTool)  // the path's samples that there are
    parts.push_back(segment.subspan(
        sizeof header, offsetof(proto::ToolPath, samples) + 4 * sizeof(proto::PathSample)));
  return parts;
}

std::vector<std::unique_ptr<ForbiddenBytes>> forbid_gaps(const std::byte* start,
                                                         std::span<const std::byte> segment) {
  const proto::SegmentHeader& header = header_of(segment);
  std::vector<std::unique_ptr<ForbiddenBytes>> gaps;
  for (const std::uint64_t end : {header.slot_offset[0], header.slot_offset[1], header.size_bytes})
    gaps.push_back(std::make_unique<ForbiddenBytes>(std::span(start + end - kGapBytes, kGapBytes)));
  return gaps;
}

}  // namespace stillgrid::fuzz
