#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact_making.hpp"
#include "sim_server/contact/moving_spheres.hpp"
#include "sim_server/contact/self_collision.hpp"

namespace stillgrid::contact {

/// The spheres of a world as the paper's collision detection has them [Davanne 2002, Figs. 2 and
/// 3]: static spheres are entered in a voxel grid once, moving ones when they have moved far. The
/// tool is never entered.
class Detection {
 public:
  /// voxel_ratio: edge of a voxel over twice the reach of the spheres' swept bounds; none or
  /// negative: chosen from the scene. Throws as move_spheres().
  Detection(const bodies::World& world, double voxel_ratio);

  /// Takes note of who is sleeping: such bodies stay where they are, without work, and have
  /// contacts only with what moves. Call it when that changed. Throws as
  /// move_spheres().
  void note_sleep(const bodies::World& world);

  /// Takes where the spheres of the world are, for motions(). Throws std::domain_error, naming body
  /// and sphere, where a place is no number. Pre: `world` has the bodies that the constructor saw.
  void move_spheres(const bodies::World& world);

  /// The moving spheres, in a grid whose records are the owner's to write.
  [[nodiscard]] MovingSpheres& spheres() noexcept { return moving_; }
  [[nodiscard]] const MovingSpheres& spheres() const noexcept { return moving_; }

  /// Of each moving sphere, as the last move_spheres() saw it.
  [[nodiscard]] std::span<const bodies::SphereMotion> motions() const noexcept { return motion_; }

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

 private:
  SelfCollision self_collision_;
  MovingSpheres moving_;
  collision::VoxelGrid static_;
  std::vector<std::uint8_t> is_free_;  // of each moving sphere: not prescribed
  std::vector<std::uint8_t> moves_;    // neither sleeping nor prescribed to stay
  std::vector<bodies::SphereMotion> motion_;
};

}  // namespace stillgrid::contact
