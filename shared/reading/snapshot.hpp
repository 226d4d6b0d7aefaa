#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "proto/scene_segment.hpp"
#include "proto/tool_segment.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/snapshot_reader.hpp"
#include "shared/publication/tool_segment.hpp"

namespace stillgrid::reading {

/// How the spheres of a grid are spread over the cells of all its levels.
struct GridOccupancy {
  std::uint64_t cells = 0;
  std::uint64_t occupied_cells = 0;
  std::uint32_t fullest_cell = 0;  // spheres in it
};

/// A sphere's swept bound, and the level of the grid that it is entered in.
struct LevelBound {
  proto::SweptBound swept_bound;
  std::uint32_t level = 0;
};

/// A copy of one snapshot of a scene, whole as it was published; its numbers are the writer's, and
/// may be none.
struct SceneSnapshot {
  std::uint64_t snapshot_id = 0;
  proto::SnapshotHeader header{};  // its grid has no sphere if it was not consistent
  std::vector<proto::SphereRecord> spheres;
  std::vector<proto::FieldRecord> fields;  // of the bodies with fields that move, in their order
  std::vector<LevelBound> swept_bounds;    // of all spheres, in the order of the levels
  GridOccupancy occupancy;
  std::vector<std::byte> state;  // another process continues from it; empty: it was not copied
};

/// What a look copies beside the spheres and the fields' places.
enum class SnapshotDetail { kSpheres, kGrid, kState };

/// One look at the latest snapshot, with its first `max_spheres` spheres. Unless accepted,
/// `snapshot` holds anything. Realtime: yes of kSpheres, where its vectors have the room.
/// Pre: reader.turn_to(view).
[[nodiscard]] double_buffer::ReadStatus look(publication::SnapshotReader& reader,
                                             const publication::SceneView& view,
                                             std::size_t max_spheres, SnapshotDetail detail,
                                             SceneSnapshot& snapshot);

/// The latest snapshot with its first `max_spheres` spheres and its grid; nothing before the
/// first, or when it was overtaken again and again.
[[nodiscard]] std::optional<SceneSnapshot> read_snapshot(const publication::SceneView& view,
                                                         std::size_t max_spheres);

/// The same, for who follows the scene. Pre: reader.turn_to(view).
[[nodiscard]] std::optional<SceneSnapshot> read_snapshot(publication::SnapshotReader& reader,
                                                         const publication::SceneView& view,
                                                         std::size_t max_spheres);

/// The spheres that never move, the first `max_spheres` of them.
[[nodiscard]] std::vector<proto::SphereRecord> static_spheres(const publication::SceneView& view,
                                                              std::size_t max_spheres);

/// The swept bounds of all spheres that never move, in the order of the levels of the static grid.
[[nodiscard]] std::vector<LevelBound> static_bounds(const publication::SceneView& view);

/// The latest state of a tool as its writer wrote it, sound or not, and which it is.
struct ToolSnapshot {
  std::uint64_t snapshot_id = 0;
  proto::ToolState state{};
};
[[nodiscard]] std::optional<ToolSnapshot> read_tool(const publication::ToolView& view);

}  // namespace stillgrid::reading
