#include "shared/publication/scene_segment.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include "shared/collision/unit_quaternion.hpp"
#include "shared/publication/hands.hpp"

namespace stillgrid::publication {
namespace {

constexpr std::size_t kStaticOffset =
    (sizeof(proto::SegmentHeader) + sizeof(proto::SceneHeader) + 63) / 64 * 64;

collision::VoxelGrid static_grid_of(const StaticScene& scene) {
  collision::VoxelGrid grid(0, scene.spheres.size());
  std::copy(scene.spheres.begin(), scene.spheres.end(), grid.records().begin());
  grid.enter(collision::history_bounds(scene.spheres), scene.voxel_ratio);
  return grid;
}

std::size_t static_end_bytes(const collision::GridLayout& still) {
  return kStaticOffset + still.total_words * 8;
}
/// Where the touch lists stand: behind the static grid. Bytes from the segment's start.
std::size_t touch_offset(const collision::GridLayout& still) {
  return (static_end_bytes(still) + 63) / 64 * 64;
}

proto::SceneHeader scene_header(const StaticScene& scene, const collision::VoxelGrid& static_grid,
                                const collision::TouchLists& touch_lists,
                                const collision::GridLayout& moving, const FieldPlaces& fields) {
  assert(scene.materials.size() <= proto::kMaxMaterials);
  assert(scene.planes.size() <= proto::kMaxPlanes && scene.tool.size() <= proto::kMaxToolSpheres);
  proto::SceneHeader header{};
  scene.name.copy(header.name.data(), header.name.size() - 1);
  header.material_count = static_cast<std::uint32_t>(scene.materials.size());
  header.plane_count = static_cast<std::uint32_t>(scene.planes.size());
  header.tool_sphere_count = static_cast<std::uint32_t>(scene.tool.size());
  header.moving_capacity = static_cast<std::uint32_t>(moving.sphere_capacity);
  header.tool_slip_speed_m_s = scene.tool_slip_speed_m_s;
  header.static_offset = kStaticOffset;
  header.device = scene.device;
  header.static_grid = static_grid.view().shape;
  std::copy(scene.materials.begin(), scene.materials.end(), header.materials.begin());
  std::copy(scene.planes.begin(), scene.planes.end(), header.planes.begin());
  std::copy(scene.tool.begin(), scene.tool.end(), header.tool.begin());
  header.field_count = static_cast<std::uint32_t>(fields.bodies.size());
  std::copy(fields.bodies.begin(), fields.bodies.end(), header.fields.begin());
  header.touch_lists = touch_lists.shape();
  header.touch_lists.offset = touch_offset(static_grid.layout());
  header.model_offset = (fields.end_bytes + 7) / 8 * 8;
  header.model_bytes = scene.model.size();
  header.state_capacity = scene.model.empty() ? 0 : (scene.state_capacity + 7) / 8 * 8;
  assert(scene.hands.size() <= proto::kMaxHands);
  header.hand_count = static_cast<std::uint32_t>(scene.hands.size());
  header.hand = static_cast<std::uint32_t>(scene.hand);
  for (std::size_t i = 0; i < scene.hands.size(); ++i)
    scene.hands[i].copy(header.hands[i].data(), proto::kHandNameBytes - 1);
  return header;
}

/// Where the fields are in a slot: behind the grid.
std::size_t field_word(const collision::GridLayout& moving) {
  return (moving.total_words + 7) / 8 * 8;
}

std::size_t payload_words(const collision::GridLayout& moving, std::size_t moving_fields) {
  return field_word(moving) + moving_fields * sizeof(proto::FieldRecord) / 8;
}

/// Where the state is: behind the fields.
std::size_t state_word(const collision::GridLayout& moving, std::size_t moving_fields) {
  return (payload_words(moving, moving_fields) + 7) / 8 * 8;
}

std::size_t slot_bytes(const collision::GridLayout& moving, std::size_t moving_fields,
                       std::size_t state_capacity) {
  return state_capacity == 0 ? payload_words(moving, moving_fields) * 8
                             : state_word(moving, moving_fields) * 8 + state_capacity;
}

SegmentSpec scene_spec(const FieldPlaces& fields, const collision::GridLayout& moving,
                       const proto::SceneHeader& scene, std::uint64_t period_ns, proto::Clock clock,
                       std::uint64_t start_ns, std::optional<gid_t> readers) {
  return {.kind = proto::SegmentKind::kScene,
          .layout_hash = proto::kSceneLayoutHash,
          .period_ns = period_ns,
          .clock = clock,
          .start_ns = start_ns,
          .fixed_bytes = scene.model_offset + scene.model_bytes,
          .payload_bytes = slot_bytes(moving, fields.moving_count, scene.state_capacity),
          .readers = readers};
}

template <class... Values>
bool all_finite(Values... values) {
  return (std::isfinite(values) && ...);
}

/// Segments are opened by these names. A hand without a name has a session to itself.
bool are_sound_hands(const proto::SceneHeader& scene) {
  const std::size_t count = scene.hand_count;
  if (count > proto::kMaxHands || scene.hand >= std::max<std::size_t>(count, 1)) return false;
  const auto is_good = [&](const auto& name) {
    if (name.back() != '\0') return false;
    return hand_complaint(name.data()).empty() || (count == 1 && name.front() == '\0');
  };
  return std::all_of(scene.hands.begin(), scene.hands.begin() + static_cast<std::ptrdiff_t>(count),
                     is_good);
}

}  // namespace

bool is_sound(const proto::SceneHeader& scene) {
  if (scene.name.back() != '\0' || scene.material_count > proto::kMaxMaterials ||
      scene.plane_count > proto::kMaxPlanes || scene.tool_sphere_count == 0 ||
      scene.tool_sphere_count > proto::kMaxToolSpheres || !are_sound_hands(scene))
    return false;
  const auto& device = scene.device;
  // Written so that a NaN does not pass.
  bool sound = std::all_of(device.position_m.begin(), device.position_m.end(),
                           [](double x) { return std::abs(x) <= proto::kLargestNumber; }) &&
               device.scale > 0.0 && device.scale <= proto::kLargestNumber &&
               std::isfinite(scene.tool_slip_speed_m_s) && scene.tool_slip_speed_m_s >= 0.0F &&
               collision::is_unit(device.orientation_xyzw);
  for (std::uint32_t i = 0; i < scene.material_count; ++i) {
    const auto& m = scene.materials[i];
    sound = sound &&
            all_finite(m.stiffness_N_per_m, m.damping_N_s_per_m, m.friction, m.slip_speed_m_s) &&
            m.stiffness_N_per_m >= 0 && m.damping_N_s_per_m >= 0 && m.friction >= 0 &&
            m.slip_speed_m_s > 0;
  }
  for (std::uint32_t i = 0; i < scene.plane_count; ++i) {
    const auto& [n, offset_m, material, body] = scene.planes[i];
    sound = sound && material < scene.material_count && std::isfinite(offset_m) &&
            std::abs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0F) < 1e-3F;
  }
  for (std::uint32_t i = 0; i < scene.tool_sphere_count; ++i) {
    const auto& [p, radius_m] = scene.tool[i];
    sound = sound && all_finite(p[0], p[1], p[2], radius_m) && radius_m > 0;
  }
  return sound;
}

collision::TouchLists touch_lists_of(const StaticScene& scene) {
  float largest_m = 0.0F;
  for (const proto::ToolSphere& sphere : scene.tool)
    largest_m = std::max(largest_m, sphere.radius_m);
  return {scene.spheres, touch_probe_radius_m(largest_m)};
}

SceneWriter::SceneWriter(SessionLock lock, const StaticScene& scene,
                         const collision::TouchLists& touch_lists, std::size_t moving_count,
                         std::uint64_t period_ns, proto::Clock clock, std::uint64_t start_ns,
                         std::optional<gid_t> readers)
    : moving_(collision::grid_layout(sizeof(proto::SnapshotHeader), moving_count)),
      static_grid_(static_grid_of(scene)),
      fields_(place_fields(scene.fields,
                           touch_offset(static_grid_.layout()) + touch_lists.words().size_bytes())),
      field_records_(fields_.moving_count * sizeof(proto::FieldRecord) / 8),
      fixed_(scene_header(scene, static_grid_, touch_lists, moving_, fields_)),
      segment_(std::move(lock),
               scene_spec(fields_, moving_, fixed_, period_ns, clock, start_ns, readers)) {
  std::memcpy(segment_.bytes() + sizeof(proto::SegmentHeader), &fixed_, sizeof fixed_);
  std::memcpy(segment_.bytes() + kStaticOffset, static_grid_.words().data(),
              static_grid_.words().size_bytes());
  std::memcpy(segment_.bytes() + fixed_.touch_lists.offset, touch_lists.words().data(),
              touch_lists.words().size_bytes());
  write_fields(scene.fields, fields_, segment_.bytes());
  if (!scene.model.empty())
    std::memcpy(segment_.bytes() + fixed_.model_offset, scene.model.data(), scene.model.size());
  state_.resize(fixed_.state_capacity / 8);
  segment_.announce();
}

void SceneWriter::publish(const collision::VoxelGrid& snapshot, const SnapshotTimes& times,
                          std::span<const proto::FieldRecord> fields,
                          const SnapshotState& state) noexcept {
  assert(snapshot.layout() == moving_ && fields.size() == fields_.moving_count);
  const auto push = [&](std::array<std::uint64_t, proto::kHistoryLength>& history,
                        std::uint64_t newest) {
    std::rotate(history.rbegin(), history.rbegin() + 1, history.rend());
    history[0] = newest;
    if (snapshot_.snapshot_id == 0) history.fill(newest);
  };
  push(snapshot_.state_time_ns, times.state_ns);
  push(snapshot_.publish_time_ns, times.publish_ns);
  ++snapshot_.snapshot_id;
  snapshot_.history_count =
      std::min<std::uint64_t>(snapshot_.history_count + 1, proto::kHistoryLength);
  snapshot_.tool_time_ns = times.tool_ns;
  snapshot_.step_ns = times.step_ns;
  snapshot_.contacts = times.contacts;
  snapshot_.tool_work_J = times.tool_work_J;
  const bool has_state = state.bytes.size() <= fixed_.state_capacity;
  snapshot_.state_bytes = has_state ? state.bytes.size() : 0;
  snapshot_.state_tick = state.tick;
  snapshot_.state_hash = state.hash;
  snapshot_.grid = snapshot.view().shape;

  const auto header =
      std::bit_cast<std::array<std::uint64_t, sizeof(proto::SnapshotHeader) / 8>>(snapshot_);
  const auto parts = snapshot.filled_parts();
  if (!fields.empty()) std::memcpy(field_records_.data(), fields.data(), fields.size_bytes());
  if (snapshot_.state_bytes > 0)
    std::memcpy(state_.data(), state.bytes.data(), snapshot_.state_bytes);
  const std::span<const std::uint64_t> state_words(state_.data(), (snapshot_.state_bytes + 7) / 8);
  double_buffer::publish(segment_.buffer(), snapshot_.snapshot_id,
                         {{0, header},
                          parts[0],
                          parts[1],
                          parts[2],
                          parts[3],
                          {field_word(moving_), field_records_},
                          {state_word(moving_, fields_.moving_count), state_words}});
  double_buffer::HardwareAtomics::store(segment_.header().heartbeat_ns, times.publish_ns,
                                        std::memory_order_relaxed);
}

proto::SnapshotHeader load_snapshot(const std::uint64_t* payload) noexcept {
  constexpr std::size_t kLevels =
      offsetof(proto::SnapshotHeader, grid) + offsetof(proto::GridShape, levels);
  proto::SnapshotHeader snapshot{};
  const auto head = double_buffer::load_struct<std::array<std::uint64_t, kLevels / 8>>(payload);
  std::memcpy(static_cast<void*>(&snapshot), head.data(), sizeof head);
  auto& [sphere_count, level_count, levels] = snapshot.grid;
  for (std::size_t i = 0; i < std::min(level_count, proto::kMaxLevels); ++i)
    levels[i] = double_buffer::load_struct<proto::GridLevel>(payload + kLevels / 8 +
                                                             i * (sizeof(proto::GridLevel) / 8));
  return snapshot;
}

SceneView::SceneView(SegmentReader&& reader) : reader_(std::move(reader)) {
  const auto refuse = [](const char* what) {
    throw SegmentError(std::string("the scene segment is refused: ") + what);
  };
  if (reader_.fixed_bytes() < kStaticOffset) refuse("its fixed part is too short");
  std::memcpy(&scene_, reader_.bytes() + sizeof(proto::SegmentHeader), sizeof scene_);
  if (!is_sound(scene_)) refuse("its fixed part has a count or number out of range");
  // Nearly a unit will not do: it turns the force after the last stage that limits it.
  Eigen::Map<Eigen::Vector4d> turn(scene_.device.orientation_xyzw.data());
  turn.normalize();

  const std::size_t static_count = scene_.static_grid.sphere_count;
  if (static_count > reader_.fixed_bytes() / sizeof(proto::SphereRecord) ||
      scene_.moving_capacity > header().payload_bytes / sizeof(proto::SphereRecord) ||
      scene_.static_offset != kStaticOffset)
    refuse("it counts more spheres than it has room for");
  static_grid_.layout = collision::grid_layout(0, static_count);
  static_grid_.shape = scene_.static_grid;
  static_grid_.words = reinterpret_cast<const std::uint64_t*>(reader_.bytes() + kStaticOffset);
  moving_layout_ = collision::grid_layout(sizeof(proto::SnapshotHeader), scene_.moving_capacity);
  if (static_end_bytes(static_grid_.layout) > reader_.fixed_bytes() ||
      !collision::is_consistent(static_grid_.shape, static_grid_.layout))
    refuse("its arrays do not fit");
  const proto::TouchShape& lists = scene_.touch_lists;
  if (!collision::is_consistent(lists) || lists.offset != touch_offset(static_grid_.layout) ||
      lists.offset + collision::touch_words(lists) * 8 > reader_.fixed_bytes())
    refuse("its touch lists do not fit");
  touch_lists_ =
      collision::TouchView(lists, scene_.static_grid.sphere_count,
                           reinterpret_cast<const std::uint64_t*>(reader_.bytes() + lists.offset));
  fields_ = read_fields(scene_, reader_.bytes(), lists.offset + collision::touch_words(lists) * 8,
                        reader_.fixed_bytes());
  for (const SceneField& field : fields_) moving_fields_ += field.body.moving != 0 ? 1 : 0;
  if (scene_.model_offset > reader_.fixed_bytes() ||
      scene_.model_bytes > reader_.fixed_bytes() - scene_.model_offset)
    refuse("its model does not fit");
  if (scene_.state_capacity > header().payload_bytes || scene_.state_capacity % 8 != 0 ||
      slot_bytes(moving_layout_, moving_fields_, scene_.state_capacity) > header().payload_bytes)
    refuse("its slots are too small");
}

void SceneView::copy_state(const std::uint64_t* payload, const proto::SnapshotHeader& snapshot,
                           std::vector<std::byte>& bytes) const {
  const bool fits = snapshot.state_bytes <= scene_.state_capacity;
  bytes.resize(fits ? snapshot.state_bytes : 0);
  const std::uint64_t* const from = payload + state_word(moving_layout_, moving_fields_);
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    const std::uint64_t word = double_buffer::load_word(from, at / 8);
    std::memcpy(bytes.data() + at, &word, std::min<std::size_t>(8, bytes.size() - at));
  }
}

collision::GridView SceneView::moving_grid(const std::uint64_t* payload,
                                           const proto::SnapshotHeader& snapshot) const noexcept {
  collision::GridView view{snapshot.grid, moving_layout_, payload};
  if (!collision::is_consistent(view.shape, view.layout)) view.shape = {};
  view.fields = payload + field_word(moving_layout_);
  view.field_count = moving_fields_;
  return view;
}

}  // namespace stillgrid::publication
