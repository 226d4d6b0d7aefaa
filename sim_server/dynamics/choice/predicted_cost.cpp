#include "sim_server/dynamics/choice/predicted_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/spring_spectrum.hpp"

namespace stillgrid::dynamics {
namespace {

// Costs of one operation, ns.
constexpr double kSpringForce = 2.0, kNodeStep = 5.0, kContactForce = 80.0, kRigidStep = 100.0;
constexpr double kDetection = 60.0;  // a moving sphere in a step
constexpr double kSpringJacobian = 60.0, kContactJacobian = 1000.0, kFillEntry = 8.0;
constexpr double kSpringProduct = 8.0, kContactProduct = 100.0;
constexpr double kNewtonIterations = 4.0;

SpringRates spring_rates(const bodies::World& world) {
  ExplicitState state;
  for (const bodies::Node& node : world.nodes) {
    state.position_m.emplace_back().map() = node.position_m;
    state.inverse_mass_per_kg.push_back(node.pinned ? 0.0 : 1.0 / node.mass_kg);
  }
  return SpringSpectrum().follow(world, state);
}

/// Entries of L for one body's block, by nested dissection: a curve's bandwidth, a surface's n log
/// n, a solid's n^(4/3).
double fill_of(const bodies::BodyRange& body) {
  const double n = body.node_count;
  if (body.rigid >= 0) return 36.0;
  if (body.node_count == 0) return 0.0;
  const double per_node = static_cast<double>(body.spring_count) / n;
  if (per_node < 2.5) return 9.0 * 3.0 * n;
  if (body.sheet_nodes.prod() > 0) return 9.0 * 4.0 * n * std::log2(n + 1.0);
  return 9.0 * 2.0 * std::pow(n, 4.0 / 3.0);
}

}  // namespace

SceneLoad load_of(const bodies::World& world) {
  SceneLoad load;
  load.springs = static_cast<double>(world.springs.size());
  load.nodes = static_cast<double>(world.nodes.size());
  load.spheres = static_cast<double>(world.spheres.size());
  load.unknowns = world.unknown_count;
  const SpringRates rates = spring_rates(world);
  load.spring_rad_s = std::sqrt(rates.stiffness_per_s2);
  load.damping_1_s = rates.damping_per_s;
  for (const bodies::BodyRange& body : world.bodies) {
    load.fill += fill_of(body);
    if (body.rigid >= 0) load.rigid_bodies += 1.0;
    if (body.sphere_count == 0) continue;
    const bodies::SphereBinding& sphere =
        world.spheres[static_cast<std::size_t>(body.first_sphere)];
    const collision::ContactMaterial& material =
        world.materials[static_cast<std::size_t>(sphere.material)];
    const bool rigid = body.rigid >= 0;
    const double mass_kg = rigid ? world.rigid_bodies[static_cast<std::size_t>(body.rigid)].mass_kg
                                 : world.nodes[static_cast<std::size_t>(body.first_node)].mass_kg;
    if (!(mass_kg > 0.0)) continue;
    // A face's spheres of a rigid body; of a deformable one those that a node carries.
    const double count = rigid ? std::max(1.0, body.sphere_count / 3.0)
                               : std::max(1.0, double(body.sphere_count) / body.node_count);
    load.contact_rad_s =
        std::max(load.contact_rad_s, std::sqrt(count * material.stiffness_N_per_m / mass_kg));
  }
  return load;
}

double symplectic_limit_s(const SceneLoad& load) {
  const double stiffness =
      load.spring_rad_s * load.spring_rad_s + load.contact_rad_s * load.contact_rad_s;
  if (!(stiffness > 0.0)) return std::numeric_limits<double>::infinity();
  const double half = load.damping_1_s / stiffness;
  return std::sqrt(half * half + 4.0 / stiffness) - half;
}

int stable_substeps(const SceneLoad& load, double step_s) {
  constexpr double kSpare = 1.1, kMax = 1e9;
  return static_cast<int>(
      std::clamp(std::ceil(kSpare * step_s / symplectic_limit_s(load)), 1.0, kMax));
}

double predicted_ms(const SceneLoad& load, const scene::Method& method, double step_s) {
  const double contacts = 0.5 * load.spheres;
  const double detection_ns = kDetection * load.spheres;
  const int given = method.substeps;
  if (scene::is_explicit(method.integrator)) {
    const double needed = std::ceil(step_s / symplectic_limit_s(load));
    double substeps = given > 0 ? given : std::max(1.0, needed);
    if (method.integrator == scene::IntegratorKind::kVelocityVerlet)
      substeps += 1.0;  // forces at the end
    return 1e-6 *
           (detection_ns + substeps * (kSpringForce * load.springs + kNodeStep * load.nodes +
                                       kContactForce * contacts + kRigidStep * load.rigid_bodies));
  }
  const double substeps = std::max(1, given);
  double iteration_ns = 0.0;
  if (method.solver == scene::SolverKind::kNewtonCg) {
    // As many products as the square root of the condition asks, which is about h w.
    const double radius = step_s / substeps * std::hypot(load.spring_rad_s, load.contact_rad_s);
    const double products = std::min(load.unknowns, 5.0 + radius);
    iteration_ns = products * (kSpringProduct * load.springs + kContactProduct * contacts);
  } else {
    iteration_ns =
        kSpringJacobian * load.springs + kContactJacobian * contacts + kFillEntry * load.fill;
  }
  return 1e-6 * substeps * (detection_ns + kNewtonIterations * iteration_ns);
}

}  // namespace stillgrid::dynamics
