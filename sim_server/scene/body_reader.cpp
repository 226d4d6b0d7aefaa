#include "sim_server/scene/body_reader.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sim_server/scene/mesh_reader.hpp"

namespace stillgrid {
namespace {

constexpr int kMostNodesPerSide = 1000;
constexpr double kMostNodesOfBlock = 1e5;
constexpr double kMostSpheresPerSide = 1000.0;
constexpr double kMostStiffnessScale = 1e6;  // so that a stiffness stays a float's

constexpr std::array<std::string_view, 7> kKinds = {"sheet", "thread", "soft_block", "rigid_box",
                                                    "mesh",  "sphere", "plane"};
constexpr std::array kKindOf = {BodyKind::kSheet,    BodyKind::kThread, BodyKind::kSoftBlock,
                                BodyKind::kRigidBox, BodyKind::kMesh,   BodyKind::kSphere,
                                BodyKind::kPlane};

constexpr std::array<std::string_view, 4> kThreadPins = {"none", "start", "end", "both"};
constexpr std::array<std::string_view, 5> kSheetPins = {"none", "corners", "two_corners", "edges",
                                                        "top"};

int read_material(TableReader& table, std::span<const MaterialDescription> materials) {
  std::vector<std::string_view> names;
  for (const MaterialDescription& material : materials) names.push_back(material.name);
  if (names.empty()) table.refuse("material", "a [[material]] of the scene, which has none");
  return static_cast<int>(table.choice("material", names));
}

/// Whether the body is made of masses and springs; a mesh is if it has springs.
bool has_springs(TableReader& table, BodyKind kind) {
  if (kind == BodyKind::kMesh) return table.has("spring_stiffness_N_m");
  return kind == BodyKind::kSheet || kind == BodyKind::kThread || kind == BodyKind::kSoftBlock;
}

Motion read_motion(TableReader& table, BodyKind kind) {
  if (kind == BodyKind::kPlane) {
    constexpr std::array<std::string_view, 1> only_static = {"static"};
    if (table.has("motion")) (void)table.choice("motion", only_static);
    return Motion::kStatic;
  }
  if (!table.has("motion")) return Motion::kFree;
  constexpr std::array<std::string_view, 3> names = {"free", "static", "prescribed"};
  constexpr std::array motions = {Motion::kFree, Motion::kStatic, Motion::kPrescribed};
  // What deforms cannot be told where all of its nodes are by one direction.
  const std::size_t count = has_springs(table, kind) ? 2 : 3;
  return motions[table.choice("motion", std::span(names).first(count))];
}

PrescribedMotion read_prescribed(TableReader& table) {
  PrescribedMotion motion;
  if (table.has("direction")) motion.direction = table.direction("direction");
  const bool is_sine = table.has("amplitude_m") || table.has("frequency_hz");
  if (is_sine && table.has("velocity_m_s")) {
    table.refuse("velocity_m_s", "either velocity_m_s, or amplitude_m with frequency_hz");
  }
  if (is_sine) {
    motion.amplitude_m = table.number("amplitude_m", Bound::kPositive);
    motion.frequency_hz = table.number("frequency_hz", Bound::kPositive);
  } else {
    motion.velocity_m_s = table.number("velocity_m_s", Bound::kAny);
  }
  return motion;
}

void read_dynamics(TableReader& table, BodyDescription& body) {
  if (body.kind == BodyKind::kPlane) return;
  if (body.motion == Motion::kFree || table.has("mass_kg")) {
    body.mass_kg = table.number("mass_kg", Bound::kPositive);
  }
  if (body.motion == Motion::kPrescribed) body.prescribed = read_prescribed(table);
  if (body.motion != Motion::kFree) return;
  body.velocity_m_s = table.vector_or("velocity_m_s", body.velocity_m_s);
  body.angular_velocity_rad_s =
      table.vector_or("angular_velocity_rad_s", body.angular_velocity_rad_s);
}

void read_springs(TableReader& table, BodyDescription& body) {
  TableReader stiffness = table.table("spring_stiffness_N_m");
  if (body.motion == Motion::kFree || stiffness.has("structural")) {
    body.structural_stiffness_N_m = stiffness.number("structural", Bound::kPositive);
  }
  if (body.kind != BodyKind::kThread) {
    body.shear_stiffness_N_m = stiffness.number_or("shear", Bound::kNotNegative, 0.0);
  }
  body.bend_stiffness_N_m = stiffness.number_or("bend", Bound::kNotNegative, 0.0);
  stiffness.finish();
  body.spring_damping_N_s_m = table.number_or("spring_damping_N_s_m", Bound::kNotNegative, 0.0);
}

template <typename IsPinned>
std::vector<int> nodes_where(const Eigen::Vector3i& nodes, IsPinned is_pinned) {
  std::vector<int> pinned;
  for (int y = 0; y < nodes.y(); ++y) {
    for (int x = 0; x < nodes.x(); ++x) {
      if (is_pinned(x, y)) pinned.push_back(x + nodes.x() * y);
    }
  }
  return pinned;
}

std::vector<int> read_pinned_sheet_nodes(TableReader& table, const Eigen::Vector3i& nodes) {
  const std::string_view where = kSheetPins[table.choice("pinned", kSheetPins)];
  return nodes_where(nodes, [&](int x, int y) {
    const bool is_top = y == nodes.y() - 1;
    const bool is_x_end = x == 0 || x == nodes.x() - 1;
    const bool is_y_end = y == 0 || is_top;
    return (where == "corners" && is_x_end && is_y_end) ||
           (where == "two_corners" && is_x_end && is_top) ||
           (where == "edges" && (is_x_end || is_y_end)) || (where == "top" && is_top);
  });
}

std::vector<int> read_pinned_thread_nodes(TableReader& table, const Eigen::Vector3i& nodes) {
  const std::string_view where = kThreadPins[table.choice("pinned", kThreadPins)];
  return nodes_where(nodes, [&](int x, int /*y*/) {
    return (x == 0 && (where == "start" || where == "both")) ||
           (x == nodes.x() - 1 && (where == "end" || where == "both"));
  });
}

/// The nodes of a soft solid that lie within a box of the scene.
std::vector<int> read_pinned_box(TableReader& table, const BodyDescription& body) {
  TableReader box = table.table("pinned");
  const Eigen::Vector3d low_m = box.vector("low_m"), high_m = box.vector("high_m");
  box.finish();
  std::vector<int> pinned;
  for (std::size_t i = 0; i < body.lattice.nodes_m.size(); ++i) {
    const Eigen::Array3d at_m = body.position_m + body.orientation * body.lattice.nodes_m[i];
    if ((at_m >= low_m.array()).all() && (at_m <= high_m.array()).all())
      pinned.push_back(static_cast<int>(i));
  }
  if (pinned.empty()) table.refuse("pinned", "a box with a node of the body in it");
  return pinned;
}

std::vector<int> read_pinned_nodes(TableReader& table, const BodyDescription& body) {
  if (!table.has("pinned")) return {};
  const bool is_solid = !body.lattice.nodes_m.empty();
  if (table.has_text("pinned")) {
    if (is_solid) {
      constexpr std::array<std::string_view, 1> none = {"none"};
      (void)table.choice("pinned", none);
      return {};
    }
    return body.kind == BodyKind::kSheet ? read_pinned_sheet_nodes(table, body.nodes)
                                         : read_pinned_thread_nodes(table, body.nodes);
  }
  if (is_solid && table.has_table("pinned")) return read_pinned_box(table, body);
  const int nodes = is_solid ? static_cast<int>(body.lattice.nodes_m.size()) : body.nodes.prod();
  std::vector<int> pinned = table.integers("pinned", {0, nodes - 1});
  std::sort(pinned.begin(), pinned.end());
  pinned.erase(std::unique(pinned.begin(), pinned.end()), pinned.end());
  return pinned;
}

/// Pre: longest_side_m is the body's.
SpherePacking read_packing(TableReader& table, double longest_side_m) {
  SpherePacking packing;
  TableReader spheres = table.table("spheres");
  packing.spacing_m =
      spheres.has("spacing_m") ? spheres.number("spacing_m", Bound::kPositive) : 0.0;
  packing.radius_m = spheres.has("radius_m") ? spheres.number("radius_m", Bound::kPositive) : 0.0;
  spheres.finish();
  if (packing.spacing_m > 0.0 && longest_side_m > kMostSpheresPerSide * packing.spacing_m) {
    spheres.refuse("spacing_m", "at least a thousandth of the body's longest side");
  }
  if (packing.spacing_m > longest_side_m)
    spheres.refuse("spacing_m", "at most the body's longest side");
  if (packing.radius_m > longest_side_m)
    spheres.refuse("radius_m", "at most the body's longest side");
  return packing;
}

void read_sheet(TableReader& table, BodyDescription& body) {
  const std::vector<int> nodes = table.integers("nodes", {2, kMostNodesPerSide});
  if (nodes.size() != 2) table.refuse("nodes", "two integers, along x and along y");
  body.nodes = Eigen::Vector3i(nodes[0], nodes[1], 1);
  const std::vector<double> size_m = table.numbers("size_m", 2, Bound::kPositive);
  body.size_m = Eigen::Vector3d(size_m[0], size_m[1], 0.0);
  body.position_m = table.vector_or("position_m", body.position_m);
  body.orientation = table.orientation_or_identity("orientation_xyzw");
  body.spheres = read_packing(table, body.size_m.maxCoeff());
  read_springs(table, body);
  body.pinned_nodes = read_pinned_nodes(table, body);
}

void read_thread(TableReader& table, BodyDescription& body) {
  body.nodes = Eigen::Vector3i(table.integer("nodes", {2, kMostNodesPerSide}), 1, 1);
  body.from_m = table.vector("from_m");
  body.to_m = table.vector("to_m");
  const double length_m = (body.to_m - body.from_m).norm();
  if (length_m < 1e-9) table.refuse("to_m", "another point than from_m");
  body.position_m = 0.5 * (body.from_m + body.to_m);
  body.spheres = read_packing(table, length_m);
  read_springs(table, body);
  body.pinned_nodes = read_pinned_nodes(table, body);
}

/// What a box has whether it is rigid or soft.
void read_box(TableReader& table, BodyDescription& body) {
  body.position_m = table.vector_or("position_m", body.position_m);
  body.orientation = table.orientation_or_identity("orientation_xyzw");
  body.size_m = table.vector("size_m", Bound::kPositive);
  body.spheres = read_packing(table, body.size_m.maxCoeff());
  if (2.0 * body.spheres.radius_m > body.size_m.minCoeff()) {
    table.table("spheres").refuse("radius_m", "at most half of the box's shortest side");
  }
}

void read_soft_block(TableReader& table, BodyDescription& body) {
  const std::vector<int> nodes = table.integers("nodes", {2, kMostNodesPerSide});
  if (nodes.size() != 3) table.refuse("nodes", "three integers, along x, along y and along z");
  body.nodes = Eigen::Vector3i(nodes[0], nodes[1], nodes[2]);
  if (body.nodes.cast<double>().prod() > kMostNodesOfBlock)
    table.refuse("nodes", "at most 100000 nodes");
  read_box(table, body);
  body.lattice = block_lattice(body.size_m, body.nodes);
  read_springs(table, body);
  body.pinned_nodes = read_pinned_nodes(table, body);
}

/// How much stiffer a body's contacts are than its material, beyond what `normalise` found.
void read_stiffness_scale(TableReader& table, BodyDescription& body) {
  if (body.kind == BodyKind::kPlane || !table.has("stiffness_scale")) return;
  const double scale = table.number("stiffness_scale", Bound::kPositive);
  if (scale < 1.0 / kMostStiffnessScale || scale > kMostStiffnessScale)
    table.refuse("stiffness_scale", "a number from 1e-6 to 1e6");
  body.stiffness_scale *= scale;
}

void read_geometry(TableReader& table, BodyDescription& body, std::vector<std::string>& notes) {
  switch (body.kind) {
    case BodyKind::kSheet:
      return read_sheet(table, body);
    case BodyKind::kThread:
      return read_thread(table, body);
    case BodyKind::kRigidBox:
      return read_box(table, body);
    case BodyKind::kSoftBlock:
      return read_soft_block(table, body);
    case BodyKind::kMesh: {
      const bool is_soft = has_springs(table, body.kind);
      read_mesh(table, is_soft, body, notes);
      if (!is_soft) return;
      read_springs(table, body);
      body.pinned_nodes = read_pinned_nodes(table, body);
      return;
    }
    case BodyKind::kSphere:
      body.position_m = table.vector_or("position_m", body.position_m);
      body.radius_m = table.number("radius_m", Bound::kPositive);
      return;
    case BodyKind::kPlane:
      body.position_m = table.vector_or("point_m", body.position_m);
      body.normal = table.direction("normal");
      return;
  }
}

}  // namespace

BodyDescription read_body(TableReader& table, std::span<const MaterialDescription> materials,
                          std::vector<std::string>& notes) {
  BodyDescription body;
  body.line = table.line();
  body.name = table.name("name");
  body.kind = kKindOf[table.choice("kind", kKinds)];
  body.material = read_material(table, materials);
  body.motion = read_motion(table, body.kind);
  read_dynamics(table, body);
  read_geometry(table, body, notes);
  read_stiffness_scale(table, body);
  table.finish();
  return body;
}

}  // namespace stillgrid
