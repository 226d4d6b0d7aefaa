#include "shared/rendering/compliant_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace stillgrid::rendering {
namespace {

double farthest_N(const TouchedSpheres& touched, std::span<const PlacedToolSphere> tool) {
  double most_per_N = 0.0;
  for (const TouchedSphere& sphere : touched.all())
    if (sphere.tool_sphere < tool.size())
      most_per_N = std::max(most_per_N,
                            sphere.compliance_m_per_N.norm() / tool[sphere.tool_sphere].radius_m);
  return most_per_N > 0.0 ? kMaxCompliantShift / most_per_N : std::numeric_limits<double>::max();
}

}  // namespace

ToolPush tool_push(const proto::SnapshotHeader& snapshot) noexcept {
  const Eigen::Vector3d direction(snapshot.compliance_direction.data());
  const double force_N = snapshot.compliance_force_N;
  // Written so that a NaN does not pass.
  if (!(std::abs(direction.squaredNorm() - 1.0) < 1e-3) ||
      !(force_N >= 0.0 && force_N <= proto::kLargestNumber))
    return {};
  return {direction, force_N};
}

void apply_compliance(TouchedSpheres& touched, double change_N) noexcept {
  for (std::size_t i = 0; i < touched.count; ++i)
    touched.spheres[i].position_m += change_N * touched.spheres[i].compliance_m_per_N;
}

double solve_compliance(const proto::SceneHeader& scene, const ToolPush& push,
                        std::span<const PlacedToolSphere> tool, const ToolPose& pose,
                        double change_N, double tolerance_N, TouchedSpheres& touched) noexcept {
  double at_N = change_N;
  // How much more the tool pushes than the spheres have given way to.
  const auto excess_N = [&](double to_N) {
    apply_compliance(touched, to_N - at_N);
    at_N = to_N;
    return push_ahead_N(scene, touched, tool, pose, push.direction) - push.force_N - to_N;
  };
  // The push falls by nothing at least while they give way a newton more: it is met on this side.
  double low_N = change_N, low_excess_N = excess_N(low_N);
  if (!(std::abs(low_excess_N) > tolerance_N)) return at_N;
  double high_N = low_N + std::copysign(std::min(std::abs(low_excess_N), farthest_N(touched, tool)),
                                        low_excess_N);
  double high_excess_N = excess_N(high_N);
  if (!(low_excess_N * high_excess_N < 0.0)) return at_N;
  if (low_excess_N < 0.0) {
    std::swap(low_N, high_N);
    std::swap(low_excess_N, high_excess_N);
  }
  constexpr int kMaxSteps = 8;
  for (int i = 0, side = 0; i < kMaxSteps; ++i) {
    const double next_N =
        (low_N * high_excess_N - high_N * low_excess_N) / (high_excess_N - low_excess_N);
    const double excess = excess_N(next_N);
    if (!(std::abs(excess) > tolerance_N)) break;
    if (excess < 0.0) {
      high_N = next_N;
      high_excess_N = excess;
      if (side < 0) low_excess_N *= 0.5;
      side = -1;
    } else {
      low_N = next_N;
      low_excess_N = excess;
      if (side > 0) high_excess_N *= 0.5;
      side = 1;
    }
  }
  return at_N;
}

}  // namespace stillgrid::rendering
