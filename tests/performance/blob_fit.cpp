#include "tests/performance/blob_fit.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

namespace stillgrid::performance {
namespace {

using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

Eigen::VectorXd differences_m(const BlobBody& body, std::span<const DistanceTarget> targets) {
  // Out of all reach counts as just there.
  const double search_radius_m = body.tool_radius_m + kFadeTo * body.softness_m;
  Eigen::VectorXd difference_m(static_cast<Eigen::Index>(targets.size()));
  for (std::size_t i = 0; i < targets.size(); ++i)
    difference_m[static_cast<Eigen::Index>(i)] =
        std::min(sample_blobs(body, targets[i].point_m).distance_m, search_radius_m) -
        targets[i].distance_m;
  return difference_m;
}

/// How the smooth distances at the targets change with each ball's centre and radius, four columns
/// a ball, and with the softness, the last column. With p_i the share of ball i in the sum and g_i
/// the distance to its surface: -p_i (x - c_i) / |x - c_i|, -p_i and (s - sum p_i g_i) / softness.
Matrix derivatives_at(const BlobBody& body, std::span<const DistanceTarget> targets,
                      const Eigen::VectorXd& difference_m) {
  constexpr double kNegligible = 1e-3;
  const int last = 4 * static_cast<int>(body.balls.size());
  std::vector<Eigen::Triplet<double>> jacobians;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const int row = static_cast<int>(i);
    const double distance_m = difference_m[row] + targets[i].distance_m;
    double mean_gap_m = 0.0;
    for (const std::uint32_t j : spheres::balls_near(body.grid, targets[i].point_m)) {
      const Eigen::Vector3d apart_m = targets[i].point_m - body.balls[j].centre_m;
      const double gap_m = apart_m.norm() - body.balls[j].radius_m;
      const double share = std::exp((distance_m - gap_m) / body.softness_m);
      if (!(share > kNegligible)) continue;
      mean_gap_m += share * gap_m;
      const int column = 4 * static_cast<int>(j);
      const Eigen::Vector3d by_centre = -share * apart_m.normalized();
      for (int axis = 0; axis < 3; ++axis)
        jacobians.emplace_back(row, column + axis, by_centre[axis]);
      jacobians.emplace_back(row, column + 3, -share);
    }
    jacobians.emplace_back(row, last, (distance_m - mean_gap_m) / body.softness_m);
  }
  Matrix matrix(static_cast<int>(targets.size()), last + 1);
  matrix.setFromTriplets(jacobians.begin(), jacobians.end());
  return matrix;
}

/// The depth of the ripple of plain balls over the targets.
double ripple_depth_m(std::span<const spheres::Ball> balls, std::span<const DistanceTarget> targets,
                      double tool_radius_m) {
  const spheres::BallGrid grid = spheres::make_ball_grid(balls, tool_radius_m);
  double low_m = std::numeric_limits<double>::infinity(), high_m = -low_m;
  for (const DistanceTarget& target : targets) {
    double gap_m = std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : spheres::balls_near(grid, target.point_m))
      gap_m = std::min(gap_m, (target.point_m - balls[i].centre_m).norm() - balls[i].radius_m);
    if (!std::isfinite(gap_m)) continue;
    low_m = std::min(low_m, gap_m - target.distance_m);
    high_m = std::max(high_m, gap_m - target.distance_m);
  }
  // A single ball fits a sphere whatever the softness.
  return std::max(high_m - low_m, 1e-3 * tool_radius_m);
}

BlobBody moved(const BlobBody& body, const Eigen::VectorXd& step_m) {
  std::vector<spheres::Ball> balls = body.balls;
  for (std::size_t j = 0; j < balls.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(4 * j);
    balls[j].centre_m += step_m.segment<3>(column);
    // A file of spheres holds no negative radii.
    balls[j].radius_m = std::max(1e-3 * body.tool_radius_m, balls[j].radius_m + step_m[column + 3]);
  }
  const double softness_m = body.softness_m + step_m[step_m.size() - 1];
  return make_blob_body(balls, std::clamp(softness_m, 0.5 * body.softness_m, 2.0 * body.softness_m),
                        body.tool_radius_m);
}

/// The step of damped least squares: conjugate gradients on the normal equations, each unknown in
/// proportion to its own slopes, roughly, for Levenberg's step needs no more.
Eigen::VectorXd damped_step_m(const Matrix& jacobians, const Eigen::VectorXd& difference_m,
                              double damping) {
  constexpr int kMaxIterations = 60;
  constexpr double kTolerance = 1e-2;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(jacobians.cols());
  for (int row = 0; row < jacobians.outerSize(); ++row)
    for (Matrix::InnerIterator entry(jacobians, row); entry; ++entry)
      squares[entry.col()] += entry.value() * entry.value();
  damping *= squares.mean();
  const Eigen::ArrayXd scale = (squares.array() + damping).inverse();

  Eigen::VectorXd step_m = Eigen::VectorXd::Zero(jacobians.cols());
  Eigen::VectorXd residual = -(jacobians.transpose() * difference_m);
  Eigen::VectorXd direction = (scale * residual.array()).matrix();
  double size = residual.dot(direction);
  const double enough = kTolerance * kTolerance * size;
  for (int i = 0; i < kMaxIterations && size > enough; ++i) {
    const Eigen::VectorXd snapshot = jacobians * direction;
    const Eigen::VectorXd turned = jacobians.transpose() * snapshot + damping * direction;
    const double along = size / direction.dot(turned);
    step_m += along * direction;
    residual -= along * turned;
    const Eigen::VectorXd scaled = (scale * residual.array()).matrix();
    const double next_size = residual.dot(scaled);
    direction = scaled + next_size / size * direction;
    size = next_size;
  }
  return step_m;
}

}  // namespace

std::vector<DistanceTarget> distance_targets(const spheres::SurfaceSamples& surface,
                                             const mesh::MeshDistance& mesh, double tool_radius_m) {
  std::vector<DistanceTarget> targets;
  targets.reserve(3 * surface.points_m.size());
  for (std::size_t i = 0; i < surface.points_m.size(); ++i) {
    targets.push_back({surface.points_m[i], 0.0});
    for (const double out : {0.5, 1.0}) {
      const Eigen::Vector3d point_m =
          surface.points_m[i] + out * tool_radius_m * surface.normals[i];
      targets.push_back({point_m, mesh.signed_distance_m(point_m)});
    }
  }
  return targets;
}

BlobBody fit_blobs(std::span<const spheres::Ball> balls, std::span<const DistanceTarget> targets,
                   double tool_radius_m) {
  constexpr int kMaxSteps = 25;
  constexpr double kLeastGain = 0.02;  // of the squares, in a step
  BlobBody body =
      make_blob_body(balls, ripple_depth_m(balls, targets, tool_radius_m), tool_radius_m);
  Eigen::VectorXd difference_m = differences_m(body, targets);
  double damping = 1e-2, gain = 1.0;
  for (int step = 0; step < kMaxSteps && gain > kLeastGain; ++step) {
    const Matrix jacobians = derivatives_at(body, targets, difference_m);
    const double squares_m2 = difference_m.squaredNorm();
    for (gain = 0.0; gain == 0.0 && damping < 1e4;) {
      BlobBody next = moved(body, damped_step_m(jacobians, difference_m, damping));
      const Eigen::VectorXd next_m = differences_m(next, targets);
      damping *= next_m.squaredNorm() < squares_m2 ? 0.3 : 5.0;
      if (next_m.squaredNorm() >= squares_m2) continue;
      gain = 1.0 - next_m.squaredNorm() / squares_m2;
      body = std::move(next);
      difference_m = next_m;
    }
  }
  return body;
}

BlobFit blob_fit(const BlobBody& body, std::span<const DistanceTarget> targets) {
  const Eigen::VectorXd difference_m = differences_m(body, targets);
  return {std::sqrt(difference_m.squaredNorm() / static_cast<double>(targets.size())),
          difference_m.lpNorm<Eigen::Infinity>()};
}

double blob_surface_error_m(const BlobBody& body, const spheres::SurfaceSamples& surface,
                            const mesh::MeshDistance& mesh) {
  constexpr int kNewtonSteps = 20;
  double error_m = 0.0;
  for (const Eigen::Vector3d& point_m : surface.points_m) {
    Eigen::Vector3d foot_m = point_m;
    for (int step = 0; step < kNewtonSteps; ++step) {
      const BlobSample sample = sample_blobs(body, foot_m);
      if (!std::isfinite(sample.distance_m) || sample.gradient.squaredNorm() < 1e-6)
        return std::numeric_limits<double>::infinity();
      foot_m -= sample.distance_m / sample.gradient.squaredNorm() * sample.gradient;
    }
    error_m =
        std::max({error_m, (foot_m - point_m).norm(), std::abs(mesh.signed_distance_m(foot_m))});
  }
  return error_m;
}

}  // namespace stillgrid::performance
