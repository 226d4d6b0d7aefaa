#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "shared/collision/still_grid.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"

namespace stillgrid {

/// A sphere of the tool in the scene, as sampled for this step and as it was a step before.
struct ToolSphereMotion {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
  Eigen::Vector3d position_before_m;
  double radius_m;
};

/// The paper's collision detection [Davanne 2002, Figs. 2 and 3]: moving spheres are entered in a
/// voxel grid every step, still ones once; the tool is checked last and never entered.
class Detection {
 public:
  /// voxel_ratio: edge of a voxel over the mean diameter of the moving spheres.
  Detection(const World& world, double voxel_ratio);

  /// Appends to contacts() every pair that may touch within a step of step_s, each once.
  void find_contacts(const World& world, double step_s);

  /// Appends the contacts of the tool with the moving spheres. After find_contacts() of the same
  /// step.
  void find_tool_contacts(const World& world, const std::vector<ToolSphereMotion>& tool);

  [[nodiscard]] const std::vector<Contact>& contacts() const noexcept { return contacts_; }
  [[nodiscard]] float voxel_m() const noexcept { return voxel_m_; }
  [[nodiscard]] float still_voxel_m() const noexcept { return still_voxel_m_; }

 private:
  void enter_spheres(const World& world, double step_s);
  void add_pairs(const World& world);
  void add_still(const World& world);
  void add_planes(const World& world);

  float voxel_m_;
  float still_voxel_m_;
  StillGrid moving_;
  StillGrid still_;
  std::vector<SphereMotion> motion_;
  std::vector<Contact> contacts_;
};

/// Whether two spheres of one body may collide: never on a rigid body; on a deformable one unless
/// they are neighbours in its rest shape, closer than twice the sum of their radii.
[[nodiscard]] bool may_collide(const SphereBinding& a, const SphereBinding& b);

/// Records of the still spheres, in the order of World::still_spheres.
[[nodiscard]] std::vector<proto::SphereRecord> still_records(const World& world);

}  // namespace stillgrid
