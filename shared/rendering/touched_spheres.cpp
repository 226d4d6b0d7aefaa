#include "shared/rendering/touched_spheres.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "shared/collision/grid_query.hpp"
#include "shared/display/displayed.hpp"

namespace stillgrid::rendering {
namespace {

/// Where the weights alone display a sphere of the grid.
display::DisplayedSphere displayed(const collision::GridView& grid, std::uint32_t sphere,
                                   const collision::RecordLine& line,
                                   const display::SnapshotWeights& weights) {
  return display::displayed(line, weights, [&] { return collision::load_record(grid, sphere); });
}

/// Displays a sphere that some snapshot lacks by those it is in.
void show_where_present(const collision::GridView& grid, std::uint32_t sphere,
                        const display::SnapshotWeights& weights, TouchedSphere& touch) {
  const display::DisplayedSphere shown =
      display::displayed_where_present(collision::load_record(grid, sphere), weights);
  touch.position_m = shown.position_m;
  touch.velocity_m_s = shown.velocity_m_s;
  touch.presence = shown.presence;
  touch.compliance_m_per_N.setZero();
}

/// A way shorter than this share of the tool sphere's radius is not swept.
constexpr double kShortSweep = 0.5;

/// A ball that the tool sphere did not leave since the tick before, seen by what is displayed up
/// to room_m from where its cover is.
collision::SweptBound bound_tool_sweep(const PlacedToolSphere& probe, double room_m) {
  const double moved_m2 = (probe.position_m - probe.before_m).squaredNorm();
  const double short_m = kShortSweep * probe.radius_m;
  // Written so that a NaN takes the simple side.
  if (!(moved_m2 > short_m * short_m))
    return collision::bound_sphere(
        probe.position_m, probe.radius_m + room_m + (moved_m2 > 0.0 ? std::sqrt(moved_m2) : 0.0));
  return collision::bound_sweep(probe.before_m, probe.position_m, probe.radius_m + room_m);
}

/// The line from the sphere to the tool when they were closest, if they moved far past one another
/// and touched only on the way.
std::optional<Eigen::Vector3d> closest_line_m(const Eigen::Vector3d& before_m,
                                              const Eigen::Vector3d& now_m,
                                              double contact_distance_m, double tool_radius_m) {
  const Eigen::Vector3d sweep_m = now_m - before_m;
  const double sweep_m2 = sweep_m.squaredNorm(), short_m = kShortSweep * tool_radius_m;
  if (!(sweep_m2 > short_m * short_m) ||
      !(before_m.squaredNorm() >= contact_distance_m * contact_distance_m))
    return std::nullopt;
  const double share = -before_m.dot(sweep_m) / sweep_m2;
  if (!(share > 0.0 && share < 1.0)) return std::nullopt;
  const Eigen::Vector3d line_m = before_m + share * sweep_m;
  const double distance_m2 = line_m.squaredNorm();
  if (!(distance_m2 < contact_distance_m * contact_distance_m)) return std::nullopt;
  // Through the centre there is no side but the one it came from.
  constexpr double kCentral = 1e-6;
  if (distance_m2 < kCentral * kCentral * contact_distance_m * contact_distance_m)
    return kCentral * contact_distance_m * before_m.normalized();
  return line_m;
}

}  // namespace

Eigen::Vector3d displayed_m(const collision::GridView& grid, std::uint32_t number,
                            const display::SnapshotWeights& weights,
                            const CompliantDisplay& compliant_display) noexcept {
  const collision::RecordLine line = collision::load_line(grid, number);
  return displayed(grid, number, line, weights).position_m + compliant_display.shift_m +
         compliant_display.change_N * display::compliance_m_per_N(line, weights);
}

void TouchedSpheres::drop_swept() noexcept {
  const auto last =
      std::remove_if(spheres.begin(), spheres.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const TouchedSphere& sphere) { return sphere.swept; });
  count = static_cast<std::size_t>(last - spheres.begin());
}

void gather_touched(const collision::GridView& grid, const DisplayedMotion& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept {
  const CompliantDisplay& compliant_display = shown.compliant_display;
  const double room_m = compliant_display.shift_m.norm() +
                        (std::abs(compliant_display.change_N) + compliant_display.slack_N) *
                            compliant_display.max_m_per_N;
  for (std::uint32_t i = 0; i < tool.size(); ++i) {
    const PlacedToolSphere& probe = tool[i];
    const bool truncated = collision::for_each_candidate(
        grid, bound_tool_sweep(probe, room_m), kMaxVisits, [&](std::uint32_t sphere) {
          const collision::RecordLine line = collision::load_line(grid, sphere);
          const display::DisplayedSphere now = displayed(grid, sphere, line, shown.now);
          const Eigen::Vector3d own_m_per_N = display::compliance_m_per_N(line, shown.now);
          const Eigen::Vector3d yielded_m =
              compliant_display.shift_m + compliant_display.change_N * own_m_per_N;
          TouchedSphere touch{now.position_m + yielded_m,
                              now.velocity_m_s,
                              static_cast<double>(line.radius_m),
                              line.material,
                              i,
                              false,
                              sphere,
                              own_m_per_N,
                              display::is_compliant(line)};
          const double contact_distance_m = probe.radius_m + touch.radius_m;
          const double wanted_m =
              contact_distance_m + compliant_display.slack_N * own_m_per_N.norm();
          // Written so that a NaN does not pass.
          const auto is_within = [&](double distance_m) {
            return (touch.position_m - probe.position_m).squaredNorm() < distance_m * distance_m;
          };
          const bool is_touched = is_within(wanted_m);
          if (!is_touched && touch.position_m.hasNaN()) {
            show_where_present(grid, sphere, shown.now, touch);
            if (!is_within(contact_distance_m)) return;
          } else if (!is_touched) {
            const display::DisplayedSphere before = displayed(grid, sphere, line, shown.before);
            const auto closest_m = closest_line_m(probe.before_m - before.position_m - yielded_m,
                                                  probe.position_m - touch.position_m,
                                                  contact_distance_m, probe.radius_m);
            if (!closest_m) return;
            touch.position_m = probe.position_m - *closest_m;
            touch.swept = true;
          }
          if (!touch.velocity_m_s.allFinite() || !std::isfinite(contact_distance_m)) return;
          if (touched.count == TouchedSpheres::kCapacity) {
            touched.truncated = true;
            return;
          }
          touched.spheres[touched.count++] = touch;
        });
    touched.truncated = touched.truncated || truncated;
  }
}

}  // namespace stillgrid::rendering
