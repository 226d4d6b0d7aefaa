#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/packing.hpp"
#include "sim_server/bodies/motion.hpp"
#include "sim_server/bodies/soft_lattice.hpp"
#include "sim_server/bodies/world.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

/// Springs of a body of masses: between neighbours, and between every second of them.
struct SpringDescription {
  double structural_stiffness_N_per_m = 0.0;
  double bend_stiffness_N_per_m = 0.0;
  double spring_damping_N_s_per_m = 0.0;  // along each spring
  double spring_rest_ratio = 1.0;         // lengths at rest over those at the start
  std::vector<int> pinned_nodes;          // ascending, without repeats; node x + nx (y + ny z)
};
/// The same of what has diagonals.
struct ShearSprings : SpringDescription {
  double shear_stiffness_N_per_m = 0.0;
};

/// A body as masses and springs, before it stands in a world.
struct SpringNet {
  struct Link {
    int a = 0, b = 0;  // nodes
    double stiffness_N_per_m = 0.0;
  };
  std::vector<Eigen::Vector3d> nodes_m;  // at rest, world frame
  std::vector<Link> links;
  Eigen::Vector2i sheet_nodes = Eigen::Vector2i::Zero();  // of a sheet: along x, y
};

/// Reads `spring_stiffness_N_per_m`, `spring_damping_N_s_per_m` and `spring_rest_ratio`. Throws
/// SceneError. A body that is not free need not have them.
void read_springs(toml::TableReader& table, Motion motion, SpringDescription& springs);
void read_springs(toml::TableReader& table, Motion motion, ShearSprings& springs);

/// Reads `pinned`: a name, whose nodes by_name gives, or a list of nodes. Throws SceneError.
[[nodiscard]] std::vector<int> read_pinned(toml::TableReader& table, int node_count,
                                           const std::function<std::vector<int>()>& by_name);
/// The same of a soft solid that stands there: "none", a list of nodes, or a box of the scene.
[[nodiscard]] std::vector<int> read_pinned_in_solid(toml::TableReader& table,
                                                    const SoftLattice& lattice,
                                                    const Eigen::Vector3d& position_m,
                                                    const Eigen::Quaterniond& orientation);

/// Returns a force that does not crush a lattice, N. It compresses two structural springs of the
/// shortest edge of a cell to length 0. A tool that presses harder may pass between nodes. A tool
/// that is smaller than the spacing of the spheres may do so before.
[[nodiscard]] double crushing_force_N(const SoftLattice& lattice, const ShearSprings& springs);
/// Returns a line for the log with that force.
[[nodiscard]] std::string note_of_crushing(const std::string& body, const SoftLattice& lattice,
                                           const ShearSprings& springs);

/// A soft solid that stands there, as masses and springs.
[[nodiscard]] SpringNet net_of_solid(const SoftLattice& lattice, const ShearSprings& springs,
                                     const Eigen::Vector3d& position_m,
                                     const Eigen::Quaterniond& orientation);

/// Balls of a soft solid's frame as spheres on the four nodes round each.
[[nodiscard]] std::vector<SphereBinding> spheres_in_solid(std::span<const spheres::Ball> balls,
                                                          const SoftLattice& lattice,
                                                          const ShearSprings& springs,
                                                          const Eigen::Vector3d& position_m,
                                                          const Eigen::Quaterniond& orientation);

/// Returns the numbers of nodes, springs and spheres of a soft solid.
[[nodiscard]] BodyCounts counts_of_solid(double spheres, const SoftLattice& lattice,
                                         const ShearSprings& springs);

}  // namespace stillgrid::bodies
