#include "shared/rendering/touched_statics.hpp"

#include <cmath>

#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/tool_sweep.hpp"

namespace stillgrid::rendering {
namespace {

Eigen::Vector3d centre_m(const collision::TouchEntry& entry) {
  return Eigen::Map<const Eigen::Vector3f>(entry.centre_m.data()).cast<double>();
}

/// Where a static sphere and the probe met: the sphere's centre, or where it was closest.
struct Meeting {
  Eigen::Vector3d position_m;
  bool swept;
};

std::optional<Meeting> meeting_of(const collision::TouchEntry& entry,
                                  const PlacedToolSphere& probe) {
  const Eigen::Vector3d position_m = centre_m(entry);
  const Eigen::Vector3d now_m = probe.position_m - position_m;
  const double contact_distance_m = probe.radius_m + double{entry.radius_m};
  // Written so that a NaN does not pass.
  if (now_m.squaredNorm() < contact_distance_m * contact_distance_m)
    return Meeting{position_m, false};
  const auto closest_m =
      closest_line_m(probe.before_m - position_m, now_m, contact_distance_m, probe.radius_m);
  if (!closest_m) return std::nullopt;
  return Meeting{probe.position_m - *closest_m, true};
}

void add(TouchedSpheres& touched, const collision::TouchEntry& entry, const Meeting& meeting,
         std::uint32_t tool_sphere) {
  if (!std::isfinite(entry.radius_m)) return;
  touched.add({.position_m = meeting.position_m,
               .velocity_m_s = Eigen::Vector3d::Zero(),
               .radius_m = double{entry.radius_m},
               .material = entry.label.material,
               .tool_sphere = tool_sphere,
               .swept = meeting.swept,
               .number = entry.label.number,
               .body = entry.label.body,
               .is_static = true});
}

void gather_by_grid(const collision::GridView& grid, std::span<const PlacedToolSphere> tool,
                    std::uint32_t tool_sphere, TouchedSpheres& touched) {
  const std::size_t first = touched.count;
  gather_touched(grid, {}, tool.subspan(tool_sphere, 1), touched);
  for (std::size_t i = first; i < touched.count; ++i) {
    touched.spheres[i].tool_sphere = tool_sphere;
    touched.spheres[i].is_static = true;
  }
}

}  // namespace

void gather_statics(const collision::TouchView& lists, const collision::GridView& grid,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept {
  for (std::uint32_t i = 0; i < tool.size(); ++i) {
    const PlacedToolSphere& probe = tool[i];
    const collision::SweptBound way = bound_tool_sweep(probe);
    if (!(way.bounding_radius_m <= lists.probe_radius_m())) {
      gather_by_grid(grid, tool, i, touched);
      continue;
    }
    const std::size_t first = touched.count;
    const bool was_truncated = touched.truncated;
    const std::uint32_t visits_left = touched.visits_left;
    const bool is_cut =
        lists.for_each_touch(way, kMaxVisits, [&](const collision::TouchEntry& entry) {
          if (!touched.may_visit()) return;
          if (const auto meeting = meeting_of(entry, probe)) add(touched, entry, *meeting, i);
        });
    if (!is_cut) continue;
    // A list holds what any place of its voxel may meet; among dense spheres the grid looks at
    // less.
    touched.count = first;
    touched.truncated = was_truncated;
    touched.visits_left = visits_left;
    gather_by_grid(grid, tool, i, touched);
  }
}

}  // namespace stillgrid::rendering
