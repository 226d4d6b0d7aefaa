#include "sim_server/spheres/felt_error.hpp"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <string>

#include "shared/rendering/force_error.hpp"

namespace stillgrid::spheres {

Eigen::Vector3d exact_force_m(const mesh::MeshDistance& mesh, const Eigen::Vector3d& tool_m,
                              double tool_radius_m) {
  constexpr double kOnSurface = 1e-9;  // of the radius; nearer, the way out is the normal
  const double distance_m = mesh.signed_distance_m(tool_m);
  if (distance_m >= tool_radius_m) return Eigen::Vector3d::Zero();
  const mesh::NearestPoint nearest = mesh.closest(tool_m);
  const Eigen::Vector3d out = std::abs(distance_m) < kOnSurface * tool_radius_m
                                  ? nearest.normal
                                  : Eigen::Vector3d((tool_m - nearest.point_m) / distance_m);
  return (tool_radius_m - distance_m) * out;
}

ExactForces exact_forces(const SurfaceSamples& surface, const mesh::MeshDistance& mesh,
                         double tool_radius_m, double press_depth_m) {
  ExactForces exact;
  for (std::size_t i = 0; i < surface.points_m.size(); ++i) {
    exact.tool_m.push_back(pressed_tool_m(surface, i, tool_radius_m, press_depth_m));
    exact.force_m.push_back(exact_force_m(mesh, exact.tool_m.back(), tool_radius_m));
  }
  return exact;
}

ExactForces press_everywhere(const mesh::TriangleMesh& closed, const mesh::MeshDistance& distance,
                             std::size_t count, double tool_radius_m,
                             std::span<const double> depths_m) {
  const SurfaceSamples surface = sample_surface(closed, count);
  ExactForces all;
  for (const double depth_m : depths_m) {
    const ExactForces exact =
        exact_forces(reachable_samples(surface, distance, tool_radius_m, depth_m), distance,
                     tool_radius_m, depth_m);
    all.tool_m.insert(all.tool_m.end(), exact.tool_m.begin(), exact.tool_m.end());
    all.force_m.insert(all.force_m.end(), exact.force_m.begin(), exact.force_m.end());
  }
  return all;
}

double FeltError::jnd() const {
  return share / rendering::kJustNoticeable;
}

FeltError felt_error(const ExactForces& exact, const UnitForce& force) {
  assert(!exact.tool_m.empty());
  double own_m2 = 0.0, common_m2 = 0.0, true_m2 = 0.0;
  for (std::size_t i = 0; i < exact.tool_m.size(); ++i) {
    const Eigen::Vector3d force_m = force(exact.tool_m[i]);
    own_m2 += force_m.squaredNorm();
    common_m2 += force_m.dot(exact.force_m[i]);
    true_m2 += exact.force_m[i].squaredNorm();
  }
  if (!(own_m2 > 0.0) || !(common_m2 > 0.0)) return {};
  // Least squares: the error is what of the true force is not along ours.
  return {std::sqrt(std::max(0.0, 1.0 - common_m2 / own_m2 * common_m2 / true_m2)),
          common_m2 / own_m2};
}

FeltError unscaled_error(const ExactForces& exact, const UnitForce& force) {
  assert(!exact.tool_m.empty());
  double error_m2 = 0.0, true_m2 = 0.0;
  for (std::size_t i = 0; i < exact.tool_m.size(); ++i) {
    error_m2 += (force(exact.tool_m[i]) - exact.force_m[i]).squaredNorm();
    true_m2 += exact.force_m[i].squaredNorm();
  }
  return {std::sqrt(error_m2 / true_m2), 1.0};
}

std::optional<double> read_force_share(std::string_view text, const ShareLimits& limits) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  struct Unit {
    std::string_view name;
    double factor, below;
  };
  for (const Unit& unit :
       {Unit{"%", 0.01, limits.with_unit},
        Unit{"jnd", rendering::kJustNoticeable, limits.with_unit}, Unit{"", 1.0, limits.bare}}) {
    if (!lower.ends_with(unit.name)) continue;
    const char* const end = lower.data() + (lower.size() - unit.name.size());
    double number = 0.0;
    const auto [rest, error] = std::from_chars(lower.data(), end, number);
    const double share = number * unit.factor;
    if (error == std::errc() && rest == end && share > 0.0 && share < unit.below) return share;
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace stillgrid::spheres
