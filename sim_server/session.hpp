#pragma once

#include <sys/types.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "shared/publication/scene_segment.hpp"
#include "shared/publication/segment_watch.hpp"
#include "shared/publication/tool_segment.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// One hand's side of the session: its segment of the scene, and its tool's as it comes and goes.
class HandSession {
 public:
  /// session: SESSION+HAND. Throws SegmentError.
  HandSession(std::string session, publication::SessionLock lock,
              const publication::StaticScene& fixed, std::size_t spheres, std::uint64_t period_ns,
              proto::Clock clock, std::uint64_t start_ns, std::optional<gid_t> readers);

  /// The tool's newest sample; none while its haptic_server is away.
  [[nodiscard]] std::optional<dynamics::ToolSample> take_tool();

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] publication::SceneWriter& writer() noexcept { return writer_; }
  [[nodiscard]] publication::SegmentWatch<publication::ToolView>& tool() noexcept { return tool_; }

 private:
  std::string name_;
  publication::SceneWriter writer_;
  publication::SegmentWatch<publication::ToolView> tool_;
  std::optional<dynamics::ToolSample> last_tool_;
};

/// The simulation's side of a session, by hand. Hands share no segment, so that none can touch
/// another (docs/decisions/0020-a-scene-segment-a-hand.md).
class Session {
 public:
  /// lock: of the session itself, kept beside those of its hands. Throws SegmentError.
  Session(const scene::SceneDescription& scene, const std::string& name,
          publication::SessionLock lock, const dynamics::Simulation& simulation, proto::Clock clock,
          std::uint64_t start_ns, std::optional<gid_t> readers);

  [[nodiscard]] std::deque<HandSession>& hands() noexcept { return hands_; }

 private:
  std::optional<publication::SessionLock> lock_;  // unless its only hand has it
  std::deque<HandSession> hands_;
};

}  // namespace stillgrid::sim_server
