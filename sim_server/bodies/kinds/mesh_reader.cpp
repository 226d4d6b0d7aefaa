#include <Eigen/Eigenvalues>
#include <algorithm>
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
#include "sim_server/bodies/kinds/mesh_feel.hpp"
#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/effective_stiffness.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "sim_server/spheres/sphere_cache.hpp"
#include "sim_server/spheres/sphere_file.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

constexpr double kFinestTolerance = 1e-3;  // of the longest side
constexpr std::size_t kSurfaceSamples = 2000;
constexpr double kMaxPlaces = 1e5;  // of a lattice's nodes

// Keys of `spheres`.
constexpr std::string_view kTolerance = "tolerance_m";
constexpr std::string_view kSurfaceSpacing = "surface_spacing_m";
constexpr std::string_view kVolumeSpacing = "volume_spacing_m";
constexpr std::string_view kFeel = "feel";
constexpr std::string_view kFile = "file";

mesh::TriangleMesh read_closed(toml::TableReader& table) {
  const std::filesystem::path path = table.file("file");
  const double scale = table.number_or("scale", toml::Bound::kPositive, 1.0);
  try {
    return mesh::make_closed(mesh::load_mesh(path, scale), path.string()).mesh;
  } catch (const realtime::StopRequested&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    table.refuse("file", std::string("a mesh that bounds a solid; ") + error.what());
  }
}

std::vector<spheres::Ball> decomposed(toml::TableReader& spheres, bool is_soft,
                                      const mesh::TriangleMesh& mesh, const BodyDescription& body,
                                      std::vector<std::string>& notes) {
  const double tolerance_m = spheres.number(kTolerance, toml::Bound::kPositive);
  spheres.finish();
  if (tolerance_m < kFinestTolerance * box_of(mesh).sizes().maxCoeff())
    spheres.refuse(kTolerance, "at least a thousandth of the mesh's longest side");
  const spheres::SphereCache cache(spheres.folder(), mesh, kTolerance, tolerance_m);
  try {
    std::vector<spheres::Ball> balls =
        made_or_kept(cache, body, notes, [&] { return spheres::decompose(mesh, tolerance_m); });
    if (!is_soft) note_feel(balls, mesh, tolerance_m, body, notes);
    return balls;
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

/// Even balls, by the key that gives their distance.
std::vector<spheres::Ball> sampled(toml::TableReader& spheres, std::string_view key, bool is_soft,
                                   const mesh::TriangleMesh& mesh, const BodyDescription& body,
                                   std::vector<std::string>& notes) {
  const double spacing_m = spheres.number(key, toml::Bound::kPositive);
  spheres.finish();
  const spheres::SphereCache cache(spheres.folder(), mesh,
                                   std::string(key) + (is_soft ? ", soft" : ""), spacing_m);
  try {
    return made_or_kept(cache, body, notes, [&] {
      spheres::Decomposition even;
      even.balls = even_balls(mesh, key, spacing_m, is_soft);
      return even;
    });
  } catch (const std::invalid_argument& error) {
    spheres.refuse(key, std::string("a spacing that suits the mesh; ") + error.what());
  }
}

ScaledBalls read_balls(toml::TableReader& table, bool is_soft, const mesh::TriangleMesh& mesh,
                       const BodyDescription& body, std::vector<std::string>& notes) {
  toml::TableReader spheres = table.table("spheres");
  std::string_view chosen = kTolerance;
  bool is_chosen = false;
  for (const std::string_view key : {kFile, kFeel, kSurfaceSpacing, kVolumeSpacing, kTolerance}) {
    if (!spheres.has(key)) continue;
    if (is_chosen)
      spheres.refuse(key, "one of tolerance_m, surface_spacing_m, volume_spacing_m, feel and file");
    chosen = key;
    is_chosen = true;
  }
  if (chosen == kFile) return {from_file(spheres, mesh)};
  if (chosen == kFeel) return read_felt_balls(spheres, is_soft, mesh, body, notes);
  if (chosen == kTolerance) return {decomposed(spheres, is_soft, mesh, body, notes)};
  return {sampled(spheres, chosen, is_soft, mesh, body, notes)};
}

double read_stiffness_scale(toml::TableReader& table, const mesh::TriangleMesh& mesh,
                            const ScaledBalls& made) {
  if (!table.has("normalise")) return made.stiffness_scale;
  toml::TableReader normalise = table.table("normalise");
  const double tool_radius_m = normalise.number("tool_radius_m", toml::Bound::kPositive);
  const double press_depth_m = normalise.number("press_depth_m", toml::Bound::kPositive);
  normalise.finish();
  try {
    return spheres::stiffness_scale(made.balls, spheres::sample_surface(mesh, kSurfaceSamples),
                                    tool_radius_m, press_depth_m);
  } catch (const realtime::StopRequested&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    normalise.refuse("press_depth_m", std::string("a depth with a force; ") + error.what());
  }
}

/// Moves the body's frame into its centre of mass, along its principal axes.
RigidMeshBody in_principal_frame(std::vector<spheres::Ball> balls, const mesh::TriangleMesh& mesh,
                                 const std::optional<AskedField>& field, BodyDescription& body) {
  const mesh::MassProperties mass = mesh::mass_properties(mesh);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(mass.inverse_inertia_per_kg_m2);
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  RigidMeshBody rigid{.balls = std::move(balls), .surface = mesh, .asked_field = field};
  rigid.inverse_inertia_per_kg_m2 = solver.eigenvalues();
  const auto moved = [&](const Eigen::Vector3d& point_m) -> Eigen::Vector3d {
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
                        const mesh::TriangleMesh& mesh, const BodyDescription& body) {
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
  return soft;
}

}  // namespace

void read_mesh(toml::TableReader& table, BodyDescription& body, std::vector<std::string>& notes) {
  const bool is_soft = table.has("spring_stiffness_N_per_m");
  body.position_m = table.vector_or("position_m", body.position_m);
  body.orientation = table.orientation_or_identity("orientation_xyzw");
  const mesh::TriangleMesh mesh = read_closed(table);
  const std::optional<AskedField> field = read_contact(table, mesh, is_soft, body.motion);
  ScaledBalls made;
  // A choice may be among these and fields.
  if (!field || table.has("spheres")) made = read_balls(table, is_soft, mesh, body, notes);
  body.stiffness_scale = read_stiffness_scale(table, mesh, made);
  if (is_soft)
    body.shape = on_lattice(table, std::move(made.balls), mesh, body);
  else
    body.shape = in_principal_frame(std::move(made.balls), mesh, field, body);
}

}  // namespace stillgrid::bodies
