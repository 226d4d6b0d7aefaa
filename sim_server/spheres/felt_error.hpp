#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::spheres {

/// Places of a tool sphere's centre, and the force that the mesh itself would have there for 1 N/m:
/// the depth under its nearest point, outward. In metres, body's own frame.
struct ExactForces {
  std::vector<Eigen::Vector3d> tool_m, force_m;
};

/// Of a tool pressed press_depth_m deep along each sample's normal. Pre: the samples are some of
/// reachable_samples() of that mesh at this radius and depth.
[[nodiscard]] ExactForces exact_forces(const SurfaceSamples& surface,
                                       const mesh::MeshDistance& mesh, double tool_radius_m,
                                       double press_depth_m);

/// How far a body's force is from the mesh's, in size and direction.
struct FeltError {
  double share = 1.0;            // rms of the difference over rms of the mesh's force
  double stiffness_scale = 0.0;  // of a contact, that makes it least; 0: nothing pushes back
  /// In just noticeable differences of a force.
  [[nodiscard]] double jnd() const;
};

/// At the stiffness that suits best, one for the whole body. Pre: exact not empty.
[[nodiscard]] FeltError felt_error(const ExactForces& exact, const UnitForce& force);

/// A share of a force as scene_fit takes it, of `5%`, `0.05` or `0.7jnd`: nothing where it is none,
/// not above 0, or not below 1 without a unit, 10 (1000 %) with one.
[[nodiscard]] std::optional<double> read_force_share(std::string_view text);

/// What read_force_share() takes, for a refusal.
inline constexpr const char* kForceShareWords = "a share of the force, such as 5%, 0.05 or 0.7jnd";

}  // namespace stillgrid::spheres
