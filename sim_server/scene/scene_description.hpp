#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "sim_server/bodies/soft_lattice.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/scene/method.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid {

/// What bodies touch with. The stiffness is that of a contact between two spheres of the
/// material.
struct MaterialDescription {
  std::string name;
  double contact_stiffness_N_m = 0.0;
  double contact_damping_N_s_m = 0.0;  // acts while spheres approach
  double friction = 0.0;               // Coulomb's coefficient
  double slip_speed_m_s = 1e-3;        // below it friction is viscous (regularised)
};

enum class BodyKind { kSheet, kThread, kSoftBlock, kRigidBox, kMesh, kSphere, kPlane };
enum class Motion { kFree, kStatic, kPrescribed };

/// Motion known in advance, along one direction: either steady, or a sine that starts at
/// rest position.
struct PrescribedMotion {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit
  double velocity_m_s = 0.0;                             // steady motion
  double amplitude_m = 0.0;                              // sine
  double frequency_hz = 0.0;
};

/// Spheres that cover a body: a distance between centres and a radius; zero means "chosen
/// for the body".
///
/// Centres are evenly spaced, the first and the last at the ends, so the spacing is met only
/// nearly. A sheet has round(length / spacing) + 1 of them along each side, a thread as many
/// along its length. A box, rigid or soft, is filled, with round((side - 2 radius) / spacing)
/// + 1 along each side, and its outer spheres touch the faces; along a side with one sphere it
/// is in the middle.
struct SpherePacking {
  double spacing_m = 0.0;
  double radius_m = 0.0;
};

/// One [[body]] of a scene file. Which geometry fields count depends on the kind.
struct BodyDescription {
  std::string name;
  unsigned line = 0;  // of the scene file, where it begins
  BodyKind kind = BodyKind::kSphere;
  Motion motion = Motion::kFree;
  PrescribedMotion prescribed;
  int material = 0;      // index into SceneDescription::materials
  double mass_kg = 0.0;  // of the whole body; a free body has one
  SpherePacking spheres;

  // Centre; plane: a point on it; soft mesh: its file's origin. A rigid mesh has its body's frame
  // in its centre of mass along its principal axes, whatever frame its file has.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();

  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // plane, unit
  double radius_m = 0.0;                              // sphere
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();   // boxes; sheet: x, y
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();   // thread
  Eigen::Vector3d to_m = Eigen::Vector3d::Zero();     // thread
  Eigen::Vector3i nodes = Eigen::Vector3i::Zero();    // block; sheet: nx, ny, 1; thread: n, 1, 1

  // Meshes, in the body's frame.
  std::vector<Ball> balls;
  Eigen::Vector3d inertia_per_kg_m2 = Eigen::Vector3d::Zero();  // principal, of a rigid one
  TriangleMesh surface;                                         // closed; for a display
  double stiffness_scale = 1.0;  // of its contacts, stiffness and damping, against its material's

  // Soft solids; a body without is rigid, a sheet or a thread.
  SoftLattice lattice;

  // Whatever deforms.
  double structural_stiffness_N_m = 0.0;
  double shear_stiffness_N_m = 0.0;
  double bend_stiffness_N_m = 0.0;
  double spring_damping_N_s_m = 0.0;  // along each spring
  std::vector<int> pinned_nodes;      // ascending, without repeats; node x + nx (y + ny z)
};

/// Whether a body is made of masses and springs.
[[nodiscard]] inline bool is_deformable(const BodyDescription& body) {
  return body.kind == BodyKind::kSheet || body.kind == BodyKind::kThread ||
         !body.lattice.nodes_m.empty();
}

/// A sphere of the tool, in the tool's frame.
struct ToolSphere {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};

/// Where the device stands in the scene: scene point = position + scale * (orientation *
/// device point). Forces go back rotated, not scaled.
struct DeviceFrame {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  double scale = 1.0;
};

/// A scene file, checked: every number is finite, every reference resolves, every default
/// is filled in.
struct SceneDescription {
  std::string name;  // of the file, without folder and extension
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d(0.0, 0.0, -9.81);
  double period_s = 0.01;  // of the simulation
  Method method;
  bool choose_method = false;    // solver = "auto": method is to be chosen by choose_method()
  double error_target_m = 1e-3;  // of positions, rms: what a method chosen so may err
  bool sleeping = true;          // bodies at rest leave the work until something touches them
  double voxel_ratio = 0.0;      // voxel edge over twice a level's longest reach; 0: chosen
  std::vector<MaterialDescription> materials;
  std::vector<BodyDescription> bodies;
  std::vector<ToolSphere> tool;
  double tool_slip_speed_m_s = 0.05;  // least slip speed of a contact with the tool
  DeviceFrame device;
  std::vector<std::string> notes;  // for the log: what was made of each mesh, a line each
};

}  // namespace stillgrid
