#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "proto/tool_segment.hpp"
#include "shared/display/transition.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/snapshot_reader.hpp"
#include "shared/publication/tool_segment.hpp"
#include "shared/rendering/tool_force.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

class LocalCopy;

/// Figures of one tick.
struct RenderedTick {
  ToolForce force;
  std::uint64_t snapshot_id = 0;   // of the snapshot shown, 0: none yet
  bool is_new = false;             // the first tick that shows it
  bool can_move = false;           // anything in it
  bool is_local = false;           // the scene went on to this tick here
  bool is_swap = false;            // from another state than in the tick before
  int local_ticks = 0;             // of the simulation, that were stepped here
  std::uint64_t tool_time_ns = 0;  // of the tool that it was computed with, 0: none; not checked
  double tool_work_J = 0.0;        // that the tool gave the scene up to then; not checked
  double age_s = 0.0;              // of the simulated state shown newest
  double snapshot_age_s = 0.0;     // since its publication
  bool contended = false;          // no fresh read: the last good sample was used
  bool truncated = false;          // the tick's bound on work was met
  // At a switch from one snapshot to the next, or of the local copy: how the force differs from
  // that of the spheres as the tick before displayed them, on the tool where it is now.
  std::optional<double> switch_jump_N;
  // Its spheres were displayed by these weights. A local copy displays the snapshot as it is.
  display::SnapshotWeights weights;
};

/// Returns the snapshot that a tick displayed, as the tool segment tells it. scene_epoch: of the
/// scene's segment.
[[nodiscard]] proto::DisplayedSnapshot displayed_snapshot(const RenderedTick& tick,
                                                          std::uint64_t scene_epoch) noexcept;

/// One tick to render: the scene, the tool in it, and the instant on the clock of its stamps.
struct TickScene {
  const publication::SceneView& view;
  const ToolPose& pose;
  std::uint64_t now_ns;
  // Tools in the order of the hands; null: away, and the own hand's.
  std::span<const publication::ToolView* const> other_tools = {};
  LocalCopy* local = nullptr;                           // of this scene; null: there is none
  std::span<const dynamics::Vector4> stretches_m = {};  // see ToolProxies::press()

  [[nodiscard]] const proto::SceneHeader& fixed() const noexcept { return view.scene(); }

  /// Adds what the tool touches of the spheres and fields of a slot. Realtime: as gather_touched().
  void gather_moving(const collision::GridView& moving, const display::SnapshotWeights& shown,
                     std::span<const PlacedToolSphere> tool,
                     TouchedSpheres& touched) const noexcept;
  /// Adds the static spheres and fields that the tool touches. Realtime: as gather_touched().
  void gather_static(std::span<const PlacedToolSphere> tool,
                     TouchedSpheres& touched) const noexcept;
};

/// Computes the force of a scene on the tool, tick by tick, from its snapshots alone: the one path
/// from a snapshot to a force. What stands for the scene between two snapshots is a subclass's.
///
/// Thread: the haptic loop's only. Neither copied nor moved.
class Renderer {
 public:
  Renderer() = default;
  virtual ~Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  Renderer(Renderer&&) = delete;
  Renderer& operator=(Renderer&&) = delete;

  /// The force on the tool at now_ns, on the clock of the scene's stamps. Where the latest snapshot
  /// cannot be read what the last good one left stands; before the first there is no force.
  /// Each hand of the session has one of other_tools; null: away, and the own hand. local: the
  /// scene's copy; null: there is none. A simulation in this process gives its stretches_m.
  /// Realtime: wait-free, allocates nothing.
  [[nodiscard]] RenderedTick render(const publication::SceneView& scene, const ToolPose& pose,
                                    std::uint64_t now_ns,
                                    std::span<const publication::ToolView* const> other_tools = {},
                                    LocalCopy* local = nullptr,
                                    std::span<const dynamics::Vector4> stretches_m = {}) noexcept;

 protected:
  [[nodiscard]] const publication::SnapshotReader& reader() const noexcept { return reader_; }

 private:
  /// Places the tool, before the scene is looked at. is_other: than the tick before; nothing that
  /// was gathered counts.
  virtual void prepare(const TickScene& scene, bool is_other) noexcept = 0;
  /// Copies what the tick needs of the latest snapshot, as of SnapshotReader::look().
  virtual void gather(const TickScene& scene, const proto::SnapshotHeader& latest,
                      const collision::GridView& moving) noexcept = 0;
  /// Takes over what was gathered, if it counts, and sums the force. tick: what the look came to is
  /// filled in.
  virtual void show(const TickScene& scene, const publication::SnapshotLook& look,
                    RenderedTick& tick) noexcept = 0;

  publication::SnapshotReader reader_;
};

[[nodiscard]] std::unique_ptr<Renderer> make_renderer(display::Transition transition);

/// Returns the default transition of a scene: `local`, which shows a scene without a model by
/// `linear`; `hold` where such a scene's snapshots last for one tick or less.
[[nodiscard]] inline display::Transition default_transition(const publication::SceneView& scene,
                                                            std::uint64_t tick_ns) noexcept {
  return scene.model().empty() && scene.header().period_ns <= tick_ns ? display::Transition::kHold
                                                                      : display::Transition::kLocal;
}

}  // namespace stillgrid::rendering
