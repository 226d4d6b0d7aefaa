#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/contact/field_touch.hpp"
#include "sim_server/dynamics/contacts/contact_memory.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/workers/workers.hpp"

namespace stillgrid::dynamics {

/// A sphere with contacts, or a field as the sphere that it is to another one.
struct ContactSphere {
  int number;  // of World::spheres, or a field's
  int rigid;   // that contacts move, or -1
  const bodies::SphereBinding* binding;
  PackedVector position_m{}, arm_m{};  // arm: from its rigid body's centre
  double speed_m_s = 0.0;              // with what forces but contacts' add in the substep, at most
};

/// Two spheres, or a sphere and what stands in the contact.
struct ContactPair {
  int a, b;                     // in ContactList::spheres(); b -1: given
  double radius_m, distance_m;  // of a; of both
  const contact::Contact* contact;
  int touch = -1;  // of a field's: in ContactList::touches()
};

/// A contact with a field, where all was placed last.
struct ContactTouch {
  std::size_t pair;  // in ContactList::pairs()
  int sphere;        // that the field is, in ContactList::spheres()
  const bodies::FieldBody* field;
  contact::FieldPose pose;              // of what never moves
  bodies::SphereBinding binding;        // of that sphere: where it is in its body
  collision::ContactMaterial material;  // as stiff as it is there
};

/// The pairs of a part of a step in the order of their keys, and what sticks between them. Nothing
/// is allocated once there was room.
class ContactList {
 public:
  /// Takes the contacts of a part, in any order; those that were kept are stretched as they were.
  /// Pre: world and contacts do not change while it lasts.
  void take(const bodies::World& world, std::span<const contact::Contact> contacts);

  /// Moves the spheres to where the state is, and fields to where they touch then, when this share
  /// of the part is over. Pre: its forces are those of springs.
  void place(const ExplicitState& state, double share, double substep_s,
             const Eigen::Vector3d& gravity_m_s2, const Workers& workers);

  /// Ordered by key, so that sums over them do not depend on the list's order.
  [[nodiscard]] const std::vector<ContactPair>& pairs() const noexcept { return pairs_; }
  [[nodiscard]] std::span<const ContactSphere> spheres() const noexcept { return spheres_; }
  [[nodiscard]] const ContactSphere& sphere(int place) const {
    return spheres_[static_cast<std::size_t>(place)];
  }
  [[nodiscard]] std::span<const ContactTouch> touches() const noexcept { return touches_; }
  /// What sticks, by the same order.
  [[nodiscard]] ContactMemories& memories() noexcept { return memories_; }
  [[nodiscard]] const ContactMemories& memories() const noexcept { return memories_; }
  /// Where the other side is when this share of the part is over. Pre: it is no plane.
  [[nodiscard]] Eigen::Vector3d other_m(const ContactPair& pair, double share) const;
  /// Whether the pair may touch within a substep around the spheres' places.
  [[nodiscard]] bool is_near(const ContactPair& pair, double share, double part_s,
                             double substep_s) const;

  /// Pairs that overlap where the state is, at the part's end.
  [[nodiscard]] int count_touching(const ExplicitState& state, const Workers& workers);
  /// Fastest approach in smaller radii a second, of pairs of spheres that may meet in the part;
  /// with a field in the sphere's radius and a fine cell.
  [[nodiscard]] double approach_per_s(const ExplicitState& state, double part_s) const;

 private:
  static void place(ContactSphere& sphere, const ExplicitState& state, double substep_s,
                    const Eigen::Vector3d& gravity_m_s2);
  void place(ContactTouch& touch, const ExplicitState& state, double share, double substep_s,
             const Eigen::Vector3d& gravity_m_s2);
  void add_touch(const bodies::World& world, std::size_t pair, int number);
  [[nodiscard]] double field_approach_per_s(const ContactPair& pair, const ExplicitState& state,
                                            double part_s) const;

  std::vector<int> place_of_;           // of each sphere of the world in spheres_, or -1
  std::vector<ContactSphere> spheres_;  // fields' behind the world's
  std::vector<ContactPair> pairs_;
  std::vector<ContactTouch> touches_;
  ContactMemories memories_;
};

/// Where the given side's sphere goes, on its way through the part.
[[nodiscard]] Eigen::Vector3d way_m_s(const contact::Contact& contact, double part_s);

}  // namespace stillgrid::dynamics
