#include "tests/laboratory/rivals/shipped_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/dynamics/implicit_step.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/dynamics/ticks/ticked_world.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr double kSameTime_s = 1e-7;
constexpr double kTolerance_m_s = 1e-10;
constexpr double kPush_N = 1e-3;  // contacts do not open or close by it

/// Adds what a push on a sphere during step_s makes of its body's momentum.
void push(const bodies::SphereBinding& sphere, const Eigen::Vector3d& impulse_N_s,
          bodies::World& world) {
  if (sphere.rigid >= 0) {
    bodies::RigidBody& body = world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)];
    if (!body.free) return;
    body.velocity_m_s += impulse_N_s / body.mass_kg;
    const Eigen::Vector3d angular_impulse_N_m_s =
        sphere.local_m.cross(body.orientation.conjugate() * impulse_N_s);
    body.angular_velocity_rad_s +=
        body.orientation * angular_impulse_N_m_s.cwiseQuotient(body.inertia_kg_m2).eval();
    return;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(sphere.node_count); ++i) {
    bodies::Node& node = world.nodes[static_cast<std::size_t>(sphere.nodes[i])];
    if (!node.pinned) node.velocity_m_s += sphere.weights[i] / node.mass_kg * impulse_N_s;
  }
}

/// The world after an implicit step without a tool.
bodies::World stepped(bodies::World world, double step_s) {
  dynamics::TickedWorld ticked(world, {}, false, dynamics::implicit_euler(kTolerance_m_s));
  (void)ticked.advance({step_s, step_s, 1, {}});
  (void)ticked.write_to(world);
  return world;
}

}  // namespace

void ShippedSteps::take(const dynamics::Simulation& simulation) {
  Step& step = steps_[taken_++ % steps_.size()];
  step.world = simulation.world();
  step.step_s = step.world.time_s - end_s_;
  end_s_ = step.world.time_s;
}

Eigen::MatrixXd ShippedSteps::compliance_m_per_N(std::uint64_t state_time_ns,
                                                 std::span<const Push> pushes) const {
  const auto count = static_cast<Eigen::Index>(pushes.size());
  Eigen::MatrixXd compliance = Eigen::MatrixXd::Zero(count, count);
  const double time_s = 1e-9 * static_cast<double>(state_time_ns);
  const auto* const step = std::find_if(steps_.begin(), steps_.end(), [&](const Step& shipped) {
    return shipped.step_s > 0.0 && std::abs(shipped.world.time_s - time_s) < kSameTime_s;
  });
  if (step == steps_.end()) return compliance;

  const bodies::World still = stepped(step->world, step->step_s);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Push& pushed = pushes[static_cast<std::size_t>(j)];
    bodies::World world = step->world;
    push(world.spheres[pushed.sphere], step->step_s * kPush_N * pushed.direction, world);
    world = stepped(std::move(world), step->step_s);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Push& along = pushes[static_cast<std::size_t>(i)];
      const bodies::SphereBinding& sphere = still.spheres[along.sphere];
      const Eigen::Vector3d change_m_s = bodies::sphere_motion(world, sphere).velocity_m_s -
                                         bodies::sphere_motion(still, sphere).velocity_m_s;
      compliance(i, j) = step->step_s / kPush_N * along.direction.dot(change_m_s);
    }
  }
  return 0.5 * (compliance + compliance.transpose());
}

}  // namespace stillgrid::laboratory
