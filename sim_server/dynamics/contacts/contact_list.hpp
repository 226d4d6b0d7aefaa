#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"

namespace stillgrid::dynamics {

/// A sphere with contacts.
struct ContactSphere {
  int number;  // of World::spheres
  const bodies::SphereBinding* binding;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();  // from its rigid body's centre
  double speed_m_s = 0.0;  // with what forces but contacts' add in the substep, at most
};

/// Two spheres, or a sphere and what stands in the contact.
struct ContactPair {
  int a, b;                     // in ContactList::spheres(); b -1: given
  double radius_m, distance_m;  // of a; of both
  const contact::Contact* contact;
};

/// What lasts of a pair that touches, from substep to substep.
struct ContactMemory {
  std::uint64_t key = 0;  // names the pair whatever the list's order
  double stiffness_N_per_m = 0.0;
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // of what sticks, across the normal
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();     // when it was stretched so

  [[nodiscard]] double energy_J() const {
    return 0.5 * stiffness_N_per_m * stretch_m.squaredNorm();
  }
};

/// The pairs of a part of a step in an order of their own, and what sticks between them. Nothing
/// but keep() changes what a part begins with: one that is thrown away leaves no trace. Pairs whose
/// both sides feel no forces, as those of sleeping bodies, stay stretched though no one lists them.
/// Nothing is allocated once there was room.
class ContactList {
 public:
  /// Takes the contacts of a part, in any order; those that were kept are stretched as they were.
  /// Pre: world and contacts do not change while it lasts.
  void take(const bodies::World& world, std::span<const contact::Contact> contacts,
            const ExplicitState& state);
  /// What pairs have come to is what the next part begins with.
  void keep();

  /// Moves the spheres to where the state is. Pre: its forces are those of springs.
  void place(const ExplicitState& state, double substep_s, const Eigen::Vector3d& gravity_m_s2);

  /// Ordered by key, so that sums over them do not depend on the list's order.
  [[nodiscard]] const std::vector<ContactPair>& pairs() const noexcept { return pairs_; }
  [[nodiscard]] std::size_t spheres() const noexcept { return spheres_.size(); }
  [[nodiscard]] const ContactSphere& sphere(int place) const {
    return spheres_[static_cast<std::size_t>(place)];
  }
  [[nodiscard]] ContactMemory& memory(std::size_t pair) { return memories_[pair]; }
  /// Where the other side is when this share of the part is over. Pre: it is no plane.
  [[nodiscard]] Eigen::Vector3d other_m(const ContactPair& pair, double share) const;
  /// Whether the pair may touch within a substep around the spheres' places.
  [[nodiscard]] bool is_near(const ContactPair& pair, double share, double part_s,
                             double substep_s) const;
  /// The pair has parted: what it held is gone.
  void forget(std::size_t pair);
  /// Energy of what parted since this was asked last, J.
  [[nodiscard]] double take_parted_J() { return std::exchange(parted_J_, 0.0); }

  /// Pairs that overlap where the state is, at the part's end.
  [[nodiscard]] int count_touching(const ExplicitState& state);
  /// Fastest approach in smaller radii a second, of pairs of spheres that may meet in the part.
  [[nodiscard]] double approach_per_s(const ExplicitState& state, double part_s) const;
  /// Of what is kept, J.
  [[nodiscard]] double stretch_energy_J() const;

 private:
  void remember(const bodies::World& world, const ExplicitState& state);

  std::vector<int> place_of_;  // of each sphere of the world in spheres_, or -1
  std::vector<ContactSphere> spheres_;
  std::vector<ContactPair> pairs_;
  std::vector<ContactMemory> memories_;     // of each pair
  std::vector<ContactMemory> kept_, next_;  // by key, of pairs that are stretched
  std::vector<ContactMemory> unlisted_;     // by key, of what does not move
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order_;
  double parted_J_ = 0.0;
};

/// Where the given side's sphere goes, on its way through the part.
[[nodiscard]] Eigen::Vector3d way_m_s(const contact::Contact& contact, double part_s);

}  // namespace stillgrid::dynamics
