#include "shared/rendering/touched_spheres.hpp"

#include <algorithm>

#include "shared/collision/grid_query.hpp"
#include "shared/display/displayed.hpp"

namespace stillgrid::rendering {
namespace {

/// Where the sphere is displayed and meets the probe; false where it does not.
bool meets(const proto::SphereRecord& record, const display::SnapshotWeights& shown,
           const PlacedToolSphere& probe, TouchedSphere& touch) {
  const display::DisplayedSphere now = display::displayed(record, shown);
  touch.position_m = now.position_m;
  touch.velocity_m_s = now.velocity_m_s;
  touch.presence = now.presence;
  const double contact_distance_m = gathered_within_m(probe, touch.radius_m);
  // Written so that a NaN does not pass.
  return (touch.position_m - probe.position_m).squaredNorm() <
         contact_distance_m * contact_distance_m;
}

/// The longest radius that a swept bound of the grid has, m. A sphere lies within its swept bound.
float longest_bound_m(const proto::GridShape& shape) {
  float longest_m = 0.0F;
  for (std::uint32_t i = 0; i < std::min(shape.level_count, proto::kMaxLevels); ++i)
    longest_m = std::max(longest_m, shape.levels[i].bounding_radius_m);
  return longest_m;
}

}  // namespace

void gather_touched(const collision::GridView& grid, const display::SnapshotWeights& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept {
  const float longest_m = longest_bound_m(grid.shape);
  for (std::uint32_t i = 0; i < tool.size(); ++i) {
    const PlacedToolSphere& probe = tool[i];
    const bool truncated = collision::for_each_candidate(
        grid, gathering_bound(probe), kMaxVisits, [&](std::uint32_t number) {
          if (!touched.may_visit()) return;
          const proto::SphereRecord record = collision::load_record(grid, number);
          if (record.material == proto::kFieldPoint || !(record.radius_m <= longest_m)) return;
          TouchedSphere touch{.position_m = {},
                              .velocity_m_s = {},
                              .radius_m = double{record.radius_m},
                              .material = record.material,
                              .tool_sphere = i,
                              .number = number,
                              .body = record.body,
                              .crushing_force_N = record.crushing_force_N};
          if (meets(record, shown, probe, touch) && touch.velocity_m_s.allFinite())
            touched.add(touch);
        });
    touched.truncated = touched.truncated || truncated;
  }
}

}  // namespace stillgrid::rendering
