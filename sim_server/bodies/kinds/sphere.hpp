#pragma once

#include <string>
#include <vector>

#include "sim_server/bodies/kinds/packing.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

struct BodyDescription;

/// A solid ball round its frame's origin.
struct SphereBody {
  double radius_m = 0.0;
};

/// Reads its keys into body.shape. Throws SceneError. Pre: body.motion is read.
void read_sphere(toml::TableReader& table, BodyDescription& body, std::vector<std::string>& notes);

[[nodiscard]] BodyCounts counts_of(const SphereBody& sphere);

/// As a rigid body of that mass, and the spheres fixed in it, of one that stands where body says.
[[nodiscard]] RigidShape rigid_shape(const SphereBody& sphere, double mass_kg);
[[nodiscard]] std::vector<SphereBinding> spheres_of(const SphereBody& sphere,
                                                    const BodyDescription& body);

}  // namespace stillgrid::bodies
