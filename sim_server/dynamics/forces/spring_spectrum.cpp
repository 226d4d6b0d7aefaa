#include "sim_server/dynamics/forces/spring_spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace stillgrid::dynamics {
namespace {

using Eigen::Vector3d;

constexpr int kFirstIterations = 30;

/// Calls visit(a, b, spring, unit vector, length) for springs of bodies that are awake.
template <class Visit>
void for_each_spring(const bodies::World& world, const ExplicitState& state, const Visit& visit) {
  for (const bodies::BodyRange& body : world.bodies) {
    if (body.is_sleeping) continue;
    for (int i = body.first_spring; i < body.first_spring + body.spring_count; ++i) {
      const bodies::Spring& spring = world.springs[static_cast<std::size_t>(i)];
      const auto a = static_cast<std::size_t>(spring.a), b = static_cast<std::size_t>(spring.b);
      const Vector3d line_m = state.position_m[b].map() - state.position_m[a].map();
      const double length_m = line_m.norm();
      if (length_m > 1e-12) visit(spring, a, b, Vector3d(line_m / length_m), length_m);
    }
  }
}

}  // namespace

/// |M^-1/2 A M^-1/2 x| / |x|, x being made the product each time.
template <class Multiply>
double SpringSpectrum::iterate(std::vector<PackedVector>& vector, int times,
                               const Multiply& multiply) {
  double norm = 0.0;
  for (int k = 0; k < times; ++k) {
    product_.assign(vector.size(), {});
    multiply(vector, product_);
    double squared = 0.0;
    for (const PackedVector& v : product_) squared += v.map().squaredNorm();
    norm = std::sqrt(squared);
    if (!(norm > 0.0)) return 0.0;
    for (std::size_t i = 0; i < vector.size(); ++i) vector[i].map() = product_[i].map() / norm;
  }
  return norm;
}

SpringRates SpringSpectrum::follow(const bodies::World& world, const ExplicitState& state) {
  int times = 1;
  if (stretching_.size() != world.nodes.size()) {
    times = kFirstIterations;
    std::mt19937 random(1);
    stretching_.assign(world.nodes.size(), {});
    for (std::size_t i = 0; i < world.nodes.size(); ++i)
      for (double& component : stretching_[i].map())
        component = static_cast<double>(random()) / 4294967296.0 - 0.5;
    damping_ = stretching_;
  }
  SpringRates rates;
  const auto root = [&](std::size_t node) { return std::sqrt(state.inverse_mass_per_kg[node]); };
  rates.stiffness_per_s2 = iterate(stretching_, times, [&](const auto& x, auto& y) {
    for_each_spring(
        world, state,
        [&](const bodies::Spring& spring, std::size_t a, std::size_t b, const Vector3d& n,
            double length_m) {
          const double sideways_N_per_m =
              spring.stiffness_N_per_m * std::max(0.0, 1.0 - spring.rest_length_m / length_m);
          const Vector3d d = root(b) * x[b].map() - root(a) * x[a].map();
          const Vector3d force =
              (spring.stiffness_N_per_m - sideways_N_per_m) * n.dot(d) * n + sideways_N_per_m * d;
          y[a].map() -= root(a) * force;
          y[b].map() += root(b) * force;
        });
  });
  const bool damped =
      std::any_of(world.springs.begin(), world.springs.end(),
                  [](const bodies::Spring& spring) { return spring.damping_N_s_per_m > 0.0; });
  if (!damped) return rates;
  rates.damping_per_s = iterate(damping_, times, [&](const auto& x, auto& y) {
    for_each_spring(
        world, state,
        [&](const bodies::Spring& spring, std::size_t a, std::size_t b, const Vector3d& n, double) {
          const double force =
              spring.damping_N_s_per_m * n.dot(root(b) * x[b].map() - root(a) * x[a].map());
          y[a].map() -= root(a) * force * n;
          y[b].map() += root(b) * force * n;
        });
  });
  return rates;
}

}  // namespace stillgrid::dynamics
