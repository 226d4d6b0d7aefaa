#include "shared/rendering/local_renderer.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "shared/display/stamps.hpp"

namespace stillgrid::rendering {
namespace {

std::uint64_t path_number(std::uint64_t now_ns) {
  return now_ns / proto::kPathTick_ns;
}

/// Numbers of the fields that move. The fields of a segment and of its model are both in the order
/// of the simulation's World::fields (sim_server/published_scene.cpp, described_world.cpp), so one
/// number is of the same field in both.
std::vector<std::size_t> moving_among(std::span<const publication::SceneField> fields) {
  std::vector<std::size_t> moving;
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (fields[i].body.moving != 0) moving.push_back(i);
  return moving;
}

/// A field's frame, which has a pose in its rigid body.
proto::FieldState state_of(const dynamics::Description::Field& field,
                           const dynamics::SceneState& state) noexcept {
  const auto rigid = static_cast<std::size_t>(field.rigid);
  const Eigen::Quaterniond turn = state.orientation[rigid].quaternion();
  const Eigen::Vector3d arm_m = turn * field.position_m;
  const Eigen::Vector3d spin_rad_s = state.angular_velocity_rad_s[rigid].vector();
  return publication::field_state(
      state.rigid_position_m[rigid].vector() + arm_m, turn * field.orientation,
      state.rigid_velocity_m_s[rigid].vector() + spin_rad_s.cross(arm_m), spin_rad_s);
}

/// Ticks by which another hand's tool is led on. In virtual time its samples are complete: it is
/// led on between two of them alone.
std::uint64_t led_on_ticks(const proto::SegmentHeader& tool) {
  constexpr std::uint64_t kLongest = 100;  // then the simulation waits for it no longer
  if (tool.clock == proto::Clock::kMonotonic) return kLongest;
  const std::uint64_t period_ns = std::max<std::uint64_t>(tool.period_ns, 1);
  return std::min(kLongest, (period_ns - 1) / proto::kPathTick_ns);
}

void follow_others(const TickScene& scene, local::LocalScene& local) {
  for (std::size_t hand = 0; hand < local.hands(); ++hand) {
    if (hand == local.own_hand()) continue;
    const bool is_here = hand < scene.other_tools.size() && scene.other_tools[hand] != nullptr;
    if (!is_here) {
      local.leave(hand);
      continue;
    }
    const publication::ToolView& tool = *scene.other_tools[hand];
    local.follow(hand, tool.path(), led_on_ticks(tool.header()));
  }
}

}  // namespace

/// Moving spheres come first in a model. Fields: see moving_among().
LocalRenderer::Local::Local(const publication::SceneView& view)
    : scene(view.model(), publication::copy_fields(view.fields(), view.reader().fixed_bytes()),
            std::max(view.scene().hand_count, 1U), view.scene().hand),
      records(view.scene().moving_capacity),
      fields(moving_among(view.fields())),
      field_words(fields.records().size_bytes() / 8) {
  const auto& spheres = scene.description().spheres;
  const std::size_t count = view.scene().moving_capacity;
  if (count > spheres.size()) throw std::invalid_argument("the model has too few spheres");
  std::vector<double> radii_m;
  std::vector<std::uint32_t> materials, bodies;
  for (std::size_t i = 0; i < count; ++i) {
    radii_m.push_back(spheres[i].radius_m);
    materials.push_back(spheres[i].is_field_point
                            ? proto::kFieldPoint
                            : static_cast<std::uint32_t>(spheres[i].material));
    bodies.push_back(static_cast<std::uint32_t>(spheres[i].body));
  }
  records.declare({.struct_size = sizeof(stillgrid_shapes),
                   .count = static_cast<std::uint32_t>(count),
                   .radii_m = radii_m.data(),
                   .materials = materials.data(),
                   .bodies = bodies.data(),
                   .positions_m = nullptr});
  positions_m.resize(3 * count);
  velocities_m_s.resize(3 * count);
}

void LocalRenderer::Local::show_spheres() {
  const dynamics::SceneState& state = scene.state();
  for (std::size_t i = 0; i < positions_m.size() / 3; ++i) {
    const dynamics::Description::Sphere& sphere = scene.description().spheres[i];
    Eigen::Vector3d::Map(&positions_m[3 * i]) = dynamics::sphere_position_m(sphere, state).vector();
    Eigen::Vector3d::Map(&velocities_m_s[3 * i]) = dynamics::sphere_velocity_m_s(sphere, state);
  }
  records.place(positions_m.data(), velocities_m_s.data(), dynamics::kTick_s);
}

void LocalRenderer::Local::show_fields() noexcept {
  fields.show([&](std::size_t field) {
    return state_of(scene.description().fields[field], scene.state());
  });
  if (!field_words.empty())
    std::memcpy(field_words.data(), fields.records().data(), fields.records().size_bytes());
}

void LocalRenderer::Local::show() {
  show_spheres();
  show_fields();
}

collision::GridView LocalRenderer::Local::view() const noexcept {
  collision::GridView view = records.grid().view();
  view.fields = field_words.data();
  view.field_count = static_cast<std::uint32_t>(fields.records().size());
  return view;
}

void LocalRenderer::prepare(const TickScene& scene, bool is_other) noexcept {
  if (is_other) {
    local_.reset();
    touched_->clear();
    sweep_.forget();
    try {
      if (!scene.view.model().empty()) local_.emplace(scene.view);
    } catch (const std::exception&) {  // it is not one of ours: the snapshots are shown
      local_.reset();
    }
  }
  tool_ = sweep_.place(scene.fixed(), scene.pose);
  is_local_ = false;
  if (!local_) return;
  local_->scene.add_to_path(
      {{scene.pose.position_m, scene.pose.orientation, scene.pose.velocity_m_s},
       path_number(scene.now_ns)});
  follow_others(scene, local_->scene);
  is_local_ = local_->scene.advance_to(path_number(scene.now_ns));
}

void LocalRenderer::gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                           const collision::GridView& moving) noexcept {
  fresh_->clear();
  state_.clear();
  const bool is_new = latest.snapshot_id != reader().snapshot().snapshot_id;
  if (local_ && is_new && latest.state_bytes > 0 &&
      !local_->scene.confirms(latest.state_tick, latest.state_hash))
    scene.view.copy_state(moving.words, latest, state_);
  if (!is_local_) scene.gather_moving(moving, held_snapshot(0), tool_, *fresh_);
}

void LocalRenderer::show(const TickScene& scene, const publication::SnapshotLook& look,
                         RenderedTick& tick) noexcept {
  if (look.accepted() && !state_.empty() &&
      local_->scene.begin_at(reader().snapshot().state_tick, state_))
    is_local_ = local_->scene.advance_to(path_number(scene.now_ns));
  if (is_local_) {
    local_->show();
    fresh_->clear();
    scene.gather_moving(local_->view(), {held_snapshot(0).now, held_snapshot(1).now}, tool_,
                        *fresh_);
    // The grid's order depends on what was displayed before; that of fields does not.
    std::sort(fresh_->spheres.begin(), fresh_->spheres.begin() + std::ssize(fresh_->all()),
              [](const TouchedSphere& a, const TouchedSphere& b) {
                return std::tie(a.tool_sphere, a.field, a.number) <
                       std::tie(b.tool_sphere, b.field, b.number);
              });
    tick.age_s =
        display::seconds_between(path_number(scene.now_ns) * proto::kPathTick_ns, scene.now_ns);
  }
  if (is_local_ || look.accepted()) {
    scene.gather_static(tool_, *fresh_);
    std::swap(touched_, fresh_);
  } else {
    touched_->drop_swept();
  }
  tick.is_local = is_local_;
  tick.truncated = touched_->truncated;
  tick.swept = touched_->has_swept();
  tick.force = scene.force_of(*touched_, tool_);
  if (is_local_ || look.accepted()) sweep_.end();
}

}  // namespace stillgrid::rendering
