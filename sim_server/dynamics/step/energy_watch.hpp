#pragma once

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/step/energy_account.hpp"

namespace stillgrid::dynamics {

/// Ends a run whose world gains energy that no source gave. Sources are tools and prescribed
/// bodies. Ten times a second of simulated time it sums the energy of motion, gravity, springs and
/// contacts. This sum may exceed the start's plus the work of the sources by at most
///
///   0.1 (H + W) + 5e-5 J/kg m.
///
/// H is the largest energy beside gravity that was seen, or the fall in gravity energy if that is
/// larger. W is the sum of the amounts of the sources' work, and m is the mass that moves. Losses
/// by dampers and friction are not added: an error of their account ends no run.
class EnergyWatch {
 public:
  explicit EnergyWatch(const Energies& start) : start_(start) {}

  /// Adds the work of tools and prescribed bodies, J.
  void note_given(double given_J);

  /// Whether a tenth of a second is over since the last judgement.
  [[nodiscard]] bool is_due(const bodies::World& world) const {
    return world.time_s >= next_look_s_;
  }

  /// now: energies of that world. Throws std::domain_error, one line.
  void judge(const bodies::World& world, const Energies& now);

 private:
  Energies start_;
  double given_J_ = 0.0, exchanged_J_ = 0.0, most_held_J_ = 0.0;
  double next_look_s_ = 0.0;
};

}  // namespace stillgrid::dynamics
