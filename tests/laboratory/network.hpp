#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "shared/publication/scene_segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "shared/tools/scene_relay/deadband.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/dynamics/step/tool_sample.hpp"
#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/network_links.hpp"
#include "tests/laboratory/remote_scene.hpp"

namespace stillgrid::laboratory {

/// A network between simulation and hand, as a scene_relay on either side bridges it.
struct NetworkOptions {
  PacketPath path;                 // either way
  std::size_t snapshot_bytes = 0;  // of a snapshot on its way; one packet at least
  std::size_t kept_snapshots = 1;  // by the sender, to be asked for again
  double told_period_s = 0.0;      // of snapshots, as the hand is told; 0: the scene's
  double deadband = 0.0;           // share of the tool's velocity; 0: every sample is sent

  /// Whether anything is otherwise than in shared memory.
  [[nodiscard]] bool is_felt() const noexcept {
    return path.delay_s > 0.0 || path.loss > 0.0 || deadband > 0.0;
  }
};

/// What a network carried.
struct NetworkFigures {
  std::uint64_t samples = 0, samples_sent = 0;       // of the tool
  std::uint64_t snapshots = 0, snapshots_shown = 0;  // of the scene; beside the shown are
  std::uint64_t replaced = 0, late = 0;              // those lost to these
};

/// The network with its two relays, in virtual time. Clocks are one; the relays take no time.
/// Thread: one.
class Network {
 public:
  /// Throws SegmentError.
  Network(const scene::SceneDescription& scene, const dynamics::Simulation& simulation,
          const NetworkOptions& options, std::uint64_t seed);

  /// What the hand sees of the scene.
  [[nodiscard]] const publication::SceneView& view() const noexcept { return view_; }

  /// From the hand, once a tick.
  void send(const proto::ToolState& tool);
  /// The tool that the simulation sees then. Pre: not before the last call's.
  [[nodiscard]] std::optional<dynamics::ToolSample> tool_at(std::uint64_t now_ns);

  /// From the simulation, as it publishes.
  void send(const dynamics::Simulation& simulation, const publication::SnapshotTimes& times);
  /// Shows the hand what came up to now_ns.
  void deliver(std::uint64_t now_ns);

  [[nodiscard]] NetworkFigures figures() const noexcept;

 private:
  RemoteScene remote_;
  publication::SceneView view_;
  std::optional<scene_relay::Deadband> deadband_;
  ToolLink tool_link_;
  SnapshotLink snapshot_link_;
  NetworkFigures figures_;
};

}  // namespace stillgrid::laboratory
