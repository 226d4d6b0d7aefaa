#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid {

/// Scenes in code: what a test does not set is out of the way (no gravity, no friction, no damper,
/// no sleep).
[[nodiscard]] inline SceneDescription scene_of(
    std::vector<BodyDescription> bodies, const MaterialDescription& material = {},
    const Eigen::Vector3d& gravity_m_s2 = Eigen::Vector3d::Zero()) {
  SceneDescription scene;
  scene.gravity_m_s2 = gravity_m_s2;
  scene.materials = {material};
  scene.bodies = std::move(bodies);
  scene.sleeping = false;
  return scene;
}

[[nodiscard]] inline MaterialDescription material_of(double stiffness_N_m, double damping_N_s_m = 0,
                                                     double friction = 0,
                                                     double slip_speed_m_s = 1e-3) {
  return {"test", stiffness_N_m, damping_N_s_m, friction, slip_speed_m_s};
}

/// A thread whose nodes have each node_mass_kg, covered thinly.
[[nodiscard]] inline BodyDescription thread(int nodes, const Eigen::Vector3d& from_m,
                                            const Eigen::Vector3d& to_m, double node_mass_kg,
                                            double stiffness_N_m, std::vector<int> pinned = {}) {
  BodyDescription body;
  body.kind = BodyKind::kThread;
  body.nodes = {nodes, 1, 1};
  body.from_m = from_m;
  body.to_m = to_m;
  body.position_m = 0.5 * (from_m + to_m);
  body.mass_kg = node_mass_kg * nodes;
  body.structural_stiffness_N_m = stiffness_N_m;
  body.pinned_nodes = std::move(pinned);
  body.spheres.radius_m = 0.1 * (to_m - from_m).norm() / (nodes - 1);
  return body;
}

/// A level sheet of nodes each of node_mass_kg, structural springs only.
[[nodiscard]] inline BodyDescription sheet(const Eigen::Vector2i& nodes, double spacing_m,
                                           double node_mass_kg, double stiffness_N_m) {
  BodyDescription body;
  body.kind = BodyKind::kSheet;
  body.nodes = {nodes.x(), nodes.y(), 1};
  body.size_m = {spacing_m * (nodes.x() - 1), spacing_m * (nodes.y() - 1), 0.0};
  body.mass_kg = node_mass_kg * nodes.prod();
  body.structural_stiffness_N_m = stiffness_N_m;
  return body;
}

[[nodiscard]] inline BodyDescription sphere(const Eigen::Vector3d& position_m, double radius_m,
                                            double mass_kg) {
  BodyDescription body;
  body.kind = BodyKind::kSphere;
  body.position_m = position_m;
  body.radius_m = radius_m;
  body.mass_kg = mass_kg;
  return body;
}

[[nodiscard]] inline BodyDescription box(const Eigen::Vector3d& position_m,
                                         const Eigen::Vector3d& size_m, double mass_kg,
                                         const SpherePacking& spheres) {
  BodyDescription body;
  body.kind = BodyKind::kRigidBox;
  body.position_m = position_m;
  body.size_m = size_m;
  body.mass_kg = mass_kg;
  body.spheres = spheres;
  return body;
}

/// A soft block of nodes each of node_mass_kg, structural and shear springs, centred at the origin.
[[nodiscard]] inline BodyDescription soft_block(const Eigen::Vector3i& nodes, double spacing_m,
                                                double node_mass_kg, double stiffness_N_m,
                                                const SpherePacking& spheres) {
  BodyDescription body;
  body.kind = BodyKind::kSoftBlock;
  body.nodes = nodes;
  body.size_m = spacing_m * (nodes.array() - 1).cast<double>();
  body.lattice = block_lattice(body.size_m, nodes);
  body.mass_kg = node_mass_kg * nodes.prod();
  body.structural_stiffness_N_m = stiffness_N_m;
  body.shear_stiffness_N_m = 0.5 * stiffness_N_m;
  body.spheres = spheres;
  return body;
}

/// A soft solid of the shape of these balls on a lattice, springs as a soft block's.
[[nodiscard]] inline BodyDescription soft_mesh(std::vector<Ball> balls, double lattice_m,
                                               double node_mass_kg, double stiffness_N_m) {
  BodyDescription body;
  body.kind = BodyKind::kMesh;
  body.balls = std::move(balls);
  body.lattice = lattice_round(body.balls, lattice_m);
  body.mass_kg = node_mass_kg * static_cast<double>(body.lattice.nodes_m.size());
  body.structural_stiffness_N_m = stiffness_N_m;
  body.shear_stiffness_N_m = 0.5 * stiffness_N_m;
  return body;
}

/// A rigid body of the shape of these balls, about their common frame.
[[nodiscard]] inline BodyDescription rigid_mesh(std::vector<Ball> balls,
                                                const Eigen::Vector3d& inertia_per_kg_m2,
                                                double mass_kg) {
  BodyDescription body;
  body.kind = BodyKind::kMesh;
  body.balls = std::move(balls);
  body.inertia_per_kg_m2 = inertia_per_kg_m2;
  body.mass_kg = mass_kg;
  return body;
}

/// Solid below a height.
[[nodiscard]] inline BodyDescription floor_at(double height_m) {
  BodyDescription body;
  body.kind = BodyKind::kPlane;
  body.motion = Motion::kStatic;
  body.position_m = {0.0, 0.0, height_m};
  return body;
}

[[nodiscard]] inline BodyDescription moving(BodyDescription body,
                                            const Eigen::Vector3d& velocity_m_s,
                                            const Eigen::Vector3d& spin_rad_s = {0, 0, 0}) {
  body.velocity_m_s = velocity_m_s;
  body.angular_velocity_rad_s = spin_rad_s;
  return body;
}

}  // namespace stillgrid
