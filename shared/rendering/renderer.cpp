#include "shared/rendering/renderer.hpp"

#include "shared/display/stamps.hpp"
#include "shared/rendering/local_renderer.hpp"
#include "shared/rendering/snapshot_renderer.hpp"
#include "shared/rendering/touched_fields.hpp"
#include "shared/rendering/touched_statics.hpp"

namespace stillgrid::rendering {

proto::DisplayedSnapshot displayed_snapshot(const RenderedTick& tick,
                                            std::uint64_t scene_epoch) noexcept {
  return {.scene_epoch = scene_epoch,
          .snapshot_id = tick.snapshot_id,
          .alpha = tick.weights.alpha,
          .age_s = tick.age_s,
          .local_ticks = static_cast<std::uint32_t>(tick.local_ticks),
          .is_local = tick.is_local ? 1U : 0U};
}

void TickScene::gather_moving(const collision::GridView& moving,
                              const display::SnapshotWeights& shown,
                              std::span<const PlacedToolSphere> tool,
                              TouchedSpheres& touched) const noexcept {
  gather_touched(moving, shown, tool, touched);
  gather_moving_fields(view.fields(), moving, shown, tool, touched);
}

void TickScene::gather_static(std::span<const PlacedToolSphere> tool,
                              TouchedSpheres& touched) const noexcept {
  gather_statics(view.touch_lists(), view.static_grid(), tool, touched);
  gather_static_fields(view.fields(), tool, touched);
}

RenderedTick Renderer::render(const publication::SceneView& scene, const ToolPose& pose,
                              std::uint64_t now_ns,
                              std::span<const publication::ToolView* const> other_tools,
                              LocalCopy* local,
                              std::span<const dynamics::Vector4> stretches_m) noexcept {
  const TickScene tick_scene{scene, pose, now_ns, other_tools, local, stretches_m};
  prepare(tick_scene, reader_.turn_to(scene));
  const publication::SnapshotLook look = reader_.look(
      scene, [&](const proto::SnapshotHeader& latest, const collision::GridView& moving) {
        gather(tick_scene, latest, moving);
      });
  RenderedTick tick;
  tick.contended = look.status == double_buffer::ReadStatus::kContended;
  // No force, not even of planes: they are shown from the first snapshot on.
  if (!reader_.has_snapshot()) return tick;
  const proto::SnapshotHeader& snapshot = reader_.snapshot();
  tick.snapshot_id = snapshot.snapshot_id;
  tick.is_new = look.is_new;
  tick.can_move = snapshot.grid.sphere_count > 0 || scene.moving_fields() > 0;
  tick.tool_time_ns = snapshot.tool_time_ns;
  tick.tool_work_J = snapshot.tool_work_J;
  tick.contended = !look.accepted();
  tick.age_s = display::seconds_between(snapshot.state_time_ns[0], now_ns);
  tick.snapshot_age_s = display::seconds_between(snapshot.publish_time_ns[0], now_ns);
  show(tick_scene, look, tick);
  return tick;
}

std::unique_ptr<Renderer> make_renderer(display::Transition transition) {
  if (transition == display::Transition::kLocal) return std::make_unique<LocalRenderer>();
  return std::make_unique<SnapshotRenderer>(transition);
}

}  // namespace stillgrid::rendering
