#include "sim_server/bodies/kinds/sheet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

constexpr int kMaxNodesPerSide = 1000;
constexpr std::array<std::string_view, 5> kPins = {"none", "corners", "two_corners", "edges",
                                                   "top"};

std::vector<int> read_pins(toml::TableReader& table, const Eigen::Vector2i& nodes) {
  const std::string_view where = kPins[table.choice("pinned", kPins)];
  std::vector<int> pinned;
  for (int y = 0; y < nodes.y(); ++y)
    for (int x = 0; x < nodes.x(); ++x) {
      const bool is_top = y == nodes.y() - 1;
      const bool is_x_end = x == 0 || x == nodes.x() - 1;
      const bool is_y_end = y == 0 || is_top;
      if ((where == "corners" && is_x_end && is_y_end) ||
          (where == "two_corners" && is_x_end && is_top) ||
          (where == "edges" && (is_x_end || is_y_end)) || (where == "top" && is_top))
        pinned.push_back(x + nodes.x() * y);
    }
  return pinned;
}

/// As described, or a sphere a node.
SpherePacking packing_of(const SheetBody& sheet) {
  return completed(sheet.spheres, std::min(sheet.size_m.x() / (sheet.nodes.x() - 1),
                                           sheet.size_m.y() / (sheet.nodes.y() - 1)));
}

/// How many spheres there are along x and y; they are numbered x fastest.
Eigen::Vector2i spheres_along_sides(const SheetBody& sheet) {
  const double spacing_m = packing_of(sheet).spacing_m;
  return {count_along(sheet.size_m.x(), spacing_m), count_along(sheet.size_m.y(), spacing_m)};
}

}  // namespace

void read_sheet(toml::TableReader& table, BodyDescription& body,
                std::vector<std::string>& /*notes*/) {
  SheetBody sheet;
  const std::vector<int> nodes = table.integers("nodes", {2, kMaxNodesPerSide});
  if (nodes.size() != 2) table.refuse("nodes", "two integers, along x and along y");
  sheet.nodes = {nodes[0], nodes[1]};
  const std::vector<double> size_m = table.numbers("size_m", 2, toml::Bound::kPositive);
  sheet.size_m = {size_m[0], size_m[1]};
  body.position_m = table.vector_or("position_m", body.position_m);
  body.orientation = table.orientation_or_identity("orientation_xyzw");
  sheet.spheres = read_packing(table, sheet.size_m.maxCoeff());
  sheet.spheres = packing_of(sheet);
  read_springs(table, body.motion, sheet.springs);
  sheet.springs.pinned_nodes =
      read_pinned(table, sheet.nodes.prod(), [&] { return read_pins(table, sheet.nodes); });
  body.shape = std::move(sheet);
}

BodyCounts counts_of(const SheetBody& sheet) {
  const double spacing_m = packing_of(sheet).spacing_m;
  const double bend = sheet.springs.bend_stiffness_N_per_m > 0.0 ? 1.0 : 0.0;
  const double shear = sheet.springs.shear_stiffness_N_per_m > 0.0 ? 1.0 : 0.0;
  const double nodes = sheet.nodes.cast<double>().prod();
  return {.spheres = spheres_along(sheet.size_m.x(), spacing_m) *
                     spheres_along(sheet.size_m.y(), spacing_m),
          .nodes = nodes,
          .springs = nodes * (2.0 * (1.0 + shear + bend))};
}

/// Structural springs join neighbours, shear springs diagonals, bend springs every second node.
SpringNet net_of(const SheetBody& sheet, const BodyDescription& body) {
  const int nx = sheet.nodes.x(), ny = sheet.nodes.y();
  SpringNet net;
  net.sheet_nodes = sheet.nodes;
  const auto fraction = [](int i, int n) { return n > 1 ? double(i) / double(n - 1) : 0.0; };
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x) {
      const Eigen::Vector3d local((fraction(x, nx) - 0.5) * sheet.size_m.x(),
                                  (fraction(y, ny) - 0.5) * sheet.size_m.y(), 0.0);
      net.nodes_m.emplace_back(body.position_m + body.orientation * local);
    }
  const auto join = [&](int x, int y, int dx, int dy, double stiffness_N_per_m) {
    if (x + dx < 0 || x + dx >= nx || y + dy >= ny) return;
    net.links.push_back({x + nx * y, x + dx + nx * (y + dy), stiffness_N_per_m});
  };
  const ShearSprings& springs = sheet.springs;
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x) {
      join(x, y, 1, 0, springs.structural_stiffness_N_per_m);
      join(x, y, 0, 1, springs.structural_stiffness_N_per_m);
      join(x, y, 1, 1, springs.shear_stiffness_N_per_m);
      join(x, y, -1, 1, springs.shear_stiffness_N_per_m);
      join(x, y, 2, 0, springs.bend_stiffness_N_per_m);
      join(x, y, 0, 2, springs.bend_stiffness_N_per_m);
    }
  return net;
}

std::vector<SphereBinding> spheres_of(const SheetBody& sheet, const BodyDescription& body) {
  const int nx = sheet.nodes.x(), ny = sheet.nodes.y();
  const double radius_m = packing_of(sheet).radius_m;
  const Eigen::Vector2i along = spheres_along_sides(sheet);
  const int columns = along.x(), rows = along.y();
  std::vector<SphereBinding> spheres;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      SphereBinding& sphere = spheres.emplace_back();
      sphere.radius_m = radius_m;
      const auto [x, u] = among_nodes(i, columns, nx);
      const auto [y, v] = among_nodes(j, rows, ny);
      bind(sphere, x + nx * y, (1.0 - u) * (1.0 - v));
      bind(sphere, x + 1 + nx * y, u * (1.0 - v));
      bind(sphere, x + nx * (y + 1), (1.0 - u) * v);
      bind(sphere, x + 1 + nx * (y + 1), u * v);
      const Eigen::Vector3d local(spread(i, columns, -0.5, 0.5) * sheet.size_m.x(),
                                  spread(j, rows, -0.5, 0.5) * sheet.size_m.y(), 0.0);
      sphere.rest_position_m = body.position_m + body.orientation * local;
    }
  return spheres;
}

BodySurface surface_of(const SheetBody& sheet, const BodyDescription& /*body*/,
                       const RestSpheres& spheres) {
  return grid_surface(spheres, spheres_along_sides(sheet).x());
}

}  // namespace stillgrid::bodies
