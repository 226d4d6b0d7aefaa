#include "tests/performance/blobs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stillgrid::performance {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A term's fading: 1 to 0 over t in [0, 1], twice continuously differentiable at both ends.
double fade(double t) {
  return 1.0 - t * t * t * (10.0 - t * (15.0 - 6.0 * t));
}
double fade_slope(double t) {
  return -30.0 * t * t * (1.0 - t) * (1.0 - t);
}

/// One ball's term and its derivative by the distance, both over softness and for a ball whose
/// term at its own surface is 1.
struct Term {
  double value;
  double slope;
};

Term term_at(const BlobBody& body, double gap_m) {
  const double u = gap_m / body.softness_m;
  const double value = std::exp(-u);
  const double t = (u - body.tool_radius_m / body.softness_m - kFadeFrom) / (kFadeTo - kFadeFrom);
  if (t <= 0.0) return {value, -value};
  return {value * fade(t), value * (fade_slope(t) / (kFadeTo - kFadeFrom) - fade(t))};
}

}  // namespace

BlobBody make_blob_body(std::span<const spheres::Ball> balls, double softness_m,
                        double tool_radius_m) {
  return {{balls.begin(), balls.end()},
          spheres::make_ball_grid(balls, tool_radius_m + kFadeTo * softness_m),
          softness_m,
          tool_radius_m};
}

BlobSample sample_blobs(const BlobBody& body, const Eigen::Vector3d& point_m) noexcept {
  const double search_radius_m = body.tool_radius_m + kFadeTo * body.softness_m;
  double sum = 0.0;
  Eigen::Vector3d slopes = Eigen::Vector3d::Zero();
  for (const std::uint32_t i : spheres::balls_near(body.grid, point_m)) {
    const Eigen::Vector3d apart_m = point_m - body.balls[i].centre_m;
    const double distance_m = apart_m.norm();
    const double gap_m = distance_m - body.balls[i].radius_m;
    if (!(gap_m < search_radius_m)) continue;
    const Term term = term_at(body, gap_m);
    sum += term.value;
    if (distance_m > 0.0) slopes += term.slope / distance_m * apart_m;
  }
  if (!(sum > 0.0)) return {kInfinity, Eigen::Vector3d::Zero()};
  return {-body.softness_m * std::log(sum), -slopes / sum};
}

Eigen::Vector3d unit_blob_force_m(const BlobBody& body, double tool_radius_m,
                                  const Eigen::Vector3d& tool_m) noexcept {
  const BlobSample sample = sample_blobs(body, tool_m);
  return std::max(0.0, tool_radius_m - sample.distance_m) * sample.gradient;
}

}  // namespace stillgrid::performance
