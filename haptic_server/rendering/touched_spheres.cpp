#include "haptic_server/rendering/touched_spheres.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "shared/collision/grid_query.hpp"

namespace stillgrid {
namespace {

Eigen::Vector3d vector(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

struct Displayed {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

void add(Displayed& sum, const proto::SphereImage& image, double weight) {
  sum.position_m += weight * vector(image.position_m);
  sum.velocity_m_s += weight * vector(image.velocity_m_s);
}

/// Of the older images only a record's second cache line knows; it is read when they weigh.
Displayed displayed(const GridView& grid, std::uint32_t sphere, const RecordLine& line,
                    const ImageWeights& weights) {
  Displayed sum;
  add(sum, line.newest[0], weights.weight[0]);
  add(sum, line.newest[1], weights.weight[1]);
  if (weights.weight[2] == 0.0 && weights.weight[3] == 0.0) return sum;
  const proto::SphereRecord record = load_record(grid, sphere);
  add(sum, record.older[0], weights.weight[2]);
  add(sum, record.older[1], weights.weight[3]);
  return sum;
}

/// A way shorter than this share of the tool sphere's radius is not swept.
constexpr double kShortWay = 0.5;

/// A ball that the tool sphere did not leave since the tick before.
Cover cover_way(const PlacedToolSphere& probe) {
  const double moved_m2 = (probe.position_m - probe.before_m).squaredNorm();
  const double short_m = kShortWay * probe.radius_m;
  // Written so that a NaN takes the simple side.
  if (!(moved_m2 > short_m * short_m))
    return cover_round(probe.position_m,
                       probe.radius_m + (moved_m2 > 0.0 ? std::sqrt(moved_m2) : 0.0));
  return cover_path(probe.before_m, probe.position_m, probe.radius_m);
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

void TouchedSpheres::drop_swept() noexcept {
  const auto last =
      std::remove_if(spheres.begin(), spheres.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const TouchedSphere& sphere) { return sphere.swept; });
  count = static_cast<std::size_t>(last - spheres.begin());
}

void gather_touched(const GridView& grid, const DisplayedMotion& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept {
  for (std::uint32_t i = 0; i < tool.size(); ++i) {
    const PlacedToolSphere& probe = tool[i];
    const bool cut =
        for_each_candidate(grid, cover_way(probe), kMaxVisits, [&](std::uint32_t sphere) {
          const RecordLine line = load_line(grid, sphere);
          const Displayed now = displayed(grid, sphere, line, shown.now);
          TouchedSphere touch{now.position_m,
                              now.velocity_m_s,
                              static_cast<double>(line.radius_m),
                              line.material,
                              i,
                              false};
          const double reach_m = probe.radius_m + touch.radius_m;
          // Written so that a NaN does not pass.
          if (!((now.position_m - probe.position_m).squaredNorm() < reach_m * reach_m)) {
            const Displayed before = displayed(grid, sphere, line, shown.before);
            const auto closest_m =
                closest_line_m(probe.before_m - before.position_m,
                               probe.position_m - now.position_m, reach_m, probe.radius_m);
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
