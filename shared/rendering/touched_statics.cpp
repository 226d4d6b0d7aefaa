#include "shared/rendering/touched_statics.hpp"

#include <cmath>

namespace stillgrid::rendering {
namespace {

Eigen::Vector3d centre_m(const collision::TouchEntry& entry) {
  return Eigen::Map<const Eigen::Vector3f>(entry.centre_m.data()).cast<double>();
}

bool meets(const collision::TouchEntry& entry, const PlacedToolSphere& probe) {
  const double contact_distance_m = gathered_within_m(probe, double{entry.radius_m});
  // Written so that a NaN does not pass.
  return (probe.position_m - centre_m(entry)).squaredNorm() <
         contact_distance_m * contact_distance_m;
}

void add(TouchedSpheres& touched, const collision::TouchEntry& entry, std::uint32_t tool_sphere) {
  if (!std::isfinite(entry.radius_m)) return;
  touched.add({.position_m = centre_m(entry),
               .velocity_m_s = Eigen::Vector3d::Zero(),
               .radius_m = double{entry.radius_m},
               .material = entry.label.material,
               .tool_sphere = tool_sphere,
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
    const collision::SweptBound way = gathering_bound(probe);
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
          if (meets(entry, probe)) add(touched, entry, i);
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
