#include "sim_server/spheres/felt_error.hpp"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <string>

#include "shared/rendering/force_error.hpp"

namespace stillgrid::spheres {

ExactForces exact_forces(const SurfaceSamples& surface, const mesh::MeshDistance& mesh,
                         double tool_radius_m, double press_depth_m) {
  ExactForces exact;
  for (std::size_t i = 0; i < surface.points_m.size(); ++i) {
    const Eigen::Vector3d tool_m =
        surface.points_m[i] + (tool_radius_m - press_depth_m) * surface.normals[i];
    const double distance_m = mesh.signed_distance_m(tool_m);
    const Eigen::Vector3d apart_m = tool_m - mesh.closest(tool_m).point_m;
    // On the surface itself the way out is the normal.
    const Eigen::Vector3d outward =
        apart_m.norm() > 1e-9 * tool_radius_m
            ? Eigen::Vector3d(std::copysign(1.0, distance_m) * apart_m.normalized())
            : surface.normals[i];
    exact.tool_m.push_back(tool_m);
    exact.force_m.push_back((tool_radius_m - distance_m) * outward);
  }
  return exact;
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

std::optional<double> read_force_share(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  struct Unit {
    std::string_view name;
    double factor, below;
  };
  // A bare 5 is not meant as 500 %.
  for (const Unit& unit :
       {Unit{"%", 0.01, 10.0}, Unit{"jnd", rendering::kJustNoticeable, 10.0}, Unit{"", 1.0, 1.0}}) {
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
