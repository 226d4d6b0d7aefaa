#include "haptic_server/rendering/touched_spheres.hpp"

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

}  // namespace

void gather_touched(const GridView& grid, const ImageWeights& weights,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept {
  for (std::uint32_t i = 0; i < tool.size(); ++i) {
    const PlacedToolSphere& probe = tool[i];
    const bool cut = for_each_candidate(
        grid, box_round(probe.position_m, probe.radius_m), kMaxVisits,
        [&](std::uint32_t sphere, const RecordLine& line) {
          const Displayed shown = displayed(grid, sphere, line, weights);
          const double reach_m = probe.radius_m + line.radius_m;
          // Written so that a NaN does not pass.
          if (!((shown.position_m - probe.position_m).squaredNorm() < reach_m * reach_m)) return;
          if (!shown.velocity_m_s.allFinite()) return;
          if (touched.count == TouchedSpheres::kCapacity) {
            touched.cut = true;
            return;
          }
          const std::uint32_t material = load_record(grid, sphere).material;
          touched.spheres[touched.count++] = {shown.position_m, shown.velocity_m_s,
                                              static_cast<double>(line.radius_m), material, i};
        });
    touched.cut = touched.cut || cut;
  }
}

}  // namespace stillgrid
