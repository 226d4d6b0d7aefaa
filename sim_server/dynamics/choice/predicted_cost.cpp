#include "sim_server/dynamics/choice/predicted_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/dynamics/engine.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"

namespace stillgrid::dynamics {
namespace {

// Costs of one operation, ns.
constexpr double kSheetSpringForce = 1.3, kSpringForce = 5.8, kNodeStep = 2.0;
constexpr double kContactForce = 300.0, kJointForce = 60.0, kRigidStep = 100.0;
constexpr double kDetection = 60.0;  // a moving sphere in a step
constexpr double kContactJacobian = 1000.0;
constexpr double kSpringProduct = 3.5, kContactProduct = 100.0;
constexpr double kSpringLinearised = 45.0;  // residuals along a step included

}  // namespace

SceneLoad load_of(const bodies::World& world) {
  SceneLoad load;
  load.springs = static_cast<double>(world.springs.size());
  load.nodes = static_cast<double>(world.nodes.size());
  load.spheres = static_cast<double>(world.spheres.size());
  load.joints = static_cast<double>(world.joints.size());
  const DescribedWorld vibrates = described_without_spheres(world);
  JointBound joints(vibrates.description);
  const SpectrumBound bound =
      spring_bound(vibrates.description) + joints(vibrates.description, vibrates.state, 0.0);
  load.spring_rad_s = std::sqrt(bound.stiffness_per_s2);
  load.damping_1_s = bound.damping_per_s;
  for (const bodies::BodyRange& body : world.bodies) {
    if (body.sheet_nodes.prod() > 0) load.sheet_springs += body.spring_count;
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

double stable_step_s(const SceneLoad& load) {
  const double stiffness =
      load.spring_rad_s * load.spring_rad_s + load.contact_rad_s * load.contact_rad_s;
  if (!(stiffness > 0.0)) return std::numeric_limits<double>::infinity();
  const double half = load.damping_1_s / stiffness;
  return std::sqrt(half * half + 4.0 / stiffness) - half;
}

int stable_substeps(const SceneLoad& load, double step_s) {
  constexpr double kSpare = 1.1, kMax = 1e9;
  return static_cast<int>(std::clamp(std::ceil(kSpare * step_s / stable_step_s(load)), 1.0, kMax));
}

int taken_substeps(const SceneLoad& load, double step_s) {
  const double ticks = std::max(1.0, std::ceil(step_s / kTick_s - 1e-9));
  return static_cast<int>(ticks) *
         stable_substeps(SpectrumBound{load.spring_rad_s * load.spring_rad_s, load.damping_1_s},
                         step_s / ticks);
}

double cost_ms(const SceneLoad& load, const scene::Method& method, const StepWork& work) {
  const double springs_ns =
      kSheetSpringForce * load.sheet_springs + kSpringForce * (load.springs - load.sheet_springs);
  const double detection_ns = work.parts * kDetection * load.spheres;
  if (scene::is_explicit(method.integrator))
    return 1e-6 *
           (detection_ns +
            work.iterations * (springs_ns + kNodeStep * load.nodes + kContactForce * work.contacts +
                               kJointForce * load.joints + kRigidStep * load.rigid_bodies));
  // A joint resists as a contact that touches does.
  const double rest = work.contacts + load.joints;
  return 1e-6 * (detection_ns +
                 work.iterations * (kSpringLinearised * load.springs + kContactJacobian * rest) +
                 work.products * (kSpringProduct * load.springs + kContactProduct * rest));
}

}  // namespace stillgrid::dynamics
