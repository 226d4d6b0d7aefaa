#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim_server/spheres/ball.hpp"

namespace stillgrid::bodies {

/// The interior of a soft solid: a regular lattice, of whose cells those exist that the solid
/// fills, and the nodes at their corners. Lengths in metres, the body's frame.
struct SoftLattice {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();   // lowest corner of the first cell
  Eigen::Vector3d spacing_m = Eigen::Vector3d::Zero();  // edges of a cell
  Eigen::Vector3i cells = Eigen::Vector3i::Zero();      // along x, y, z
  std::vector<std::uint8_t> is_filled;                  // of each cell, x fastest, then y
  std::vector<int> node_at;  // number of the node at each place, x fastest, or -1
  std::vector<Eigen::Vector3d> nodes_m;
};

/// A box centred at the origin, all of it filled: node x + nx (y + ny z).
/// Pre: sizes positive, at least two nodes along each axis.
[[nodiscard]] SoftLattice block_lattice(const Eigen::Vector3d& size_m,
                                        const Eigen::Vector3i& nodes);

/// A lattice centred round balls; a cell is filled if it holds a ball's centre, or if a ball
/// reaches into it by a tenth of the spacing. A gap that is narrower than a cell is bridged. Pre:
/// balls not empty, spacing_m > 0, place_count() is small.
[[nodiscard]] SoftLattice lattice_round(std::span<const spheres::Ball> balls, double spacing_m);

/// How many places for nodes that lattice has; a double, for it may exceed every integer.
[[nodiscard]] double place_count(std::span<const spheres::Ball> balls, double spacing_m);

/// A point of the solid as the weighted sum of four nodes: the corners of that of a cell's six
/// tetrahedra which holds it [Kuhn 1960]. An affine motion of the nodes moves it exactly along.
struct LatticePoint {
  std::array<int, 4> nodes{};
  std::array<double, 4> weights{};  // sum to one
};
/// Pre: the cell that holds the point, or is nearest to it, is filled.
[[nodiscard]] LatticePoint bind_to_lattice(const SoftLattice& lattice,
                                           const Eigen::Vector3d& point_m);

/// What joins two nodes: the edge of a cell; the diagonal of a face or of a cell; two edges in a
/// row.
enum class LatticeLink { kStructural, kShear, kBend };
struct LatticeSpring {
  int a = 0, b = 0;  // nodes, a < b
  LatticeLink link = LatticeLink::kStructural;

  bool operator==(const LatticeSpring&) const = default;
};
/// Every spring of the lattice once, in ascending order of its nodes.
[[nodiscard]] std::vector<LatticeSpring> lattice_springs(const SoftLattice& lattice);

}  // namespace stillgrid::bodies
