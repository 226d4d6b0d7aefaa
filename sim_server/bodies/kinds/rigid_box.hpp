#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/packing.hpp"
#include "sim_server/bodies/surfaces.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

struct BodyDescription;

/// A box that keeps its shape, centred in its frame, covered by spheres.
struct RigidBoxBody {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  SpherePacking spheres = {};
};

/// Reads its keys into body.shape: a CompoundBody of one exact box unless the table has `spheres`.
/// Throws SceneError. Pre: body.motion is read.
void read_rigid_box(toml::TableReader& table, BodyDescription& body,
                    std::vector<std::string>& notes);

[[nodiscard]] BodyCounts counts_of(const RigidBoxBody& box);

/// As a rigid body of that mass, and the spheres fixed in it, of one that stands where body says.
[[nodiscard]] RigidShape rigid_shape(const RigidBoxBody& box, double mass_kg);
[[nodiscard]] std::vector<SphereBinding> spheres_of(const RigidBoxBody& box,
                                                    const BodyDescription& body);

[[nodiscard]] BodySurface surface_of(const RigidBoxBody& box, const BodyDescription& body,
                                     const RestSpheres& spheres);

/// Reads what a box has, rigid or soft: its place, size and packing. Throws SceneError.
[[nodiscard]] RigidBoxBody read_box(toml::TableReader& table, BodyDescription& body);

}  // namespace stillgrid::bodies
