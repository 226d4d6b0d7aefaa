#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/packing.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

struct BodyDescription;

/// Solid on one side of a plane through body.position_m; never moves, and has no spheres.
struct PlaneBody {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, out of the solid
};

/// Reads its keys into body.shape. Throws SceneError. Pre: body.motion is read.
void read_plane(toml::TableReader& table, BodyDescription& body, std::vector<std::string>& notes);

[[nodiscard]] BodyCounts counts_of(const PlaneBody& plane);

}  // namespace stillgrid::bodies
