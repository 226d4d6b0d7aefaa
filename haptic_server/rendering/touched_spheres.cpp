#include "haptic_server/rendering/touched_spheres.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "shared/collision/grid_query.hpp"
#include "shared/display/displayed.hpp"

namespace stillgrid {
namespace {

/// Where the weights alone display a sphere of the grid.
DisplayedSphere displayed(const GridView& grid, std::uint32_t sphere, const RecordLine& line,
                          const ImageWeights& weights) {
  return displayed(line, weights, [&] { return load_record(grid, sphere); });
}

/// Displays a sphere that some snapshot lacks by those it is in.
void show_where_present(const GridView& grid, std::uint32_t sphere, const ImageWeights& weights,
                        TouchedSphere& touch) {
  const DisplayedSphere shown = displayed_where_present(load_record(grid, sphere), weights);
  touch.position_m = shown.position_m;
  touch.velocity_m_s = shown.velocity_m_s;
  touch.presence = shown.presence;
  touch.yields_m_N.setZero();
}

/// A way shorter than this share of the tool sphere's radius is not swept.
constexpr double kShortWay = 0.5;

/// A ball that the tool sphere did not leave since the tick before, seen by what is displayed up
/// to room_m from where its cover is.
Cover cover_way(const PlacedToolSphere& probe, double room_m) {
  const double moved_m2 = (probe.position_m - probe.before_m).squaredNorm();
  const double short_m = kShortWay * probe.radius_m;
  // Written so that a NaN takes the simple side.
  if (!(moved_m2 > short_m * short_m))
    return cover_round(probe.position_m,
                       probe.radius_m + room_m + (moved_m2 > 0.0 ? std::sqrt(moved_m2) : 0.0));
  return cover_path(probe.before_m, probe.position_m, probe.radius_m + room_m);
}

/// The line from the sphere to the tool when they were closest, if they moved far past one another
/// and touched only on the way.
std::optional<Eigen::Vector3d> closest_line_m(const Eigen::Vector3d& before_m,
                                              const Eigen::Vector3d& now_m, double reach_m,
                                              double tool_radius_m) {
  const Eigen::Vector3d way_m = now_m - before_m;
  const double way_m2 = way_m.squaredNorm(), short_m = kShortWay * tool_radius_m;
  if (!(way_m2 > short_m * short_m) || !(before_m.squaredNorm() >= reach_m * reach_m))
    return std::nullopt;
  const double share = -before_m.dot(way_m) / way_m2;
  if (!(share > 0.0 && share < 1.0)) return std::nullopt;
  const Eigen::Vector3d line_m = before_m + share * way_m;
  const double distance_m2 = line_m.squaredNorm();
  if (!(distance_m2 < reach_m * reach_m)) return std::nullopt;
  // Through the centre there is no side but the one it came from.
  constexpr double kCentral = 1e-6;
  if (distance_m2 < kCentral * kCentral * reach_m * reach_m)
    return kCentral * reach_m * before_m.normalized();
  return line_m;
}

}  // namespace

Eigen::Vector3d displayed_m(const GridView& grid, std::uint32_t number, const ImageWeights& weights,
                            const Yielding& yielding) noexcept {
  const RecordLine line = load_line(grid, number);
  return displayed(grid, number, line, weights).position_m + yielding.shift_m +
         yielding.change_N * compliance_m_per_N(line, weights);
}

void TouchedSpheres::drop_swept() noexcept {
  const auto last =
      std::remove_if(spheres.begin(), spheres.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const TouchedSphere& sphere) { return sphere.swept; });
  count = static_cast<std::size_t>(last - spheres.begin());
}

void gather_touched(const GridView& grid, const DisplayedMotion& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept {
  const Yielding& yielding = shown.yielding;
  const double room_m = yielding.shift_m.norm() +
                        (std::abs(yielding.change_N) + yielding.slack_N) * yielding.longest_m_N;
  for (std::uint32_t i = 0; i < tool.size(); ++i) {
    const PlacedToolSphere& probe = tool[i];
    const bool cut =
        for_each_candidate(grid, cover_way(probe, room_m), kMaxVisits, [&](std::uint32_t sphere) {
          const RecordLine line = load_line(grid, sphere);
          const DisplayedSphere now = displayed(grid, sphere, line, shown.now);
          const Eigen::Vector3d own_m_N = compliance_m_per_N(line, shown.now);
          const Eigen::Vector3d yielded_m = yielding.shift_m + yielding.change_N * own_m_N;
          TouchedSphere touch{now.position_m + yielded_m,
                              now.velocity_m_s,
                              static_cast<double>(line.radius_m),
                              line.material,
                              i,
                              false,
                              sphere,
                              own_m_N,
                              is_compliant(line)};
          const double reach_m = probe.radius_m + touch.radius_m;
          const double wanted_m = reach_m + yielding.slack_N * own_m_N.norm();
          // Written so that a NaN does not pass.
          const auto is_within = [&](double distance_m) {
            return (touch.position_m - probe.position_m).squaredNorm() < distance_m * distance_m;
          };
          const bool is_touched = is_within(wanted_m);
          if (!is_touched && touch.position_m.hasNaN()) {
            show_where_present(grid, sphere, shown.now, touch);
            if (!is_within(reach_m)) return;
          } else if (!is_touched) {
            const DisplayedSphere before = displayed(grid, sphere, line, shown.before);
            const auto closest_m =
                closest_line_m(probe.before_m - before.position_m - yielded_m,
                               probe.position_m - touch.position_m, reach_m, probe.radius_m);
            if (!closest_m) return;
            touch.position_m = probe.position_m - *closest_m;
            touch.swept = true;
          }
          if (!touch.velocity_m_s.allFinite() || !std::isfinite(reach_m)) return;
          if (touched.count == TouchedSpheres::kCapacity) {
            touched.cut = true;
            return;
          }
          touched.spheres[touched.count++] = touch;
        });
    touched.cut = touched.cut || cut;
  }
}

}  // namespace stillgrid
