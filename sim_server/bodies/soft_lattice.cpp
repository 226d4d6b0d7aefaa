#include "sim_server/bodies/soft_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

namespace stillgrid::bodies {
namespace {

/// A ball that reaches less than this part of the spacing into a cell does not fill it.
constexpr double kLeastRadius = 0.1;

std::size_t place(const Eigen::Vector3i& counts, int x, int y, int z) {
  return static_cast<std::size_t>(x) +
         static_cast<std::size_t>(counts.x()) *
             (static_cast<std::size_t>(y) +
              static_cast<std::size_t>(counts.y()) * static_cast<std::size_t>(z));
}
std::size_t place(const Eigen::Vector3i& counts, const Eigen::Vector3i& at) {
  return place(counts, at.x(), at.y(), at.z());
}

template <class Visit>
void for_each_place(const Eigen::Vector3i& low, const Eigen::Vector3i& high, Visit visit) {
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) visit(Eigen::Vector3i(x, y, z));
}

Eigen::Vector3i corner(int bits) {
  return {bits & 1, (bits >> 1) & 1, (bits >> 2) & 1};
}

/// The cell that holds a point, or the nearest.
Eigen::Vector3i cell_of(const SoftLattice& lattice, const Eigen::Vector3d& point_m) {
  const Eigen::Array3d at = (point_m - lattice.origin_m).array() / lattice.spacing_m.array();
  return at.floor().max(0.0).min((lattice.cells.array() - 1).cast<double>()).cast<int>();
}

/// Gives the corners of filled cells their numbers and positions.
void number_nodes(SoftLattice& lattice) {
  const Eigen::Vector3i places = lattice.cells.array() + 1;
  lattice.node_at.assign(static_cast<std::size_t>(places.prod()), -1);
  for_each_place(Eigen::Vector3i::Zero(), lattice.cells.array() - 1,
                 [&](const Eigen::Vector3i& cell) {
                   if (lattice.is_filled[place(lattice.cells, cell)] == 0) return;
                   for (int i = 0; i < 8; ++i) lattice.node_at[place(places, cell + corner(i))] = 0;
                 });
  for_each_place(Eigen::Vector3i::Zero(), lattice.cells, [&](const Eigen::Vector3i& at) {
    int& node = lattice.node_at[place(places, at)];
    if (node < 0) return;
    node = static_cast<int>(lattice.nodes_m.size());
    lattice.nodes_m.emplace_back(lattice.origin_m +
                                 at.cast<double>().cwiseProduct(lattice.spacing_m));
  });
}

struct Extent {
  Eigen::Vector3d low_m, high_m;
};

Extent extent_of(std::span<const spheres::Ball> balls) {
  Extent extent{balls[0].centre_m, balls[0].centre_m};
  for (const spheres::Ball& ball : balls) {
    extent.low_m = extent.low_m.cwiseMin((ball.centre_m.array() - ball.radius_m).matrix());
    extent.high_m = extent.high_m.cwiseMax((ball.centre_m.array() + ball.radius_m).matrix());
  }
  return extent;
}

/// Cells along each axis; doubles, for there may be too many.
Eigen::Array3d cell_counts(const Extent& extent, double spacing_m) {
  return ((extent.high_m - extent.low_m).array() / spacing_m - 1e-9).ceil().max(1.0);
}

void fill_cells(SoftLattice& lattice, const spheres::Ball& ball) {
  const double search_radius_m = ball.radius_m - kLeastRadius * lattice.spacing_m.x();
  const Eigen::Vector3i holding = cell_of(lattice, ball.centre_m);
  lattice.is_filled[place(lattice.cells, holding)] = 1;
  if (search_radius_m <= 0.0) return;
  const Eigen::Vector3d reach(search_radius_m, search_radius_m, search_radius_m);
  for_each_place(
      cell_of(lattice, ball.centre_m - reach), cell_of(lattice, ball.centre_m + reach),
      [&](const Eigen::Vector3i& cell) {
        const Eigen::Vector3d low_m =
            lattice.origin_m + cell.cast<double>().cwiseProduct(lattice.spacing_m);
        const Eigen::Vector3d nearest_m =
            ball.centre_m.cwiseMax(low_m).cwiseMin(low_m + lattice.spacing_m);
        if ((nearest_m - ball.centre_m).squaredNorm() < search_radius_m * search_radius_m)
          lattice.is_filled[place(lattice.cells, cell)] = 1;
      });
}

/// Edges in a row: the nodes on either side of a node, if an edge leads to each.
void add_bends(const SoftLattice& lattice, std::vector<LatticeSpring>& springs) {
  const Eigen::Vector3i places = lattice.cells.array() + 1;
  const std::size_t edges = springs.size();
  const auto is_edge = [&, edges](int a, int b) {
    const LatticeSpring edge{a, b, LatticeLink::kStructural};
    const auto end = springs.begin() + static_cast<std::ptrdiff_t>(edges);
    const auto found = std::lower_bound(
        springs.begin(), end, edge,
        [](const auto& x, const auto& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); });
    return found != end && *found == edge;
  };
  std::vector<LatticeSpring> bends;
  for_each_place(Eigen::Vector3i::Zero(), lattice.cells, [&](const Eigen::Vector3i& at) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3i step = Eigen::Vector3i::Unit(axis);
      if (at[axis] + 2 > lattice.cells[axis]) continue;
      const int a = lattice.node_at[place(places, at)];
      const int middle = lattice.node_at[place(places, at + step)];
      const int b = lattice.node_at[place(places, at + 2 * step)];
      if (a >= 0 && middle >= 0 && b >= 0 && is_edge(a, middle) && is_edge(middle, b))
        bends.push_back({a, b, LatticeLink::kBend});
    }
  });
  springs.insert(springs.end(), bends.begin(), bends.end());
}

void sort_springs(std::vector<LatticeSpring>& springs) {
  std::sort(springs.begin(), springs.end(), [](const auto& x, const auto& y) {
    return std::tie(x.a, x.b, x.link) < std::tie(y.a, y.b, y.link);
  });
}

}  // namespace

SoftLattice block_lattice(const Eigen::Vector3d& size_m, const Eigen::Vector3i& nodes) {
  SoftLattice lattice;
  lattice.cells = nodes.array() - 1;
  lattice.origin_m = -0.5 * size_m;
  lattice.spacing_m = size_m.cwiseQuotient(lattice.cells.cast<double>());
  lattice.is_filled.assign(static_cast<std::size_t>(lattice.cells.prod()), 1);
  number_nodes(lattice);
  return lattice;
}

SoftLattice lattice_round(std::span<const spheres::Ball> balls, double spacing_m) {
  const Extent extent = extent_of(balls);
  SoftLattice lattice;
  lattice.cells = cell_counts(extent, spacing_m).cast<int>();
  lattice.spacing_m.setConstant(spacing_m);
  lattice.origin_m =
      0.5 * (extent.low_m + extent.high_m - spacing_m * lattice.cells.cast<double>());
  lattice.is_filled.assign(static_cast<std::size_t>(lattice.cells.prod()), 0);
  for (const spheres::Ball& ball : balls) fill_cells(lattice, ball);
  number_nodes(lattice);
  return lattice;
}

double place_count(std::span<const spheres::Ball> balls, double spacing_m) {
  return (cell_counts(extent_of(balls), spacing_m) + 1.0).prod();
}

LatticePoint bind_to_lattice(const SoftLattice& lattice, const Eigen::Vector3d& point_m) {
  const Eigen::Vector3i places = lattice.cells.array() + 1;
  const Eigen::Vector3i cell = cell_of(lattice, point_m);
  const Eigen::Array3d share = (point_m - lattice.origin_m).array() / lattice.spacing_m.array() -
                               cell.array().cast<double>();
  // From the lowest corner to the highest along the axes in order of falling share.
  std::array<int, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return share[a] > share[b]; });
  LatticePoint result;
  Eigen::Vector3i at = cell;
  double left = 1.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double next = i < 3 ? share[axes[i]] : 0.0;
    result.nodes[i] = lattice.node_at[place(places, at)];
    result.weights[i] = left - next;
    left = next;
    if (i < 3) ++at[axes[i]];
  }
  return result;
}

std::vector<LatticeSpring> lattice_springs(const SoftLattice& lattice) {
  const Eigen::Vector3i places = lattice.cells.array() + 1;
  std::vector<LatticeSpring> springs;
  for_each_place(
      Eigen::Vector3i::Zero(), lattice.cells.array() - 1, [&](const Eigen::Vector3i& cell) {
        if (lattice.is_filled[place(lattice.cells, cell)] == 0) return;
        for (int i = 0; i < 8; ++i)
          for (int j = i + 1; j < 8; ++j) {
            const int axes = (corner(i) - corner(j)).cwiseAbs().sum();
            const int a = lattice.node_at[place(places, cell + corner(i))];
            const int b = lattice.node_at[place(places, cell + corner(j))];
            springs.push_back({std::min(a, b), std::max(a, b),
                               axes == 1 ? LatticeLink::kStructural : LatticeLink::kShear});
          }
      });
  sort_springs(springs);
  springs.erase(std::unique(springs.begin(), springs.end()), springs.end());
  add_bends(lattice, springs);
  sort_springs(springs);
  return springs;
}

}  // namespace stillgrid::bodies
