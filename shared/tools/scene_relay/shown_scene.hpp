#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/publication/moving_records.hpp"
#include "shared/publication/session.hpp"
#include "shared/tools/scene_relay/told_snapshot.hpp"

namespace stillgrid::scene_relay {

/// A scene of the other machine as this one's: its segment, with the history and grid of the
/// snapshots that reached it. A snapshot that was lost is in no history, so that the hand passes
/// from what it was shown to what comes. Thread: one.
class ShownScene {
 public:
  /// round_trip_ns: of the network, within which a snapshot that lost a packet comes; the segment
  /// declares the simulation's period and that, the period again at most (docs/network_delay.md).
  /// Throws MessageError, SegmentError. Pre: the lock is that of the session's scene.
  ShownScene(const std::string& session, publication::SessionLock lock, const SceneMessage& message,
             const std::optional<gid_t>& readers, std::uint64_t now_ns,
             std::uint64_t round_trip_ns = 0);

  [[nodiscard]] std::uint64_t epoch() const noexcept { return epoch_; }
  [[nodiscard]] const SnapshotLimits& limits() const noexcept { return limits_; }
  /// Whether it is stepped here too, along the tool's path.
  [[nodiscard]] bool has_model() const noexcept { return limits_.state_capacity > 0; }
  [[nodiscard]] publication::HandSession& hand() noexcept { return hand_; }

  /// Publishes it. times: on this machine's clock. Throws SegmentError where another program has
  /// shrunk the segment. Pre: check(snapshot, limits()).
  void show(const ToldSnapshot& snapshot, const publication::SnapshotTimes& times);

 private:
  ShownScene(const std::string& session, publication::SessionLock lock, const SceneMessage& message,
             const publication::StaticScene& fixed, const std::optional<gid_t>& readers,
             std::uint64_t now_ns, std::uint64_t round_trip_ns);
  void place_spheres(const ToldSnapshot& snapshot);
  void place_fields(const ToldSnapshot& snapshot);

  std::uint64_t epoch_;
  double period_s_;
  SnapshotLimits limits_;
  publication::MovingRecords moving_;
  std::vector<proto::FieldRecord> fields_;
  publication::HandSession hand_;
  std::vector<double> radii_m_, positions_m_, velocities_m_s_;
  std::vector<std::uint32_t> materials_, bodies_;
};

}  // namespace stillgrid::scene_relay
