#include "sim_server/dynamics/contacts/contact_memory.hpp"

#include <algorithm>

#include "sim_server/contact/sticking.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr int kNumberBits = 31;
constexpr std::uint64_t kNumberMask = (std::uint64_t{1} << kNumberBits) - 1;

bool feels_forces(const bodies::World& world, int number) {
  if (const int rigid = bodies::rigid_of(world, number); rigid >= 0)
    return world.rigid_bodies[static_cast<std::size_t>(rigid)].unknown != bodies::kNoUnknown;
  if (bodies::is_field(world, number)) return false;
  const bodies::SphereBinding& binding = world.spheres[static_cast<std::size_t>(number)];
  return std::any_of(binding.nodes.begin(), binding.nodes.begin() + binding.node_count, [&](int n) {
    return world.nodes[static_cast<std::size_t>(n)].unknown != bodies::kNoUnknown;
  });
}

/// Whether neither side of a pair is free and awake, so that it may be on no list.
bool lies_still(std::uint64_t key, const bodies::World& world) {
  const auto is_still = [&](std::uint64_t number) {
    return number < world.spheres.size() + world.fields.size() &&
           !feels_forces(world, static_cast<int>(number));
  };
  const bool is_of_two = key >> 2 * kNumberBits == 0;
  return is_still(key >> kNumberBits & kNumberMask) && (!is_of_two || is_still(key & kNumberMask));
}

double sum_J(const std::vector<ContactMemory>& memories) {
  double energy_J = 0.0;
  for (const ContactMemory& memory : memories) energy_J += memory.energy_J();
  return energy_J;
}

}  // namespace

std::uint64_t key_of(const contact::Contact& contact) {
  const auto number = [](int i) { return static_cast<std::uint64_t>(i); };
  if (contact.b >= 0) {
    const auto [low, high] = std::minmax(contact.a, contact.b);
    return number(low) << kNumberBits | number(high);
  }
  const std::uint64_t kind = contact.is_tool ? 3 : contact.is_plane ? 2 : 1;
  return kind << 2 * kNumberBits | number(contact.a) << kNumberBits | number(contact.other);
}

void ContactMemories::take(const bodies::World& world, std::span<const contact::Contact> contacts) {
  places_.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i)
    places_.push_back({key_of(contacts[i]), static_cast<std::uint32_t>(i)});
  if (!std::is_sorted(places_.begin(), places_.end())) std::sort(places_.begin(), places_.end());
  memories_.clear();
  unlisted_.clear();
  parted_J_ = 0.0;
  auto known = kept_.begin();
  const auto leave_out = [&](const ContactMemory& memory) {
    if (lies_still(memory.key, world))
      unlisted_.push_back(memory);
    else
      parted_J_ += memory.energy_J();
  };
  for (const Place& place : places_) {
    while (known != kept_.end() && known->key < place.key) leave_out(*known++);
    if (known != kept_.end() && known->key == place.key)
      memories_.push_back(*known++);
    else
      memories_.push_back({.key = place.key});
    ContactMemory& memory = memories_.back();
    const double now_N_per_m = contacts[place.contact].material.stiffness_N_per_m;
    memory.stretch_m =
        contact::stretched_as(memory.stretch_m, memory.stiffness_N_per_m, now_N_per_m);
    memory.stiffness_N_per_m = now_N_per_m;
  }
  while (known != kept_.end()) leave_out(*known++);
}

void ContactMemories::keep() {
  next_.clear();
  auto still = unlisted_.begin();
  for (const ContactMemory& memory : memories_) {
    if (memory.stretch_m.isZero(0.0)) continue;
    while (still != unlisted_.end() && still->key < memory.key) next_.push_back(*still++);
    next_.push_back(memory);
  }
  next_.insert(next_.end(), still, unlisted_.end());
  kept_.swap(next_);
}

void ContactMemories::stretches(std::span<const contact::Contact> contacts,
                                std::vector<Eigen::Vector3d>& stretches_m) const {
  stretches_m.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::uint32_t contact = places_[i].contact;
    const Eigen::Vector3d& kept_m = memories_[i].stretch_m;
    stretches_m[contact] = is_turned(contacts[contact]) ? -kept_m : kept_m;
  }
}

void ContactMemories::forget(std::size_t place) {
  parted_J_ += memories_[place].energy_J();
  memories_[place].stretch_m.setZero();
}

double ContactMemories::energy_J() const {
  return sum_J(kept_);
}

double ContactMemories::ended_energy_J() const {
  return sum_J(memories_) + sum_J(unlisted_);
}

}  // namespace stillgrid::dynamics
