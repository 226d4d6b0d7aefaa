#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"

namespace stillgrid::dynamics {

/// What lasts of a pair that touches, from step to step.
struct ContactMemory {
  std::uint64_t key = 0;  // names the pair whatever the list's order
  double stiffness_N_per_m = 0.0;
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // of what sticks, across the normal
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();     // when it was stretched so

  [[nodiscard]] double energy_J() const {
    return 0.5 * stiffness_N_per_m * stretch_m.squaredNorm();
  }
};

/// Returns the key of a pair: its kind, the lower number, the higher.
[[nodiscard]] std::uint64_t key_of(const contact::Contact& contact);

/// What sticks between the pairs of a list of contacts, by the numbers of spheres and fields: of
/// the one with the lower number seen from the other. Nothing but keep() changes what a part of a
/// step begins with: one that is thrown away leaves no trace. Pairs of which neither side is free
/// and awake stay stretched though no one lists them. Nothing is allocated once there was room.
class ContactMemories {
 public:
  /// Takes the contacts of a part, in any order; those that were kept are stretched as they were.
  void take(const bodies::World& world, std::span<const contact::Contact> contacts);
  /// What pairs have come to is what the next part begins with.
  void keep();

  /// What is kept, by key; and to go on from what another world's contacts kept, of the same
  /// spheres.
  [[nodiscard]] const std::vector<ContactMemory>& kept() const noexcept { return kept_; }
  void set_kept(std::vector<ContactMemory> kept) { kept_ = std::move(kept); }

  /// Pairs by key, and where each is in the contacts that were taken.
  struct Place {
    std::uint64_t key;
    std::uint32_t contact;
    auto operator<=>(const Place&) const = default;
  };
  [[nodiscard]] const std::vector<Place>& places() const noexcept { return places_; }
  /// Of the pair at that place.
  [[nodiscard]] ContactMemory& operator[](std::size_t place) { return memories_[place]; }
  [[nodiscard]] const ContactMemory& operator[](std::size_t place) const {
    return memories_[place];
  }

  /// Of each of the contacts that were taken, how it is stretched, of a seen from b.
  void stretches(std::span<const contact::Contact> contacts,
                 std::vector<Eigen::Vector3d>& stretches_m) const;

  /// The pair has parted: what it held is gone.
  void forget(std::size_t place);
  /// Energy of what parted since this was asked last, J.
  [[nodiscard]] double take_parted_J() { return std::exchange(parted_J_, 0.0); }
  /// Of what is kept, J; and of what keep() would.
  [[nodiscard]] double energy_J() const;
  [[nodiscard]] double ended_energy_J() const;

 private:
  std::vector<Place> places_;
  std::vector<ContactMemory> memories_;     // of each place
  std::vector<ContactMemory> kept_, next_;  // by key, of pairs that are stretched
  std::vector<ContactMemory> unlisted_;     // by key, of what does not move
  double parted_J_ = 0.0;
};

/// Whether a pair is kept the other way round than the contact has it.
[[nodiscard]] inline bool is_turned(const contact::Contact& contact) {
  return contact.b >= 0 && contact.b < contact.a;
}

}  // namespace stillgrid::dynamics
