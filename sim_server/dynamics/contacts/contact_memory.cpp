#include "sim_server/dynamics/contacts/contact_memory.hpp"

#include <algorithm>

#include "sim_server/contact/sticking.hpp"

namespace stillgrid::dynamics {

std::uint64_t key_of(const contact::Contact& contact) {
  constexpr int kNumberBits = 31;
  const auto number = [](int i) { return static_cast<std::uint64_t>(i); };
  if (contact.b >= 0) {
    const auto [low, high] = std::minmax(contact.a, contact.b);
    return number(low) << kNumberBits | number(high);
  }
  const std::uint64_t kind = contact.is_tool ? 3 : contact.is_plane ? 2 : 1;
  return kind << 2 * kNumberBits | number(contact.a) << kNumberBits | number(contact.other);
}

void find_stretches(std::span<const ContactMemory> kept, std::span<const contact::Contact> contacts,
                    std::vector<Eigen::Vector3d>& stretches_m) {
  stretches_m.assign(contacts.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::uint64_t key = key_of(contacts[i]);
    const auto own = std::ranges::lower_bound(kept, key, {}, &ContactMemory::key);
    if (own == kept.end() || own->key != key) continue;
    stretches_m[i] = contact::stretched_as(own->stretch_m, own->stiffness_N_per_m,
                                           contacts[i].material.stiffness_N_per_m);
    if (is_turned(contacts[i])) stretches_m[i] = -stretches_m[i];
  }
}

}  // namespace stillgrid::dynamics
