#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/bodies/kinds/contact_keys.hpp"
#include "sim_server/bodies/kinds/kept_spheres.hpp"
#include "sim_server/bodies/kinds/mesh.hpp"
#include "sim_server/bodies/solid_shape.hpp"
#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "sim_server/spheres/sphere_cache.hpp"
#include "sim_server/spheres/sphere_file.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

constexpr double kFinestTolerance = 1e-3;  // of the longest side
constexpr double kLeastArea = 1e-6;        // of a shell, over its diagonal squared
constexpr double kMaxPlaces = 1e5;         // of a lattice's nodes
constexpr double kOfLattice = 0.5;         // default spacing of a soft body's spheres
constexpr double kThin = 0.5;              // radius over spacing, of spheres with holes between

// Keys of `spheres`.
constexpr std::string_view kTolerance = "tolerance_m";
constexpr std::string_view kSurfaceSpacing = "surface_spacing_m";
constexpr std::string_view kVolumeSpacing = "volume_spacing_m";
constexpr std::string_view kFile = "file";

struct ReadMesh {
  mesh::TriangleMesh mesh;
  std::string no_solid;  // why it bounds none
};

void note_holes(const mesh::ClosedHoles& holes, const BodyDescription& body,
                std::vector<std::string>& notes) {
  if (holes.count == 0) return;
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "small holes closed: %d, the longest border %.3g m",
                holes.count, holes.longest_border_m);
  notes.push_back("body '" + body.name + "': " + text.data());
}

/// A solid, or what may be a shell if nothing in the scene asks for a solid.
ReadMesh read_solid_or_shell(toml::TableReader& table, bool is_soft, const BodyDescription& body,
                             std::vector<std::string>& notes) {
  const std::filesystem::path path = table.file("file");
  const double scale = table.number_or("scale", toml::Bound::kPositive, 1.0);
  try {
    mesh::TriangleMesh mesh = mesh::load_mesh(path, scale);
    try {
      mesh::ClosedMesh closed = mesh::make_closed(mesh, path.string());
      note_holes(closed.repair.holes, body, notes);
      return {std::move(closed.mesh), ""};
    } catch (const mesh::NotSolid& error) {
      const double least_m2 = kLeastArea * box_of(mesh).diagonal().squaredNorm();
      if (is_soft || table.has("spheres") || table.has("contact") || table.has("field") ||
          mesh::surface_area_m2(mesh) < least_m2)
        throw;
      return {std::move(mesh), error.what()};
    }
  } catch (const realtime::StopRequested&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    table.refuse("file", std::string("a mesh that bounds a solid; ") + error.what());
  }
}

std::vector<spheres::Ball> decomposed(toml::TableReader& spheres, const mesh::TriangleMesh& mesh,
                                      const BodyDescription& body,
                                      std::vector<std::string>& notes) {
  const double tolerance_m = spheres.number(kTolerance, toml::Bound::kPositive);
  spheres.finish();
  if (tolerance_m < kFinestTolerance * box_of(mesh).sizes().maxCoeff())
    spheres.refuse(kTolerance, "at least a thousandth of the mesh's longest side");
  const spheres::SphereCache cache(spheres.folder(), mesh, kTolerance, tolerance_m);
  try {
    return made_or_kept(cache, body, notes, [&] { return spheres::decompose(mesh, tolerance_m); });
  } catch (const realtime::StopRequested&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    spheres.refuse(kTolerance, std::string("one that spheres can hold; ") + error.what());
  }
}

std::vector<spheres::Ball> from_file(toml::TableReader& spheres, const mesh::TriangleMesh& mesh) {
  const std::filesystem::path path = spheres.file(kFile);
  spheres.finish();
  std::vector<spheres::Ball> balls;
  try {
    balls = spheres::read_spheres(path);
  } catch (const realtime::StopRequested&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    spheres.refuse(kFile, std::string("a file of sphere_decompose; ") + error.what());
  }
  const Eigen::AlignedBox3d box = box_of(mesh);
  const auto strays = std::count_if(balls.begin(), balls.end(), [&](const spheres::Ball& ball) {
    return !box.contains(ball.centre_m);
  });
  if (strays > 0)
    spheres.refuse(kFile, "spheres of this mesh at this scale; the centres of " +
                              std::to_string(strays) + " of " + std::to_string(balls.size()) +
                              " lie outside of the mesh's box");
  return balls;
}

/// Even balls: small ones, that follow a surface, of a body that deforms, else firm ones.
std::vector<spheres::Ball> even_balls(const mesh::TriangleMesh& mesh, std::string_view key,
                                      double spacing_m, bool is_soft) {
  if (key == kSurfaceSpacing)
    return is_soft ? spheres::surface_balls(mesh, spacing_m, spacing_m)
                   : spheres::firm_surface_balls(mesh, spacing_m);
  return is_soft ? spheres::volume_balls(mesh, spacing_m, spheres::kVolumeRadius * spacing_m)
                 : spheres::firm_volume_balls(mesh, spacing_m);
}

/// Even balls. A spacing that does not suit is refused as the value of `key` in `table`.
std::vector<spheres::Ball> sampled(toml::TableReader& table, std::string_view key,
                                   std::string_view way, double spacing_m, bool is_soft,
                                   const mesh::TriangleMesh& mesh, const BodyDescription& body,
                                   std::vector<std::string>& notes) {
  const spheres::SphereCache cache(table.folder(), mesh,
                                   std::string(way) + (is_soft ? ", soft" : ""), spacing_m);
  try {
    return made_or_kept(cache, body, notes, [&] {
      spheres::Decomposition even;
      even.balls = even_balls(mesh, way, spacing_m, is_soft);
      return even;
    });
  } catch (const std::invalid_argument& error) {
    table.refuse(key, std::string("a spacing that suits the mesh; ") + error.what());
  }
}

std::vector<spheres::Ball> read_balls(toml::TableReader& table, bool is_soft,
                                      const mesh::TriangleMesh& mesh, const BodyDescription& body,
                                      std::vector<std::string>& notes) {
  if (is_soft && !table.has("spheres")) {
    const double spacing_m = kOfLattice * table.number("lattice_m", toml::Bound::kPositive);
    std::vector<spheres::Ball> balls =
        sampled(table, "lattice_m", kSurfaceSpacing, spacing_m, true, mesh, body, notes);
    const auto middle = balls.begin() + static_cast<std::ptrdiff_t>(balls.size() / 2);
    std::ranges::nth_element(balls, middle, {}, &spheres::Ball::radius_m);
    if (middle->radius_m < kThin * spacing_m)
      table.refuse("lattice_m", "at most twice the body's thickness, or `spheres`");
    return balls;
  }
  toml::TableReader spheres = table.table("spheres");
  spheres.refuse_gone("feel", "write tolerance_m, or no `spheres` for a field");
  std::string_view chosen = kTolerance;
  bool is_chosen = false;
  for (const std::string_view key : {kFile, kSurfaceSpacing, kVolumeSpacing, kTolerance}) {
    if (!spheres.has(key)) continue;
    if (is_chosen)
      spheres.refuse(key, "one of tolerance_m, surface_spacing_m, volume_spacing_m and file");
    chosen = key;
    is_chosen = true;
  }
  if (chosen == kFile) return from_file(spheres, mesh);
  if (chosen == kTolerance) return decomposed(spheres, mesh, body, notes);
  const double spacing_m = spheres.number(chosen, toml::Bound::kPositive);
  spheres.finish();
  return sampled(spheres, chosen, chosen, spacing_m, is_soft, mesh, body, notes);
}

/// Moves the body's frame into its centre of mass, along its principal axes.
RigidMeshBody in_principal_frame(std::vector<spheres::Ball> balls, const mesh::TriangleMesh& mesh,
                                 const std::optional<AskedField>& field,
                                 const std::string& no_solid, BodyDescription& body) {
  const mesh::MassProperties mass =
      no_solid.empty() ? mesh::mass_properties(mesh) : mesh::shell_mass_properties(mesh);
  const auto [axes, moments] = principal_axes(mass.inertia_per_kg_m2);
  RigidMeshBody rigid{
      .balls = std::move(balls), .surface = mesh, .no_solid = no_solid, .asked_field = field};
  rigid.inertia_per_kg_m2 = moments;
  const auto moved = [&, &axes = axes](const Eigen::Vector3d& point_m) -> Eigen::Vector3d {
    return axes.transpose() * (point_m - mass.centre_m);
  };
  for (spheres::Ball& ball : rigid.balls) ball.centre_m = moved(ball.centre_m);
  for (Eigen::Vector3d& vertex_m : rigid.surface.vertices_m) vertex_m = moved(vertex_m);
  if (rigid.asked_field)
    for (fields::StiffnessPlace& place : rigid.asked_field->measured.places)
      place.position_m = moved(place.position_m);
  body.position_m += body.orientation * mass.centre_m;
  body.orientation = (body.orientation * Eigen::Quaterniond(axes)).normalized();
  return rigid;
}

SoftMeshBody on_lattice(toml::TableReader& table, std::vector<spheres::Ball> balls,
                        const mesh::TriangleMesh& mesh, const BodyDescription& body,
                        std::vector<std::string>& notes) {
  const double spacing_m = table.number("lattice_m", toml::Bound::kPositive);
  if (place_count(balls, spacing_m) > kMaxPlaces)
    table.refuse("lattice_m", "a lattice of at most 100000 nodes");
  SoftMeshBody soft;
  soft.lattice = lattice_round(balls, spacing_m);
  soft.balls = std::move(balls);
  soft.surface = mesh;
  read_springs(table, body.motion, soft.springs);
  soft.springs.pinned_nodes =
      read_pinned_in_solid(table, soft.lattice, body.position_m, body.orientation);
  notes.push_back(note_of_crushing(body.name, soft.lattice, soft.springs));
  return soft;
}

}  // namespace

void read_mesh(toml::TableReader& table, BodyDescription& body, std::vector<std::string>& notes) {
  const bool is_soft = table.has("spring_stiffness_N_per_m");
  body.position_m = table.vector_or("position_m", body.position_m);
  body.orientation = table.orientation_or_identity("orientation_xyzw");
  const auto& [mesh, no_solid] = read_solid_or_shell(table, is_soft, body, notes);
  std::optional<AskedField> field;
  std::vector<spheres::Ball> balls;
  if (no_solid.empty()) field = read_contact(table, mesh, is_soft, body.motion);
  if (no_solid.empty() && !field) balls = read_balls(table, is_soft, mesh, body, notes);
  if (is_soft)
    body.shape = on_lattice(table, std::move(balls), mesh, body, notes);
  else
    body.shape = in_principal_frame(std::move(balls), mesh, field, no_solid, body);
}

}  // namespace stillgrid::bodies
