#include "tests/laboratory/rivals/shipped_step.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "sim_server/contact/predicted_contacts.hpp"
#include "sim_server/dynamics/forces/implicit_stage.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/solvers/linear_solver.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr double kSameTime_s = 1e-7;
constexpr double kAccuracy = 1e-6;

}  // namespace

void ShippedSteps::take(const dynamics::Simulation& simulation) {
  Step& step = steps_[taken_++ % steps_.size()];
  step.world = simulation.world();
  step.step_s = step.world.time_s - end_s_;
  end_s_ = step.world.time_s;
  std::vector<std::uint32_t> all(step.world.spheres.size());
  std::iota(all.begin(), all.end(), 0U);
  contact::PredictedContacts search;
  step.contacts.clear();
  if (search.find(step.world, simulation.detection(), all, 0.0, {}))
    step.contacts = search.contacts();
}

Eigen::MatrixXd ShippedSteps::compliance_m_per_N(std::uint64_t state_time_ns,
                                                 std::span<const Push> pushes) const {
  const auto count = static_cast<Eigen::Index>(pushes.size());
  Eigen::MatrixXd compliance = Eigen::MatrixXd::Zero(count, count);
  const double time_s = 1e-9 * static_cast<double>(state_time_ns);
  const auto* const step = std::find_if(steps_.begin(), steps_.end(), [&](const Step& shipped) {
    return shipped.step_s > 0.0 && std::abs(shipped.world.time_s - time_s) < kSameTime_s;
  });
  if (step == steps_.end() || step->world.unknown_count == 0) return compliance;

  dynamics::MechanicalSystem system(step->world, step->contacts);
  dynamics::ImplicitStage stage(system, step->step_s);
  const Eigen::VectorXd velocity = stage.initial_guess();
  const Eigen::VectorXd nowhere = Eigen::VectorXd::Zero(system.size());
  dynamics::KrylovLinearSolver solver;
  Eigen::VectorXd change;
  system.place(nowhere, velocity, 0.0);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Push& push = pushes[static_cast<std::size_t>(j)];
    Eigen::VectorXd force = nowhere;
    system.push_sphere(step->world.spheres[push.sphere], push.direction, Eigen::Vector3d::Zero(),
                       force);
    if (force.isZero(0.0) || !solver.solve(stage, dynamics::JacobianKind::kDefinite,
                                           step->step_s * force, kAccuracy, {}, change))
      continue;
    for (Eigen::Index i = 0; i < count; ++i) {  // `change`: velocities that a newton makes
      const Push& along = pushes[static_cast<std::size_t>(i)];
      compliance(i, j) = step->step_s * along.direction.dot(system.velocity_of(
                                            step->world.spheres[along.sphere], change));
    }
  }
  return 0.5 * (compliance + compliance.transpose());
}

}  // namespace stillgrid::laboratory
