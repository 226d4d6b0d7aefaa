#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "sim_server/contact/contact.hpp"

namespace stillgrid::dynamics {

/// A pair that friction has stretched.
struct ContactMemory {
  std::uint64_t key = 0;  // names the pair whatever the list's order
  double stiffness_N_per_m = 0.0;
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // of the lower number seen from the other
};

/// Returns the key of a pair: its kind, the lower number, the higher.
[[nodiscard]] std::uint64_t key_of(const contact::Contact& contact);

/// Whether a pair is kept the other way round than the contact has it.
[[nodiscard]] inline bool is_turned(const contact::Contact& contact) {
  return contact.b >= 0 && contact.b < contact.a;
}

/// Writes how each contact is stretched, of a seen from b; zero of pairs that are not in kept.
/// Pre: kept is sorted by key.
void find_stretches(std::span<const ContactMemory> kept, std::span<const contact::Contact> contacts,
                    std::vector<Eigen::Vector3d>& stretches_m);

}  // namespace stillgrid::dynamics
