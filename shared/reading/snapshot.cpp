#include "shared/reading/snapshot.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "shared/collision/grid_query.hpp"

namespace stillgrid::reading {
namespace {

/// Looks again and again while it is overtaken, and says whether it was not in the end: a look from
/// outside has no priority and may copy a whole snapshot.
template <class Look>
bool is_accepted_patiently(Look&& look) {
  for (int round = 0; round < 50; ++round) {
    const double_buffer::ReadStatus status = look();
    if (status != double_buffer::ReadStatus::kContended)
      return status == double_buffer::ReadStatus::kAccepted;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

void copy_spheres(const collision::GridView& view, std::size_t max_spheres,
                  std::vector<proto::SphereRecord>& spheres) {
  const auto count =
      static_cast<std::uint32_t>(std::min<std::size_t>(view.shape.sphere_count, max_spheres));
  spheres.resize(count);
  for (std::uint32_t sphere = 0; sphere < count; ++sphere)
    spheres[sphere] = collision::load_record(view, sphere);
}

/// Bounded by the layout whatever the words say, given a consistent shape.
void copy_bounds(const collision::GridView& view, std::vector<LevelBound>& swept_bounds) {
  swept_bounds.resize(view.shape.sphere_count);
  const std::uint64_t* starts = view.words + view.layout.cell_starts;
  std::uint32_t level = 0;
  for (std::uint32_t i = 0; i < view.shape.sphere_count; ++i) {
    while (level + 1 < view.shape.level_count &&
           double_buffer::load_u32(starts, view.shape.levels[level + 1].first_cell) <= i)
      ++level;
    swept_bounds[i] = {collision::load_bound(view, i), level};
  }
}

/// Likewise bounded.
GridOccupancy occupancy_of(const collision::GridView& view) {
  GridOccupancy occupancy;
  if (view.shape.sphere_count == 0) return occupancy;
  const std::uint64_t* starts = view.words + view.layout.cell_starts;
  for (std::uint32_t i = 0; i < view.shape.level_count; ++i) {
    const proto::GridLevel& level = view.shape.levels[i];
    const std::size_t cells = std::size_t{level.cells[0]} * level.cells[1] * level.cells[2];
    occupancy.cells += cells;
    std::uint32_t begin = double_buffer::load_u32(starts, level.first_cell);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const std::uint32_t end = std::min(
          double_buffer::load_u32(starts, level.first_cell + cell + 1), view.shape.sphere_count);
      const std::uint32_t spheres = end > begin ? end - begin : 0;
      occupancy.occupied_cells += spheres > 0 ? 1 : 0;
      occupancy.fullest_cell = std::max(occupancy.fullest_cell, spheres);
      begin = end;
    }
  }
  return occupancy;
}

}  // namespace

double_buffer::ReadStatus look(publication::SnapshotReader& reader,
                               const publication::SceneView& view, std::size_t max_spheres,
                               SnapshotDetail detail, SceneSnapshot& snapshot) {
  const auto gather = [&](const proto::SnapshotHeader& latest, const collision::GridView& moving) {
    snapshot.header = latest;
    snapshot.header.grid = moving.shape;
    copy_spheres(moving, max_spheres, snapshot.spheres);
    snapshot.fields.resize(moving.field_count);
    for (std::uint32_t i = 0; i < moving.field_count; ++i)
      snapshot.fields[i] = collision::load_field(moving, i + 1);
    snapshot.state.clear();
    if (detail == SnapshotDetail::kState) view.copy_state(moving.words, latest, snapshot.state);
    if (detail != SnapshotDetail::kGrid) return;
    copy_bounds(moving, snapshot.swept_bounds);
    snapshot.occupancy = occupancy_of(moving);
  };
  const double_buffer::ReadStatus status = reader.look(view, gather).status;
  snapshot.snapshot_id = snapshot.header.snapshot_id;
  snapshot.header.history_count =
      std::clamp<std::uint64_t>(snapshot.header.history_count, 1, proto::kHistoryLength);
  return status;
}

std::optional<SceneSnapshot> read_snapshot(const publication::SceneView& view,
                                           std::size_t max_spheres) {
  publication::SnapshotReader reader;
  reader.turn_to(view);
  return read_snapshot(reader, view, max_spheres);
}

std::optional<SceneSnapshot> read_snapshot(publication::SnapshotReader& reader,
                                           const publication::SceneView& view,
                                           std::size_t max_spheres) {
  SceneSnapshot snapshot;
  const auto look_once = [&] {
    return look(reader, view, max_spheres, SnapshotDetail::kGrid, snapshot);
  };
  if (!is_accepted_patiently(look_once)) return std::nullopt;
  return snapshot;
}

std::vector<proto::SphereRecord> static_spheres(const publication::SceneView& view,
                                                std::size_t max_spheres) {
  std::vector<proto::SphereRecord> spheres;
  copy_spheres(view.static_grid(), max_spheres, spheres);
  return spheres;
}

std::vector<LevelBound> static_bounds(const publication::SceneView& view) {
  std::vector<LevelBound> swept_bounds;
  copy_bounds(view.static_grid(), swept_bounds);
  return swept_bounds;
}

std::optional<ToolSnapshot> read_tool(const publication::ToolView& view) {
  ToolSnapshot snapshot;
  const auto look = [&] {
    const double_buffer::ReadResult read =
        double_buffer::read_latest(view.reader().buffer(), [&](const std::uint64_t* payload) {
          snapshot.state = double_buffer::load_struct<proto::ToolState>(payload);
        });
    snapshot.snapshot_id = read.snapshot_id;
    return read.status;
  };
  if (!is_accepted_patiently(look)) return std::nullopt;
  return snapshot;
}

}  // namespace stillgrid::reading
