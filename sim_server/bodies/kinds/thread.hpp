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

/// Masses and springs in a row, straight at rest.
struct ThreadBody {
  int nodes = 0;
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();  // world frame
  Eigen::Vector3d to_m = Eigen::Vector3d::Zero();
  SpherePacking spheres = {};
  SpringDescription springs = {};
};

/// Reads its keys into body.shape. Throws SceneError. Pre: body.motion is read.
void read_thread(toml::TableReader& table, BodyDescription& body, std::vector<std::string>& notes);

[[nodiscard]] BodyCounts counts_of(const ThreadBody& thread);

/// Masses and springs, and the spheres that hang on them, of one that stands where body says.
[[nodiscard]] SpringNet net_of(const ThreadBody& thread, const BodyDescription& body);
[[nodiscard]] std::vector<SphereBinding> spheres_of(const ThreadBody& thread,
                                                    const BodyDescription& body);

[[nodiscard]] BodySurface surface_of(const ThreadBody& thread, const BodyDescription& body,
                                     const RestSpheres& spheres);

}  // namespace stillgrid::bodies
