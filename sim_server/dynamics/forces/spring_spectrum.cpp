#include "sim_server/dynamics/forces/spring_spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace stillgrid::dynamics {
namespace {

constexpr int kFirstIterations = 30;

}  // namespace

/// With A = M^-1/2 K M^-1/2, |A x| of x = M^1/2 u with |x| = 1, displacements u being made the
/// product's each time.
double SpringSpectrum::iterate(const bodies::World& world, const ExplicitState& state,
                               SpringLaw law, int times, SpringForces& springs,
                               std::vector<PackedVector>& displacements) {
  double norm = 0.0;
  for (int k = 0; k < times; ++k) {
    forces_.assign(displacements.size(), {});
    springs.answer(world, law, state, displacements, forces_);
    double squared = 0.0;
    for (std::size_t i = 0; i < forces_.size(); ++i)
      squared += state.inverse_mass_per_kg[i] * forces_[i].map().squaredNorm();
    norm = std::sqrt(squared);
    if (!(norm > 0.0)) return 0.0;
    for (std::size_t i = 0; i < forces_.size(); ++i)
      displacements[i].map() = state.inverse_mass_per_kg[i] / norm * forces_[i].map();
  }
  return norm;
}

SpringRates SpringSpectrum::follow(const bodies::World& world, const ExplicitState& state,
                                   SpringForces& springs) {
  int times = 1;
  if (stretching_.size() != world.nodes.size()) {
    times = kFirstIterations;
    std::mt19937 random(1);
    stretching_.assign(world.nodes.size(), {});
    for (std::size_t i = 0; i < world.nodes.size(); ++i)
      for (double& component : stretching_[i].map())
        component = std::sqrt(state.inverse_mass_per_kg[i]) *
                    (static_cast<double>(random()) / 4294967296.0 - 0.5);
    damping_ = stretching_;
  }
  SpringRates rates;
  rates.stiffness_per_s2 =
      iterate(world, state, SpringLaw::kStiffness, times, springs, stretching_);
  const bool damped =
      std::any_of(world.springs.begin(), world.springs.end(),
                  [](const bodies::Spring& spring) { return spring.damping_N_s_per_m > 0.0; });
  if (damped)
    rates.damping_per_s = iterate(world, state, SpringLaw::kDampers, times, springs, damping_);
  return rates;
}

}  // namespace stillgrid::dynamics
