#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/scene_segment.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/tools/scene_viewer/view_source.hpp"

namespace stillgrid::scene_viewer {

/// Where what is shown comes from.
enum class ViewKind { kSession, kSaved, kRecording };

/// What sim_server --surfaces wrote.
struct Surfaces {
  std::string text = "null";     // JSON
  std::string scene;             // its name; empty: not told
  std::size_t sphere_count = 0;  // of the scene, moving and static
};

/// Throws std::runtime_error, one line, where that is none or names what is not there.
[[nodiscard]] Surfaces read_surfaces(const std::string& file);

/// The answer of /api/scene, JSON: docs/viewer.md. moving: of any snapshot. Surfaces of another
/// name or number of spheres are another scene's and left out. tick_period_ns: 0 where no haptic
/// loop is known.
[[nodiscard]] std::string scene_message(const publication::SceneView& view,
                                        const std::string& session, const std::string& key,
                                        std::span<const proto::SphereRecord> moving,
                                        const Surfaces& surfaces, std::uint64_t tick_period_ns);

/// Before a scene is known, and of what has none: no body, a small ball for a tool.
[[nodiscard]] std::string empty_scene_message(ViewKind kind, const std::string& name,
                                              const std::string& key);

/// A scene's message as that of a saved view, and its key; nothing if it is none.
struct SavedScene {
  std::string key, message;
};
[[nodiscard]] std::optional<SavedScene> saved_scene(const std::string& message);

/// The answer of /api/sessions, JSON: docs/viewer.md.
[[nodiscard]] std::string sessions_message(const std::string& named,
                                           const std::vector<std::string>& running);

/// The answer of /api/status, JSON: docs/viewer.md.
[[nodiscard]] std::string status_message(const ViewStatus& status);

}  // namespace stillgrid::scene_viewer
