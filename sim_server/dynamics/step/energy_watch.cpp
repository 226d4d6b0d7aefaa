#include "sim_server/dynamics/step/energy_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace stillgrid::dynamics {
namespace {

constexpr double kPeriod_s = 0.1;
constexpr double kShare = 0.1;
constexpr double kLeast_J_per_kg = 5e-5;  // of a speed of 1 cm/s

double moving_mass_kg(const bodies::World& world) {
  double mass_kg = 0.0;
  for (const bodies::Node& node : world.nodes)
    if (!node.pinned) mass_kg += node.mass_kg;
  for (const bodies::RigidBody& body : world.rigid_bodies)
    if (body.free) mass_kg += body.mass_kg;
  return mass_kg;
}

}  // namespace

void EnergyWatch::note_given(double given_J) {
  given_J_ += given_J;
  exchanged_J_ += std::abs(given_J);
}

void EnergyWatch::judge(const bodies::World& world, const Energies& now) {
  next_look_s_ = std::max(next_look_s_, world.time_s + kPeriod_s);
  most_held_J_ = std::max({most_held_J_, now.kinetic_J + now.springs_J + now.contacts_J,
                           start_.gravity_J - now.gravity_J});
  const double gained_J = now.total_J() - start_.total_J() - given_J_;
  const double allowed_J =
      kShare * (most_held_J_ + exchanged_J_) + kLeast_J_per_kg * moving_mass_kg(world);
  if (gained_J <= allowed_J) return;
  std::array<char, 300> line{};
  std::snprintf(line.data(), line.size(),
                "after %.6g s of simulated time the scene has gained %.3g J without a source "
                "(start %.3g J, tools and prescribed bodies %.3g J, now %.3g J): the step is too "
                "long for the scene's stiffness and masses",
                world.time_s, gained_J, start_.total_J(), given_J_, now.total_J());
  throw std::domain_error(line.data());
}

}  // namespace stillgrid::dynamics
