#include "shared/rendering/touched_spheres.hpp"

#include <algorithm>
#include <cmath>

#include "shared/collision/grid_query.hpp"
#include "shared/display/displayed.hpp"
#include "shared/rendering/tool_sweep.hpp"

namespace stillgrid::rendering {
namespace {

/// Where the sphere is displayed and meets the probe; false where it does not.
bool meets(const proto::SphereRecord& record, const DisplayedMotion& shown,
           const PlacedToolSphere& probe, TouchedSphere& touch) {
  const display::DisplayedSphere now = display::displayed(record, shown.now);
  touch.position_m = now.position_m;
  touch.velocity_m_s = now.velocity_m_s;
  touch.presence = now.presence;
  const double contact_distance_m = probe.radius_m + touch.radius_m;
  // Written so that a NaN does not pass.
  if ((touch.position_m - probe.position_m).squaredNorm() < contact_distance_m * contact_distance_m)
    return true;
  if (now.presence < 1.0) return false;
  const display::DisplayedSphere before = display::displayed(record, shown.before);
  const auto closest_m =
      closest_line_m(probe.before_m - before.position_m, probe.position_m - touch.position_m,
                     contact_distance_m, probe.radius_m);
  if (!closest_m) return false;
  touch.position_m = probe.position_m - *closest_m;
  touch.swept = true;
  return true;
}

}  // namespace

void TouchedSpheres::drop_swept() noexcept {
  const auto last =
      std::remove_if(spheres.begin(), spheres.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const TouchedSphere& sphere) { return sphere.swept; });
  count = static_cast<std::size_t>(last - spheres.begin());
}

void gather_touched(const collision::GridView& grid, const DisplayedMotion& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept {
  for (std::uint32_t i = 0; i < tool.size(); ++i) {
    const PlacedToolSphere& probe = tool[i];
    const bool truncated = collision::for_each_candidate(
        grid, bound_tool_sweep(probe), kMaxVisits, [&](std::uint32_t number) {
          if (!touched.may_visit()) return;
          const proto::SphereRecord record = collision::load_record(grid, number);
          if (record.material == proto::kFieldPoint) return;
          TouchedSphere touch{.position_m = {},
                              .velocity_m_s = {},
                              .radius_m = double{record.radius_m},
                              .material = record.material,
                              .tool_sphere = i,
                              .swept = false,
                              .number = number,
                              .body = record.body};
          if (meets(record, shown, probe, touch) && touch.velocity_m_s.allFinite() &&
              std::isfinite(touch.radius_m))
            touched.add(touch);
        });
    touched.truncated = touched.truncated || truncated;
  }
}

}  // namespace stillgrid::rendering
