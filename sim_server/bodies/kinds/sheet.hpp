#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/packing.hpp"
#include "sim_server/bodies/kinds/springs.hpp"
#include "sim_server/bodies/surfaces.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

struct BodyDescription;

/// A cloth of masses and springs, level in its own frame and centred there.
struct SheetBody {
  Eigen::Vector2i nodes = Eigen::Vector2i::Zero();  // along x, y; numbered x fastest
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  SpherePacking spheres = {};
  ShearSprings springs = {};
};

/// Reads its keys into body.shape. Throws SceneError. Pre: body.motion is read.
void read_sheet(toml::TableReader& table, BodyDescription& body, std::vector<std::string>& notes);

[[nodiscard]] BodyCounts counts_of(const SheetBody& sheet);

/// Masses and springs, and the spheres that hang on them, of one that stands where body says.
[[nodiscard]] SpringNet net_of(const SheetBody& sheet, const BodyDescription& body);
[[nodiscard]] std::vector<SphereBinding> spheres_of(const SheetBody& sheet,
                                                    const BodyDescription& body);

[[nodiscard]] BodySurface surface_of(const SheetBody& sheet, const BodyDescription& body,
                                     const RestSpheres& spheres);

}  // namespace stillgrid::bodies
