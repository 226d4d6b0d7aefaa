#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/contact/contact_making.hpp"

namespace stillgrid::dynamics {

/// What of a world is predicted: all of it, or of a large one the bodies nearest to any sphere of
/// the tool, which alone can be felt before the next snapshot. They are a world of their own, with
/// a shell round them of bodies that stay where they are; the rest moves on at its velocity.
class PredictedPart {
 public:
  /// Spheres of the bodies that move, and again of those that stay, at most.
  static constexpr std::size_t kMaxSpheres = 1000;

  /// Pre: motions are those of all moving spheres, `world` stays as it is while this is used.
  void choose(const bodies::World& world, std::span<const bodies::SphereMotion> motions,
              std::span<const contact::ToolSphereMotion> tool);

  [[nodiscard]] bool is_whole() const noexcept { return is_whole_; }
  /// Its spheres, of World::spheres, ascending.
  [[nodiscard]] std::span<const std::uint32_t> spheres() const noexcept { return spheres_; }
  [[nodiscard]] const bodies::World& world() const noexcept { return is_whole_ ? *whole_ : part_; }
  /// The number in the scene of a body of world().
  [[nodiscard]] std::uint32_t scene_body(std::uint32_t body) const {
    return is_whole_ ? body : chosen_[body].first;
  }
  /// Contacts of these spheres, by their numbers in world().
  [[nodiscard]] std::span<const contact::Contact> renumbered(
      std::span<const contact::Contact> contacts);

 private:
  void choose_bodies(std::span<const bodies::SphereMotion> motions,
                     std::span<const contact::ToolSphereMotion> tool);
  void add_body(std::size_t number, bool stays);
  void add_joint(bodies::Joint joint);

  const bodies::World* whole_ = nullptr;
  bool is_whole_ = true;
  bodies::World part_;
  std::vector<std::uint32_t> spheres_;
  std::vector<std::pair<double, std::uint32_t>> bodies_;  // by distance from the tool (m2)
  std::vector<std::pair<std::uint32_t, bool>> chosen_;    // bodies, and whether they stay
  std::vector<contact::Contact> contacts_;
};

}  // namespace stillgrid::dynamics
