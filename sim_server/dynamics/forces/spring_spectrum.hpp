#pragma once

#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_forces.hpp"

namespace stillgrid::dynamics {

/// Largest eigenvalues of the springs that are awake, K and C of M^-1 K (1/s2) and M^-1 C (1/s).
struct SpringRates {
  double stiffness_per_s2 = 0.0;
  double damping_per_s = 0.0;
};

/// Follows the springs' largest eigenvalues as they deform, by power iteration from where the last
/// one ended. What softens, the sideways push of compressed springs, is left out.
class SpringSpectrum {
 public:
  /// A lower bound of the rates, near after many iterations. The first call makes 30, later ones
  /// one each.
  [[nodiscard]] SpringRates follow(const bodies::World& world, const ExplicitState& state,
                                   SpringForces& springs);

  /// The next call is the first.
  void restart() { stretching_.clear(); }

 private:
  double iterate(const bodies::World& world, const ExplicitState& state, SpringLaw law, int times,
                 SpringForces& springs, std::vector<PackedVector>& displacements);

  std::vector<PackedVector> stretching_, damping_, forces_;
};

}  // namespace stillgrid::dynamics
