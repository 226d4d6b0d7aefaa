#include "sim_server/bodies/kinds/soft_block.hpp"

#include <cmath>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/bodies/kinds/rigid_box.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

constexpr int kMaxNodesPerSide = 1000;
constexpr double kMaxNodes = 1e5;

/// The faces between a filled cell and none.
mesh::TriangleMesh skin_of(const SoftLattice& lattice) {
  mesh::TriangleMesh skin;
  std::vector<int> vertex_at(lattice.node_at.size(), -1);
  const Eigen::Vector3i places = lattice.cells + Eigen::Vector3i::Ones();
  const auto vertex = [&](const Eigen::Vector3i& place) {
    const auto at =
        static_cast<std::size_t>(place.x() + places.x() * (place.y() + places.y() * place.z()));
    if (vertex_at[at] < 0) {
      vertex_at[at] = static_cast<int>(skin.vertices_m.size());
      skin.vertices_m.push_back(lattice.nodes_m[static_cast<std::size_t>(lattice.node_at[at])]);
    }
    return vertex_at[at];
  };
  const auto is_filled = [&](const Eigen::Vector3i& cell) {
    if ((cell.array() < 0).any() || (cell.array() >= lattice.cells.array()).any()) return false;
    const int at = cell.x() + lattice.cells.x() * (cell.y() + lattice.cells.y() * cell.z());
    return lattice.is_filled[static_cast<std::size_t>(at)] != 0;
  };
  const auto add_faces = [&](const Eigen::Vector3i& cell) {
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        const Eigen::Vector3i out = side * Eigen::Vector3i::Unit(axis);
        if (is_filled(cell + out)) continue;
        // Turned so that the second edge is counter-clockwise from the first seen from outside.
        const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + (side > 0 ? 1 : 2)) % 3);
        const Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + (side > 0 ? 2 : 1)) % 3);
        const Eigen::Vector3i corner = cell + (side > 0 ? out : Eigen::Vector3i::Zero());
        add_quad(skin, vertex(corner), vertex(corner + u), vertex(corner + u + v),
                 vertex(corner + v));
      }
  };
  for (int z = 0; z < lattice.cells.z(); ++z)
    for (int y = 0; y < lattice.cells.y(); ++y)
      for (int x = 0; x < lattice.cells.x(); ++x)
        if (is_filled({x, y, z})) add_faces({x, y, z});
  return skin;
}

}  // namespace

void read_soft_block(toml::TableReader& table, BodyDescription& body,
                     std::vector<std::string>& notes) {
  SoftBlockBody block;
  const std::vector<int> sides = table.integers("nodes", {2, kMaxNodesPerSide});
  if (sides.size() != 3) table.refuse("nodes", "three integers, along x, along y and along z");
  const Eigen::Vector3i nodes(sides[0], sides[1], sides[2]);
  if (nodes.cast<double>().prod() > kMaxNodes) table.refuse("nodes", "at most 100000 nodes");
  const RigidBoxBody box = read_box(table, body);
  block.size_m = box.size_m;
  block.spheres = box.spheres;
  block.lattice = block_lattice(block.size_m, nodes);
  read_springs(table, body.motion, block.springs);
  block.springs.pinned_nodes =
      read_pinned_in_solid(table, block.lattice, body.position_m, body.orientation);
  notes.push_back(note_of_crushing(body.name, block.lattice, block.springs));
  body.shape = std::move(block);
}

BodyCounts counts_of(const SoftBlockBody& block) {
  return counts_of_solid(ball_count_of_box(block.size_m, block.spheres), block.lattice,
                         block.springs);
}

SpringNet net_of(const SoftBlockBody& block, const BodyDescription& body) {
  return net_of_solid(block.lattice, block.springs, body.position_m, body.orientation);
}

std::vector<SphereBinding> spheres_of(const SoftBlockBody& block, const BodyDescription& body) {
  return spheres_in_solid(balls_of_box(block.size_m, block.spheres), block.lattice, block.springs,
                          body.position_m, body.orientation);
}

BodySurface surface_of(const SoftBlockBody& block, const BodyDescription& body,
                       const RestSpheres& spheres) {
  return bound_surface(skin_of(block.lattice), body.position_m, body.orientation, spheres);
}

}  // namespace stillgrid::bodies
