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

/// A box of masses and springs, centred in its frame.
struct SoftBlockBody {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  SpherePacking spheres = {};
  SoftLattice lattice = {};  // block_lattice()
  ShearSprings springs = {};
};

/// Reads its keys into body.shape. Throws SceneError. Pre: body.motion is read.
void read_soft_block(toml::TableReader& table, BodyDescription& body,
                     std::vector<std::string>& notes);

[[nodiscard]] BodyCounts counts_of(const SoftBlockBody& block);

/// Masses and springs, and the spheres that hang on them, of one that stands where body says.
[[nodiscard]] SpringNet net_of(const SoftBlockBody& block, const BodyDescription& body);
[[nodiscard]] std::vector<SphereBinding> spheres_of(const SoftBlockBody& block,
                                                    const BodyDescription& body);

[[nodiscard]] BodySurface surface_of(const SoftBlockBody& block, const BodyDescription& body,
                                     const RestSpheres& spheres);

}  // namespace stillgrid::bodies
