#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::spheres {

/// What a solid of 1 N/m should do to a tool sphere, still: as deep as it is in the mesh, out along
/// the shortest way. In N for each N/m, that is in metres. Pre: tool_m is finite.
[[nodiscard]] Eigen::Vector3d exact_force_m(const mesh::MeshDistance& mesh,
                                            const Eigen::Vector3d& tool_m, double tool_radius_m);

/// Places of a tool sphere's centre, and the exact force there. In metres, body's own frame.
struct ExactForces {
  std::vector<Eigen::Vector3d> tool_m, force_m;
};

/// Of a tool pressed press_depth_m deep along each sample's normal. Pre: the samples are some of
/// reachable_samples() of that mesh at this radius and depth.
[[nodiscard]] ExactForces exact_forces(const SurfaceSamples& surface,
                                       const mesh::MeshDistance& mesh, double tool_radius_m,
                                       double press_depth_m);

/// Of a tool pressed to every one of the depths at the reachable ones of so many samples of the
/// surface. Pre: closed, with that distance; count > 0; depths > 0, less than the radius.
[[nodiscard]] ExactForces press_everywhere(const mesh::TriangleMesh& closed,
                                           const mesh::MeshDistance& distance, std::size_t count,
                                           double tool_radius_m, std::span<const double> depths_m);

/// How far a body's force is from the mesh's, in size and direction.
struct FeltError {
  double share = 1.0;            // rms of the difference over rms of the mesh's force
  double stiffness_scale = 0.0;  // of a contact, with which it is so; 0: nothing pushes back
  /// In just noticeable differences of a force.
  [[nodiscard]] double jnd() const;
};

/// At the stiffness that suits best, one for the whole body. Pre: exact not empty.
[[nodiscard]] FeltError felt_error(const ExactForces& exact, const UnitForce& force);
/// At the stiffness that the force has. Pre: exact not empty.
[[nodiscard]] FeltError unscaled_error(const ExactForces& exact, const UnitForce& force);

/// What a share of a force is below: alone, for a bare 5 is not meant as 500 %, or with its unit.
struct ShareLimits {
  double bare = 1.0, with_unit = 10.0;
};
inline constexpr ShareLimits kAnyShare{std::numeric_limits<double>::infinity(),
                                       std::numeric_limits<double>::infinity()};

/// A share of a force as scene_fit takes it, of `5%`, `0.05` or `0.7jnd`: nothing where it is none,
/// not above 0 or not below its limit.
[[nodiscard]] std::optional<double> read_force_share(std::string_view text,
                                                     const ShareLimits& limits = {});

/// What read_force_share() takes, for a refusal.
inline constexpr const char* kForceShareWords = "a share of the force, such as 5%, 0.05 or 0.7jnd";

}  // namespace stillgrid::spheres
