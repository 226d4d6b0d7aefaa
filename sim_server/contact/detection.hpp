#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/contact/contact_making.hpp"
#include "sim_server/contact/field_ways.hpp"
#include "sim_server/contact/moving_spheres.hpp"
#include "sim_server/contact/self_collision.hpp"

namespace stillgrid::contact {

/// The paper's collision detection [Davanne 2002, Figs. 2 and 3]: static spheres are entered in a
/// voxel grid once, moving ones when they have moved far; the tool is checked last and never
/// entered. Paths count, not places: two spheres that pass through each other within a step are
/// found. Fields are few and stand beside the grids: each looks for the spheres near it there.
class Detection {
 public:
  /// voxel_ratio: edge of a voxel over twice the reach of the spheres' swept bounds; none or
  /// negative: chosen from the scene.
  Detection(const bodies::World& world, double voxel_ratio);

  /// Makes contacts() every pair of spheres, and of spheres and planes or fields, that may touch
  /// within a step of step_s, each once. Throws std::domain_error, naming body and sphere, where a
  /// sphere's place is no number. Pre: `world` has the bodies that the constructor saw.
  void find_contacts(const bodies::World& world, double step_s);

  /// Takes note of who is sleeping: such bodies stay where they are, without work, and have
  /// contacts only with what moves. Call it when that changed. Throws as find_contacts().
  void note_sleep(const bodies::World& world);

  /// Appends the contacts of the tool with the moving spheres and fields, in place of those of an
  /// earlier call. After find_contacts() of the same step.
  void find_tool_contacts(const bodies::World& world, const std::vector<ToolSphereMotion>& tool);

  /// Takes where the spheres of the world are, for motions(). Throws as find_contacts().
  void move_spheres(const bodies::World& world);

  /// The moving spheres, in a grid whose records are the owner's to write.
  [[nodiscard]] MovingSpheres& spheres() noexcept { return moving_; }
  [[nodiscard]] const MovingSpheres& spheres() const noexcept { return moving_; }

  /// Of each moving sphere, as the last find_contacts() or move_spheres() saw it.
  [[nodiscard]] std::span<const bodies::SphereMotion> motions() const noexcept { return motion_; }

  [[nodiscard]] const std::vector<Contact>& contacts() const noexcept { return contacts_; }

  /// The spheres that never move, as World::static_spheres.
  [[nodiscard]] const collision::VoxelGrid& static_grid() const noexcept { return static_; }
  /// Of a moving sphere: it is not prescribed; it neither sleeps nor is prescribed to stay.
  [[nodiscard]] bool is_free(std::size_t sphere) const { return is_free_[sphere] != 0; }
  [[nodiscard]] bool moves(std::size_t sphere) const { return moves_[sphere] != 0; }
  /// Whether two moving spheres are ever a contact.
  [[nodiscard]] bool may_collide(const bodies::World& world, std::uint32_t i,
                                 std::uint32_t j) const {
    return (is_free(i) || is_free(j)) && !world.spheres[i].is_field_point &&
           !world.spheres[j].is_field_point &&
           bodies::may_collide(world, world.spheres[i].body, world.spheres[j].body) &&
           self_collision_.may_collide(world.spheres[i], world.spheres[j]);
  }

  /// Pairs of moving spheres that memory was taken for.
  [[nodiscard]] std::size_t room_for_pairs() const noexcept { return moving_.room_for_pairs(); }

 private:
  void bound_sweeps(const bodies::World& world, double step_s);
  void add_pairs(const bodies::World& world);
  void add_given(const bodies::World& world);
  void add_fields(const bodies::World& world);
  [[nodiscard]] Mover mover(std::uint32_t i) const { return {i, motion_[i], paths_[i]}; }

  SelfCollision self_collision_;
  MovingSpheres moving_;
  collision::VoxelGrid static_;
  std::vector<std::uint8_t> is_free_;  // of each moving sphere: not prescribed
  std::vector<std::uint8_t> moves_;    // neither sleeping nor prescribed to stay
  std::vector<bodies::SphereMotion> motion_;
  std::vector<collision::SweptBound> paths_;  // of each moving sphere in this step
  FieldWays fields_;
  double step_s_ = 0.0;  // that contacts were found for
  std::vector<Contact> contacts_;
  std::vector<std::uint32_t> met_;  // scratch
};

}  // namespace stillgrid::contact
