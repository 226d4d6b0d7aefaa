#include "sim_server/spheres/sampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/spheres/decomposition_candidates.hpp"
#include "sim_server/spheres/surface_samples.hpp"

namespace stillgrid::spheres {
namespace {

constexpr double kSlack = 1e-6;  // of a ball that touches, in the solid's size

/// Keeps points that are apart: each from those kept before by the mean of both's distances.
class Spread {
 public:
  /// No point asks for more than most_m.
  explicit Spread(double most_m) : cell_m_(most_m) {}

  /// Whether none that was kept is nearer.
  [[nodiscard]] bool fits(const Eigen::Vector3d& point_m, double apart_m) const {
    const Cell own = cell_of(point_m);
    for (int n = 0; n < 27; ++n) {
      const auto found =
          cells_.find({own[0] + n % 3 - 1, own[1] + n / 3 % 3 - 1, own[2] + n / 9 - 1});
      if (found == cells_.end()) continue;
      for (const Kept& other : found->second) {
        const double least_m = 0.5 * (other.apart_m + apart_m);
        if ((other.point_m - point_m).squaredNorm() < least_m * least_m) return false;
      }
    }
    return true;
  }
  void keep(const Eigen::Vector3d& point_m, double apart_m) {
    cells_[cell_of(point_m)].push_back({point_m, apart_m});
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct Kept {
    Eigen::Vector3d point_m;
    double apart_m;
  };
  [[nodiscard]] Cell cell_of(const Eigen::Vector3d& point_m) const {
    const auto cell = [&](int axis) {
      return static_cast<std::int64_t>(std::floor(point_m[axis] / cell_m_));
    };
    return {cell(0), cell(1), cell(2)};
  }

  double cell_m_;
  std::map<Cell, std::vector<Kept>> cells_;
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

/// Balls of at most radius_m that touch the surface from inside, but for slack_m, apart by what
/// apart_m says of their radius; that grows with it.
template <class Apart>
std::vector<Ball> touching_balls(const mesh::TriangleMesh& closed, double spacing_m,
                                 double radius_m, double slack_m, Apart&& apart_m) {
  constexpr double kSamplesASpacing = 24.0;  // per square of the spacing: so gaps stay small
  const double most = mesh::surface_area_m2(closed) / (spacing_m * spacing_m);
  require_few(most);
  const MeshSolid solid(closed);
  const auto count = static_cast<std::size_t>(std::ceil(kSamplesASpacing * most));
  const SurfaceSamples samples = sample_surface(closed, std::max<std::size_t>(count, 1));
  Spread spread(apart_m(std::min(radius_m, 0.5 * solid.size_m)));
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < samples.points_m.size(); ++i) {
    // Before the search for the largest ball, which takes long.
    if (!spread.fits(samples.points_m[i], apart_m(0.0))) continue;
    const Ball largest = medial_ball(solid, samples.points_m[i], samples.normals[i],
                                     std::max(slack_m, kSlack * solid.size_m));
    const double fits_m = std::min(radius_m, largest.radius_m);
    if (!(fits_m > 0.0) || !spread.fits(samples.points_m[i], apart_m(fits_m))) continue;
    spread.keep(samples.points_m[i], apart_m(fits_m));
    balls.push_back(largest.radius_m > radius_m
                        ? Ball{samples.points_m[i] - radius_m * samples.normals[i], radius_m}
                        : largest);
  }
  require_some(balls);
  return balls;
}

}  // namespace

std::vector<Ball> surface_balls(const mesh::TriangleMesh& closed, double spacing_m,
                                double radius_m) {
  return touching_balls(closed, spacing_m, radius_m, 0.0, [=](double) { return spacing_m; });
}

std::vector<Ball> firm_surface_balls(const mesh::TriangleMesh& closed, double spacing_m) {
  // A tool pressed in by a depth touches a ball up to sqrt(2 depth (radius + its own)) from where
  // the ball touches the surface: apart in proportion, as many are touched. Tools are taken to be
  // three spacings.
  const double tool_m = 3.0 * spacing_m;
  constexpr double kFirmSlack = 0.1;  // a faceted surface's flat edges are no edges
  return touching_balls(closed, spacing_m, std::numeric_limits<double>::infinity(),
                        kFirmSlack * spacing_m, [=](double ball_m) {
                          return spacing_m * std::sqrt((ball_m + tool_m) / (spacing_m + tool_m));
                        });
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

std::vector<Ball> firm_volume_balls(const mesh::TriangleMesh& closed, double spacing_m) {
  std::vector<Ball> balls = volume_balls(closed, spacing_m, kVolumeRadius * spacing_m);
  const mesh::MeshDistance distance(closed);
  const Eigen::Vector3d first_m = balls.front().centre_m;
  // As balls grow with the depth they stand farther apart: else any place would be in thousands.
  const auto is_left_out = [&](const Ball& ball, double depth_m) {
    int stride = 1;
    while (2.0 * stride * spacing_m <= kFirmSpacing * depth_m) stride *= 2;
    const Eigen::Array3i at = ((ball.centre_m - first_m).array() / spacing_m).round().cast<int>();
    return (at.unaryExpr([&](int place) { return place % stride; }) != 0).any();
  };
  std::erase_if(balls, [&](Ball& ball) {
    const double depth_m = -distance.signed_distance_m(ball.centre_m);
    ball.radius_m = std::max(ball.radius_m, kFirmGrowth * depth_m);
    return is_left_out(ball, depth_m);
  });
  return balls;
}

std::vector<Ball> shell_balls(const mesh::TriangleMesh& mesh, double radius_m) {
  constexpr double kSamples = 12.0;  // per square of the spacing
  const double apart_m = kShellSpacing * radius_m,
               most = mesh::surface_area_m2(mesh) / (apart_m * apart_m);
  require_few(most);
  const auto count = static_cast<std::size_t>(std::ceil(kSamples * most));
  Spread spread(apart_m);
  std::vector<Ball> balls;
  const auto cover = [&](const Eigen::Vector3d& point_m) {
    if (!spread.fits(point_m, apart_m)) return;
    spread.keep(point_m, apart_m);
    balls.push_back({point_m, radius_m});
  };
  // Corners first: samples leave them out.
  for (const Eigen::Vector3i& triangle : mesh.triangles)
    for (const int vertex : triangle) cover(mesh.vertices_m[static_cast<std::size_t>(vertex)]);
  std::ranges::for_each(sample_surface(mesh, std::max<std::size_t>(count, 1)).points_m, cover);
  return balls;
}

}  // namespace stillgrid::spheres
