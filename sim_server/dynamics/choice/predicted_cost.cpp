#include "sim_server/dynamics/choice/predicted_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_server/dynamics/forces/explicit_joints.hpp"
#include "sim_server/dynamics/forces/spring_bound.hpp"

namespace stillgrid::dynamics {
namespace {

// Costs of one operation, ns.
constexpr double kSheetSpringForce = 1.3, kSpringForce = 5.8, kNodeStep = 2.0;
constexpr double kContactForce = 50.0, kJointForce = 60.0, kRigidStep = 100.0;
constexpr double kDetection = 60.0;  // a moving sphere in a step
constexpr double kSpringJacobian = 60.0, kContactJacobian = 1000.0, kFillEntry = 8.0;
constexpr double kSpringProduct = 3.5, kContactProduct = 100.0;
constexpr double kSpringLinearised = 45.0;  // residuals along a step included
constexpr double kProducts = 14.0;          // of one iteration of Newton's method
constexpr double kCurve = 2.5;              // springs a node at most
constexpr double kSolid_ns = 12e6, kSolidNodes = 441.0, kSolidPower = 2.6;  // factors of a solid

/// What factors of one body's block cost: by the entries of a curve's bandwidth, by those of a
/// surface, n log n; a solid's by the products that make them, as measured.
double factor_ns_of(const bodies::BodyRange& body) {
  const double n = body.node_count;
  if (body.rigid >= 0) return kFillEntry * 36.0;
  if (body.node_count == 0) return 0.0;
  const double per_node = static_cast<double>(body.spring_count) / n;
  if (per_node < kCurve) return kFillEntry * 9.0 * 3.0 * n;
  if (body.sheet_nodes.prod() > 0) return kFillEntry * 9.0 * 4.0 * n * std::log2(n + 1.0);
  return kSolid_ns * std::pow(n / kSolidNodes, kSolidPower);
}

/// Iterations of Newton's method in a step, as measured: where it is long for the springs more of
/// it is bent, most of all of a solid that sags; and where rigid bodies lie on each other.
double newton_iterations(const SceneLoad& load, double step_s) {
  const double fewest = load.rigid_bodies > 1.0 ? 15.0 : 4.0;
  constexpr double kMax = 30.0;
  const double angle = step_s * load.spring_rad_s;
  const bool is_solid = load.solid_springs > 0.5 * load.springs;
  return std::clamp(is_solid ? 0.0048 * std::pow(angle, 2.3) : 0.1 * angle, fewest, kMax);
}

}  // namespace

SceneLoad load_of(const bodies::World& world) {
  SceneLoad load;
  load.springs = static_cast<double>(world.springs.size());
  load.nodes = static_cast<double>(world.nodes.size());
  load.spheres = static_cast<double>(world.spheres.size());
  load.unknowns = world.unknown_count;
  load.joints = static_cast<double>(world.joints.size());
  const SpringRates rates = bound_springs(world), joints = JointSpectrum(world).bound(world, 0.0);
  load.spring_rad_s = std::sqrt(rates.stiffness_per_s2 + joints.stiffness_per_s2);
  load.damping_1_s = rates.damping_per_s + joints.damping_per_s;
  for (const bodies::BodyRange& body : world.bodies) {
    load.factor_ns += factor_ns_of(body);
    const double springs = body.spring_count;
    if (body.sheet_nodes.prod() > 0)
      load.sheet_springs += springs;
    else if (springs > kCurve * body.node_count)
      load.solid_springs += springs;
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

int taken_substeps(const SceneLoad& load, double step_s) {
  constexpr double kContactRatio = 32.0, kMax = 1e9;  // h^2 w^2 of what touches
  const double per_s =
      std::max(substeps_per_s({load.spring_rad_s * load.spring_rad_s, load.damping_1_s}),
               load.contact_rad_s / std::sqrt(kContactRatio));
  return static_cast<int>(std::clamp(std::ceil(step_s * per_s), 1.0, kMax));
}

double predicted_ms(const SceneLoad& load, const scene::Method& method, double step_s) {
  const double contacts = 0.5 * load.spheres, touching = 0.5 * contacts;
  const double detection_ns = kDetection * load.spheres;
  const int given = method.substeps;
  if (scene::is_explicit(method.integrator)) {
    const double substeps = given > 0 ? given : taken_substeps(load, step_s);
    return 1e-6 *
           (detection_ns + substeps * (kSheetSpringForce * load.sheet_springs +
                                       kSpringForce * (load.springs - load.sheet_springs) +
                                       kNodeStep * load.nodes + kContactForce * contacts +
                                       kJointForce * load.joints + kRigidStep * load.rigid_bodies));
  }
  // A joint resists as a contact that touches does.
  const double rest = touching + load.joints;
  const double substeps = std::max(1, given);
  const double iterations = newton_iterations(load, step_s / substeps);
  double iteration_ns = 0.0;
  if (!method.solver.factorises) {
    const double products = std::min(load.unknowns, kProducts);
    iteration_ns = kSpringLinearised * load.springs + kContactJacobian * rest +
                   products * (kSpringProduct * load.springs + kContactProduct * rest);
  } else {
    iteration_ns = kSpringJacobian * load.springs + kContactJacobian * rest + load.factor_ns;
  }
  return 1e-6 * substeps * (detection_ns + iterations * iteration_ns);
}

}  // namespace stillgrid::dynamics
