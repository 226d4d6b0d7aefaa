#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "proto/stillgrid.h"
#include "shared/publication/snapshot_reader.hpp"
#include "shared/reading/segment_follower.hpp"
#include "shared/reading/snapshot.hpp"

namespace stillgrid::library {

/// One who looks at a session, as proto/stillgrid.h has it: each member function is the call of its
/// name, of structs whose sizes are settled. Only poll() allocates. Thread: one at a time.
class Reader {
 public:
  /// hand_session: SESSION, or SESSION+HAND.
  explicit Reader(std::string hand_session);

  int poll(stillgrid_session_state& state);
  int fixed(stillgrid_fixed& fixed) const;
  int snapshot(stillgrid_snapshot& snapshot);
  int static_spheres(stillgrid_snapshot& snapshot) const;
  int displayed(stillgrid_snapshot& snapshot);
  int tool(stillgrid_tool& tool) const;

 private:
  /// Whether there is what a call reads: fails before the first poll; STILLGRID_NOTHING while its
  /// writer is away.
  [[nodiscard]] int require(const void* view) const noexcept;
  void take_up();
  [[nodiscard]] stillgrid_session_state state() const noexcept;
  /// Brings the newest snapshot into newest_.
  [[nodiscard]] int look();

  std::string hand_session_;
  reading::SegmentFollower scene_follower_, tool_follower_;
  const publication::SceneView* scene_ = nullptr;  // of a writer that lived at the last poll
  const publication::ToolView* tool_ = nullptr;    // likewise
  publication::SnapshotReader snapshots_;
  reading::SceneSnapshot newest_;
  bool was_polled_ = false;
};

}  // namespace stillgrid::library
