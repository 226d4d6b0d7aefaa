#include "sim_server/dynamics/choice/counted_work.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "shared/dynamics/engine.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"

namespace stillgrid::dynamics {
namespace {

// Weights of one operation, in evaluations of a spring outside of a sheet.
constexpr double kSheetSpring = 0.4, kContact = 43.0, kJoint = 67.0, kStep = 270.0;
constexpr double kDetection = 6.0, kSphereShown = 2.0;  // of a moving sphere, in a part or a step
// Of a linear system: contacts and joints, springs, their products with a vector, what is fixed.
constexpr double kLinearisedContact = 130.0, kLinearisedSpring = 8.0;
constexpr double kContactProduct = 9.0, kSpringProduct = 0.85, kImplicitStep = 1000.0;

/// Work of an implicit step, without detection. A joint resists as a contact that touches does.
double implicit_work(const SceneLoad& load, double iterations, double products, double contacts) {
  const double rest = contacts + load.joints;
  return kImplicitStep +
         iterations * (kLinearisedSpring * load.springs + kLinearisedContact * rest) +
         products * (kSpringProduct * load.springs + kContactProduct * rest);
}

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
  const int ticks = ticks_of(step_s);
  return ticks *
         stable_substeps(SpectrumBound{load.spring_rad_s * load.spring_rad_s, load.damping_1_s},
                         step_s / ticks);
}

double work_of(const SceneLoad& load, const scene::Method& method, const StepCounts& counts) {
  const double shown = kSphereShown * load.spheres;
  const double detection = counts.parts * kDetection * load.spheres;
  if (!scene::is_explicit(method.integrator))
    return shown + detection +
           implicit_work(load, counts.iterations, counts.products, counts.contacts);
  const double springs = kSheetSpring * load.sheet_springs + (load.springs - load.sheet_springs);
  return shown + detection + kStep +
         counts.iterations * (springs + kContact * counts.contacts + kJoint * load.joints);
}

MethodChoice choose_method(const SceneLoad& load, double step_s) {
  const int ticks = ticks_of(step_s), substeps = taken_substeps(load, step_s) / ticks;
  const bool is_stiff = substeps > kMaxSubsteps;
  std::array<char, 200> why{};
  std::snprintf(why.data(), why.size(),
                "springs of %.3g rad/s divide a tick of %.4g ms into %d substeps of "
                "velocity_verlet, %s %d",
                load.spring_rad_s, 1e3 * step_s / ticks, substeps,
                is_stiff ? "more than" : "at most", kMaxSubsteps);
  return {{.integrator = is_stiff ? scene::IntegratorKind::kImplicitEuler
                                  : scene::IntegratorKind::kVelocityVerlet},
          why.data()};
}

void settle_step(scene::SceneDescription& scene, const bodies::World& world) {
  constexpr double kPeriod_s = 1e-3, kTouchingPerSphere = 1.0 / 12.0;
  if (scene.names_step) return;
  const scene::Method verlet{.integrator = scene::IntegratorKind::kVelocityVerlet};
  const SceneLoad load = load_of(world);
  const double work = work_of(load, verlet,
                              {.iterations = static_cast<double>(taken_substeps(load, kPeriod_s)),
                               .contacts = kTouchingPerSphere * load.spheres});
  if (work > 0.25 * kWorkPerProcessor_ms) return;
  scene.period_s = kPeriod_s;
  scene.method = verlet;
}

}  // namespace stillgrid::dynamics
