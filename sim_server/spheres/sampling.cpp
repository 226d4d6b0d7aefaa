#include "sim_server/spheres/sampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <sstream>
#include <stdexcept>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/spheres/decomposition_candidates.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {
namespace {

/// Keeps points that are no nearer than spacing_m to one that was kept before.
class Spread {
 public:
  explicit Spread(double spacing_m) : spacing_m_(spacing_m) {}

  bool keep(const Eigen::Vector3d& point_m) {
    const auto cell = [&](int axis) {
      return static_cast<std::int64_t>(std::floor(point_m[axis] / spacing_m_));
    };
    const Cell own = {cell(0), cell(1), cell(2)};
    for (int n = 0; n < 27; ++n) {
      const auto found =
          cells_.find({own[0] + n % 3 - 1, own[1] + n / 3 % 3 - 1, own[2] + n / 9 - 1});
      if (found == cells_.end()) continue;
      for (const Eigen::Vector3d& other_m : found->second)
        if ((other_m - point_m).squaredNorm() < spacing_m_ * spacing_m_) return false;
    }
    cells_[own].push_back(point_m);
    return true;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  double spacing_m_;
  std::map<Cell, std::vector<Eigen::Vector3d>> cells_;
};

void require_few(double balls) {
  if (balls <= kMaxSampledBalls) return;
  std::ostringstream line;
  line << "sampling: about " << balls << " balls: expected at most " << kMaxSampledBalls;
  throw std::invalid_argument(line.str());
}

void require_some(const std::vector<Ball>& balls) {
  if (balls.empty())
    throw std::invalid_argument("sampling: 0 balls: expected a spacing that fits the solid");
}

}  // namespace

std::vector<Ball> surface_balls(const mesh::TriangleMesh& closed, double spacing_m,
                                double radius_m) {
  constexpr double kSamplesASpacing = 24.0;  // per square of the spacing: so gaps stay small
  constexpr double kSlack = 1e-6;
  const double most = mesh::surface_area_m2(closed) / (spacing_m * spacing_m);
  require_few(most);
  const MeshSolid solid(closed);
  const auto count = static_cast<std::size_t>(std::ceil(kSamplesASpacing * most));
  const SurfaceSamples samples = sample_surface(closed, std::max<std::size_t>(count, 1));
  Spread spread(spacing_m);
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < samples.points_m.size(); ++i) {
    if (!spread.keep(samples.points_m[i])) continue;
    const Ball largest =
        medial_ball(solid, samples.points_m[i], samples.normals[i], kSlack * solid.size_m);
    const double fits_m = std::min(radius_m, largest.radius_m);
    if (fits_m > 0.0) balls.push_back({samples.points_m[i] - fits_m * samples.normals[i], fits_m});
  }
  require_some(balls);
  return balls;
}

std::vector<Ball> volume_balls(const mesh::TriangleMesh& closed, double spacing_m,
                               double radius_m) {
  Eigen::Vector3d low = closed.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& vertex : closed.vertices_m) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  require_few(((high - low).array() / spacing_m).max(1.0).prod());
  // A side of n spacings has n cells, whatever rounding made of it.
  const Eigen::Array3i cells =
      ((high - low).array() / spacing_m - 1e-9).ceil().max(1.0).cast<int>();
  const Eigen::Vector3d first_m =
      0.5 * (low + high) - 0.5 * spacing_m * (cells - 1).cast<double>().matrix();
  const auto point_m = [&](int i, int j, int k) -> Eigen::Vector3d {
    return first_m + spacing_m * Eigen::Vector3d(i, j, k);
  };
  const mesh::MeshDistance distance(closed);
  std::vector<Ball> balls;
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i)
        if (distance.signed_distance_m(point_m(i, j, k)) < 0.0)
          balls.push_back({point_m(i, j, k), radius_m});
  require_some(balls);
  return balls;
}

}  // namespace stillgrid::spheres
