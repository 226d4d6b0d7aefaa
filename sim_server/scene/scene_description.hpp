#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::scene {

/// What bodies touch with. The stiffness is that of a contact between two spheres of the
/// material.
struct MaterialDescription {
  std::string name;
  double contact_stiffness_N_per_m = 0.0;
  double contact_damping_N_s_per_m = 0.0;  // acts while spheres approach
  double friction = 0.0;                   // Coulomb's coefficient
  double slip_speed_m_s = 1e-3;            // below it friction with the tool is viscous
};

/// One [[joint]]: springs, one a point, between two bodies, or a body and the world.
struct JointDescription {
  std::string name;
  int body_a = 0, body_b = -1;            // indices into SceneDescription::bodies; -1: the world
  std::vector<Eigen::Vector3d> points_m;  // where the bodies are at the start; world frame
  double stiffness_N_per_m = 0.0;         // of each spring
  double damping_N_s_per_m = 0.0;         // likewise
  bool collide = false;                   // the two with each other
};

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

/// Slip speed of a tool with contact = "penalty": a hand's velocity is an estimate, late by some
/// milliseconds, and steeper friction would chatter.
inline constexpr double kPenaltySlip_m_s = 0.05;

/// A hand that holds a tool of its own in the scene.
struct Hand {
  std::string name;  // letters, digits, '_' and '-'; empty: the only hand of a scene
  std::vector<ToolSphere> tool;
  // 0: met by proxies. Else by the paper's penalty sum, whose friction is viscous up to this speed.
  double tool_slip_speed_m_s = 0.0;
  DeviceFrame device;
};

/// A hand that is typical of a scene: what a rate is chosen for.
struct HandDescription {
  std::filesystem::path file;  // of its path, as Hand reads it (sim_server/hand.hpp)
  double settle_s = 0.0;       // for which the scene comes to rest before, without a tool
  unsigned line = 0;           // of the scene file where the table begins; 0: not from a file
};

/// A scene file, checked: every number is finite, every reference resolves, every default
/// is filled in.
struct SceneDescription {
  std::string name;  // of the file, without folder and extension
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d(0.0, 0.0, -9.81);
  double period_s = 0.01;  // of the simulation
  Method method;
  bool names_step = true;      // false: neither a rate nor a method, see settle_step()
  bool choose_method = false;  // integrator = "auto": dynamics::choose_method() does
  bool sleeping = true;        // bodies at rest leave the work until something touches them
  double voxel_ratio = 0.0;    // voxel edge over twice a level's longest reach; 0: chosen
  std::vector<MaterialDescription> materials;
  std::vector<bodies::BodyDescription> bodies;
  std::vector<JointDescription> joints;
  // Either one hand, whose tool and device these are, or hands by name.
  std::vector<ToolSphere> tool;
  // 0: met by proxies. Else by the paper's penalty sum, whose friction is viscous up to this speed.
  double tool_slip_speed_m_s = 0.0;
  DeviceFrame device;
  std::optional<HandDescription> hand;
  std::vector<Hand> hands;         // at most proto::kMaxHands
  std::vector<std::string> notes;  // for the log: what was made of each mesh, a line each
};

/// The hands of a scene: those with a name, or the one without. One at least.
[[nodiscard]] inline std::vector<Hand> hands_of(const SceneDescription& scene) {
  if (!scene.hands.empty()) return scene.hands;
  return {{"", scene.tool, scene.tool_slip_speed_m_s, scene.device}};
}

}  // namespace stillgrid::scene
