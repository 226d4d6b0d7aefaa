#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/collision/voxel_grid.hpp"
#include "shared/publication/scene_segment.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/network_links.hpp"

namespace stillgrid::laboratory {

/// What of the simulation's newest snapshot goes over a network.
[[nodiscard]] SentSnapshot sent_snapshot(const dynamics::Simulation& simulation,
                                         const publication::SnapshotTimes& times);

/// A scene published again on the hand's side of a network, in a session of its own: its history is
/// that of the snapshots that came. It has no model: `linear` shows it. Thread: one.
class RemoteScene {
 public:
  /// period_s: of snapshots, by which the hand's safety chain knows that one is overdue. Throws
  /// SegmentError.
  RemoteScene(const scene::SceneDescription& scene, const dynamics::Simulation& simulation,
              double period_s);

  /// Shows a snapshot from arrival_ns on: its state is as old as it is, the switch is here.
  void show(const SentSnapshot& snapshot, std::uint64_t arrival_ns);

  /// Throws SegmentError.
  [[nodiscard]] publication::SceneView view() const;

 private:
  void show_fields(const std::vector<proto::FieldRecord>& sent);

  std::string session_;
  collision::VoxelGrid grid_;
  std::vector<proto::SphereState> states_;
  std::vector<proto::FieldRecord> fields_;
  publication::SceneWriter writer_;
};

}  // namespace stillgrid::laboratory
