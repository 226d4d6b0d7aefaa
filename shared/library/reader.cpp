#include "shared/library/reader.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "shared/collision/grid_query.hpp"
#include "shared/library/last_error.hpp"
#include "shared/library/tool_figures.hpp"
#include "shared/publication/hands.hpp"
#include "shared/reading/displayed.hpp"

namespace stillgrid::library {
namespace {

constexpr int kAttempts = 3;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

std::uint64_t publications(const publication::SegmentReader& reader) {
  return double_buffer::HardwareAtomics::load(*reader.buffer().latest, std::memory_order_acquire);
}

/// Fails where something of a living writer's stands there that cannot be read: what a killed one
/// left is for the next one to replace.
int check_readable(const reading::SegmentFollower& follower) {
  const reading::SegmentSummary& refused = follower.refused();
  if (refused.refusal.empty() || refused.is_leftover) return STILLGRID_OK;
  return fail(refused.is_other_build ? STILLGRID_E_VERSION : STILLGRID_E_SESSION, "%s: %s",
              publication::segment_name(refused.file.session, refused.file.kind).c_str(),
              refused.refusal.c_str());
}

/// Fails where the session is published, but not for this hand.
int check_hand(const std::string& hand_session) {
  try {
    publication::require_hand(hand_session);
  } catch (const publication::SegmentError& error) {
    return fail(STILLGRID_E_ARGUMENT, "%s", error.what());
  }
  return STILLGRID_OK;
}

void copy(const std::array<float, 3>& from, float* to, std::size_t i) {
  if (to != nullptr) std::copy(from.begin(), from.end(), to + 3 * i);
}
template <class Number>
void copy(Number from, Number* to, std::size_t i) {
  if (to != nullptr) to[i] = from;
}

/// One sphere as it is told.
struct ToldSphere {
  proto::SphereRecord record;
  std::array<float, 3> position_m, velocity_m_s;
};

ToldSphere as_published(const proto::SphereRecord& record) {
  return {record, record.newest.position_m, record.newest.velocity_m_s};
}

/// Tells `count` spheres, of which sphere(i) is one, as far as there is room: all or, where one
/// names a material that there is not, none.
template <class Sphere>
int tell(std::uint32_t count, std::uint32_t material_count, stillgrid_snapshot& told,
         Sphere&& sphere) {
  const std::uint32_t fitting = std::min(count, told.capacity);
  for (std::uint32_t i = 0; i < fitting; ++i)
    if (const std::uint32_t material = sphere(i).record.material;
        material >= material_count && material != proto::kFieldPoint)
      return fail(STILLGRID_E_SESSION,
                  "sphere %u of a snapshot: material %u: expected less than %u", i, material,
                  material_count);
  for (std::uint32_t i = 0; i < fitting; ++i) {
    const ToldSphere one = sphere(i);
    copy(one.position_m, told.positions_m, i);
    copy(one.velocity_m_s, told.velocities_m_s, i);
    copy(one.record.radius_m, told.radii_m, i);
    // A static sphere is read in place, and may be another's word by now.
    copy(one.record.material == proto::kFieldPoint
             ? STILLGRID_FIELD_POINT
             : std::min(one.record.material, material_count - 1),
         told.materials, i);
    copy(one.record.body, told.bodies, i);
  }
  told.count = count;
  return STILLGRID_OK;
}

void tell_times(const proto::SnapshotHeader& header, stillgrid_snapshot& told) {
  told.contacts = static_cast<std::uint32_t>(std::min<std::uint64_t>(header.contacts, UINT32_MAX));
  told.snapshot_id = header.snapshot_id;
  told.state_time_ns = header.state_time_ns[0];
  told.publish_time_ns = header.publish_time_ns[0];
  told.tool_time_ns = header.tool_time_ns;
  told.step_ns = header.step_ns;
}

/// Also of a relay that hears nothing: what it published last goes on to be the newest.
bool is_alive(const reading::SegmentFollower& writer) {
  return writer.life() == reading::Life::kAlive || writer.life() == reading::Life::kSilent;
}

}  // namespace

Reader::Reader(std::string hand_session)
    : hand_session_(std::move(hand_session)),
      scene_follower_(hand_session_, proto::SegmentKind::kScene),
      tool_follower_(hand_session_, proto::SegmentKind::kTool) {}

int Reader::require(const void* view) const noexcept {
  if (!was_polled_) return fail(STILLGRID_E_ORDER, "reader: expected poll() first");
  return view == nullptr ? STILLGRID_NOTHING : STILLGRID_OK;
}

void Reader::take_up() {
  scene_ = nullptr;
  tool_ = nullptr;
  scene_follower_.look();
  tool_follower_.look();
  was_polled_ = true;
  if (is_alive(tool_follower_)) tool_ = tool_follower_.tool();
  if (!is_alive(scene_follower_)) return;
  const publication::SceneView& scene = *scene_follower_.scene();
  if (snapshots_.turn_to(scene)) newest_ = {};
  const std::size_t capacity = scene.scene().moving_capacity;
  newest_.spheres.reserve(capacity);
  newest_.fields.reserve(scene.moving_fields());
  scene_ = &scene;
}

stillgrid_session_state Reader::state() const noexcept {
  stillgrid_session_state state{};
  const publication::SceneView* scene = scene_follower_.scene();
  const publication::ToolView* tool = tool_follower_.tool();
  state.is_published = scene_ != nullptr ? 1 : 0;
  state.is_felt = tool_ != nullptr ? 1 : 0;
  if (tool != nullptr) {
    state.clock = tool->header().clock == proto::Clock::kVirtual ? 1 : 0;
    state.tool_epoch = tool->header().epoch;
    state.tick_period_ns = tool->header().period_ns;
    state.ticks = publications(tool->reader());
  }
  if (scene == nullptr) return state;
  const proto::SceneHeader& fixed = scene->scene();
  state.clock = scene->header().clock == proto::Clock::kVirtual ? 1 : 0;
  state.scene_epoch = scene->header().epoch;
  state.publication_period_ns = scene->header().period_ns;
  state.snapshots = publications(scene->reader());
  state.sphere_capacity = static_cast<std::uint32_t>(fixed.moving_capacity);
  state.static_count = scene->static_grid().shape.sphere_count;
  state.material_count = fixed.material_count;
  state.plane_count = fixed.plane_count;
  state.tool_count = fixed.tool_sphere_count;
  static_assert(sizeof state.scene_name == sizeof fixed.name);
  std::memcpy(state.scene_name, fixed.name.data(), sizeof state.scene_name);
  return state;
}

int Reader::poll(stillgrid_session_state& told) {
  take_up();
  for (const reading::SegmentFollower* follower : {&scene_follower_, &tool_follower_})
    if (const int code = check_readable(*follower)) return code;
  if (scene_follower_.life() == reading::Life::kAbsent)
    if (const int code = check_hand(hand_session_)) return code;
  told = state();
  return STILLGRID_OK;
}

int Reader::fixed(stillgrid_fixed& told) const {
  if (const int code = require(scene_)) return code;
  const proto::SceneHeader& scene = scene_->scene();
  const auto lacks = [](const void* array, std::uint32_t room, std::uint32_t count) {
    return array != nullptr && room < count;
  };
  if (lacks(told.materials, told.material_capacity, scene.material_count) ||
      lacks(told.planes, told.plane_capacity, scene.plane_count) ||
      lacks(told.tool_m, told.tool_capacity, scene.tool_sphere_count))
    return fail(STILLGRID_E_CAPACITY,
                "fixed: room for %u materials, %u planes, %u spheres of the tool: expected for %u, "
                "%u, %u",
                told.material_capacity, told.plane_capacity, told.tool_capacity,
                scene.material_count, scene.plane_count, scene.tool_sphere_count);
  for (std::uint32_t i = 0; told.materials != nullptr && i < scene.material_count; ++i) {
    const proto::Material& m = scene.materials[i];
    told.materials[i] = {m.stiffness_N_per_m, m.damping_N_s_per_m, m.friction};
  }
  for (std::uint32_t i = 0; told.planes != nullptr && i < scene.plane_count; ++i) {
    const proto::Plane& p = scene.planes[i];
    told.planes[i] = {{p.normal[0], p.normal[1], p.normal[2]}, p.offset_m, p.material, p.body};
  }
  for (std::uint32_t i = 0; told.tool_m != nullptr && i < scene.tool_sphere_count; ++i) {
    const proto::ToolSphere& sphere = scene.tool[i];
    std::copy(sphere.position_m.begin(), sphere.position_m.end(), told.tool_m + 4 * i);
    told.tool_m[4 * i + 3] = sphere.radius_m;
  }
  const proto::DeviceFrame& device = scene.device;
  std::copy(device.position_m.begin(), device.position_m.end(), told.device_position_m);
  std::copy(device.orientation_xyzw.begin(), device.orientation_xyzw.end(),
            told.device_orientation_xyzw);
  told.device_scale = device.scale;
  return STILLGRID_OK;
}

int Reader::look() {
  if (const int code = require(scene_)) return code;
  for (int attempt = 0; attempt < kAttempts; ++attempt)
    if (reading::look(snapshots_, *scene_, scene_->scene().moving_capacity,
                      reading::SnapshotDetail::kSpheres,
                      newest_) == double_buffer::ReadStatus::kAccepted)
      return STILLGRID_OK;
  return STILLGRID_NOTHING;
}

int Reader::snapshot(stillgrid_snapshot& told) {
  if (const int code = look()) return code;
  const auto count = static_cast<std::uint32_t>(newest_.spheres.size());
  if (const int code = tell(count, scene_->scene().material_count, told,
                            [&](std::uint32_t i) { return as_published(newest_.spheres[i]); }))
    return code;
  tell_times(newest_.header, told);
  return STILLGRID_OK;
}

int Reader::static_spheres(stillgrid_snapshot& told) const {
  if (const int code = require(scene_)) return code;
  const collision::GridView& grid = scene_->static_grid();
  if (const int code =
          tell(grid.shape.sphere_count, scene_->scene().material_count, told,
               [&](std::uint32_t i) { return as_published(collision::load_record(grid, i)); }))
    return code;
  tell_times({}, told);
  return STILLGRID_OK;
}

int Reader::displayed(stillgrid_snapshot& told) {
  if (const int code = require(scene_)) return code;
  if (tool_ == nullptr) return STILLGRID_NOTHING;
  // The tick first: no snapshot that it displayed is newer than the one read after it.
  const std::optional<proto::ToolState> tick = tool_->read();
  if (!tick || !publication::has_sound_figures(*tick)) return STILLGRID_NOTHING;
  if (const int code = look()) return code;
  const auto shown =
      reading::displayed_in(tick->before.displayed, snapshots_.epoch(), newest_.snapshot_id);
  if (!shown) return STILLGRID_NOTHING;
  const auto count = static_cast<std::uint32_t>(newest_.spheres.size());
  const auto as_displayed = [&](std::uint32_t i) {
    const proto::SphereRecord& record = newest_.spheres[i];
    return ToldSphere{record, reading::displayed_m(record, *shown), {kNone, kNone, kNone}};
  };
  if (const int code = tell(count, scene_->scene().material_count, told, as_displayed)) return code;
  tell_times(newest_.header, told);
  return STILLGRID_OK;
}

int Reader::tool(stillgrid_tool& told) const {
  if (const int code = require(tool_)) return code;
  const std::optional<proto::ToolState> tick = tool_->read();
  if (!tick) return STILLGRID_NOTHING;
  told = tool_figures(*tick);
  return STILLGRID_OK;
}

}  // namespace stillgrid::library
