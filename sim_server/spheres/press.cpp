#include "sim_server/spheres/press.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace stillgrid::spheres {

Press make_press(const mesh::TriangleMesh& closed, double tool_radius_m, double press_depth_m,
                 double tolerance_m) {
  constexpr std::size_t kSamples = 6000;
  const Eigen::AlignedBox3d box = mesh::box_of(closed);
  const auto given_or = [](double given_m, double otherwise_m) {
    return given_m > 0.0 ? given_m : otherwise_m;
  };
  const double radius_m = given_or(tool_radius_m, 0.02 * box.diagonal().norm());
  const double quarter_m = 0.25 * radius_m;
  const double depth_m =
      given_or(press_depth_m, std::min(quarter_m, given_or(tolerance_m, quarter_m)));
  const mesh::MeshDistance distance(closed);
  SurfaceSamples reachable =
      reachable_samples(sample_surface(closed, kSamples), distance, radius_m, depth_m);
  if (reachable.points_m.empty())
    throw std::runtime_error("--tool-radius " + std::to_string(radius_m) +
                             ": expected one that fits somewhere on the mesh");
  return {std::move(reachable), radius_m, depth_m};
}

}  // namespace stillgrid::spheres
