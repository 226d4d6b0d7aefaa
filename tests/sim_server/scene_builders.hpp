#pragma once

#include <Eigen/Core>
#include <utility>
#include <variant>
#include <vector>

#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// Scenes in code: what a test does not set is out of the way (no gravity, no friction, no damper,
/// no sleep).
[[nodiscard]] inline scene::SceneDescription scene_of(
    std::vector<bodies::BodyDescription> bodies, const scene::MaterialDescription& material = {},
    const Eigen::Vector3d& gravity_m_s2 = Eigen::Vector3d::Zero()) {
  scene::SceneDescription scene;
  scene.gravity_m_s2 = gravity_m_s2;
  scene.materials = {material};
  scene.bodies = std::move(bodies);
  scene.sleeping = false;
  return scene;
}

[[nodiscard]] inline scene::MaterialDescription material_of(double stiffness_N_per_m,
                                                            double damping_N_s_per_m = 0,
                                                            double friction = 0,
                                                            double slip_speed_m_s = 1e-3) {
  return {"test", stiffness_N_per_m, damping_N_s_per_m, friction, slip_speed_m_s};
}

/// The springs of a body that has them, and the stiffness of their diagonals, to change.
[[nodiscard]] inline bodies::SpringDescription& springs(bodies::BodyDescription& body) {
  return const_cast<bodies::SpringDescription&>(*bodies::springs_of(body));
}
[[nodiscard]] inline double& shear_stiffness_N_per_m(bodies::BodyDescription& body) {
  double* found = nullptr;
  std::visit(
      [&](auto& shape) {
        if constexpr (requires { shape.springs.shear_stiffness_N_per_m; })
          found = &shape.springs.shear_stiffness_N_per_m;
      },
      body.shape);
  return *found;
}
/// The packing of a body that is packed, to change.
[[nodiscard]] inline bodies::SpherePacking& packing(bodies::BodyDescription& body) {
  bodies::SpherePacking* found = nullptr;
  std::visit(
      [&](auto& shape) {
        if constexpr (requires { shape.spheres; }) found = &shape.spheres;
      },
      body.shape);
  return *found;
}

/// A body of that shape and mass, where its frame's origin is.
template <class Shape>
[[nodiscard]] bodies::BodyDescription body_of(
    Shape shape, double mass_kg, const Eigen::Vector3d& position_m = Eigen::Vector3d::Zero()) {
  bodies::BodyDescription body;
  body.position_m = position_m;
  body.mass_kg = mass_kg;
  body.shape = std::move(shape);
  return body;
}

/// A thread whose nodes have each node_mass_kg, covered thinly.
[[nodiscard]] inline bodies::BodyDescription thread(int nodes, const Eigen::Vector3d& from_m,
                                                    const Eigen::Vector3d& to_m,
                                                    double node_mass_kg, double stiffness_N_per_m,
                                                    std::vector<int> pinned = {}) {
  bodies::ThreadBody thread{.nodes = nodes, .from_m = from_m, .to_m = to_m};
  thread.springs.structural_stiffness_N_per_m = stiffness_N_per_m;
  thread.springs.pinned_nodes = std::move(pinned);
  const double spacing_m = (to_m - from_m).norm() / (nodes - 1);
  thread.spheres = {spacing_m, 0.1 * spacing_m};
  return body_of(thread, node_mass_kg * nodes, 0.5 * (from_m + to_m));
}

/// A level sheet of nodes each of node_mass_kg, structural springs only.
[[nodiscard]] inline bodies::BodyDescription sheet(const Eigen::Vector2i& nodes, double spacing_m,
                                                   double node_mass_kg, double stiffness_N_per_m) {
  bodies::SheetBody sheet{.nodes = nodes,
                          .size_m = {spacing_m * (nodes.x() - 1), spacing_m * (nodes.y() - 1)}};
  sheet.springs.structural_stiffness_N_per_m = stiffness_N_per_m;
  return body_of(sheet, node_mass_kg * nodes.prod());
}

[[nodiscard]] inline bodies::BodyDescription sphere(const Eigen::Vector3d& position_m,
                                                    double radius_m, double mass_kg) {
  return body_of(bodies::SphereBody{radius_m}, mass_kg, position_m);
}

[[nodiscard]] inline bodies::BodyDescription box(const Eigen::Vector3d& position_m,
                                                 const Eigen::Vector3d& size_m, double mass_kg,
                                                 const bodies::SpherePacking& spheres) {
  return body_of(bodies::RigidBoxBody{size_m, spheres}, mass_kg, position_m);
}

/// A body of exact shapes, posed in its frame.
[[nodiscard]] inline bodies::BodyDescription compound(const Eigen::Vector3d& position_m,
                                                      std::vector<bodies::SolidShape> shapes,
                                                      double mass_kg) {
  bodies::BodyDescription body = body_of(bodies::PlaneBody{}, mass_kg, position_m);
  body.shape = bodies::compound_of(std::move(shapes), body);
  return body;
}
[[nodiscard]] inline bodies::SolidShape solid(bodies::SolidShape::Kind kind,
                                              const Eigen::Vector3d& size_m,
                                              const Eigen::Vector3d& position_m = {0, 0, 0}) {
  return {.kind = kind, .half_m = 0.5 * size_m, .position_m = position_m};
}
[[nodiscard]] inline bodies::BodyDescription exact_box(const Eigen::Vector3d& position_m,
                                                       const Eigen::Vector3d& size_m,
                                                       double mass_kg) {
  return compound(position_m, {solid(bodies::SolidShape::Kind::kBox, size_m)}, mass_kg);
}

/// Structural and shear springs.
[[nodiscard]] inline bodies::ShearSprings solid_springs(double stiffness_N_per_m) {
  bodies::ShearSprings springs;
  springs.structural_stiffness_N_per_m = stiffness_N_per_m;
  springs.shear_stiffness_N_per_m = 0.5 * stiffness_N_per_m;
  return springs;
}

/// A soft block of nodes each of node_mass_kg, structural and shear springs, centred at the origin.
[[nodiscard]] inline bodies::BodyDescription soft_block(const Eigen::Vector3i& nodes,
                                                        double spacing_m, double node_mass_kg,
                                                        double stiffness_N_per_m,
                                                        const bodies::SpherePacking& spheres) {
  bodies::SoftBlockBody block{.size_m = spacing_m * (nodes.array() - 1).cast<double>(),
                              .spheres = spheres,
                              .springs = solid_springs(stiffness_N_per_m)};
  block.lattice = bodies::block_lattice(block.size_m, nodes);
  return body_of(block, node_mass_kg * nodes.prod());
}

/// A soft solid of the shape of these balls on a lattice, springs as a soft block's.
[[nodiscard]] inline bodies::BodyDescription soft_mesh(std::vector<spheres::Ball> balls,
                                                       double lattice_m, double node_mass_kg,
                                                       double stiffness_N_per_m) {
  bodies::SoftMeshBody mesh{.balls = std::move(balls), .springs = solid_springs(stiffness_N_per_m)};
  mesh.lattice = bodies::lattice_round(mesh.balls, lattice_m);
  const double mass_kg = node_mass_kg * static_cast<double>(mesh.lattice.nodes_m.size());
  return body_of(mesh, mass_kg);
}

/// A rigid body of the shape of these balls, about their common frame.
[[nodiscard]] inline bodies::BodyDescription rigid_mesh(std::vector<spheres::Ball> balls,
                                                        const Eigen::Vector3d& inertia_per_kg_m2,
                                                        double mass_kg) {
  return body_of(bodies::RigidMeshBody{std::move(balls), {}, {}, inertia_per_kg_m2}, mass_kg);
}

/// Solid below a height.
[[nodiscard]] inline bodies::BodyDescription floor_at(double height_m) {
  bodies::BodyDescription body = body_of(bodies::PlaneBody{}, 0.0, {0.0, 0.0, height_m});
  body.motion = bodies::Motion::kStatic;
  return body;
}

[[nodiscard]] inline bodies::BodyDescription moving(bodies::BodyDescription body,
                                                    const Eigen::Vector3d& velocity_m_s,
                                                    const Eigen::Vector3d& spin_rad_s = {0, 0, 0}) {
  body.velocity_m_s = velocity_m_s;
  body.angular_velocity_rad_s = spin_rad_s;
  return body;
}

}  // namespace stillgrid::sim_server
