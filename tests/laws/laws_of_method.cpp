// Laws of methods: refinement, and vectors of any width.

#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "tests/laws/law.hpp"
#include "tests/laws/moved_scene.hpp"

namespace stillgrid::laws {
namespace {

using Centres = std::vector<Eigen::Vector3d>;

/// All nodes and rigid bodies after the case's duration, in so many steps, each a substep.
std::vector<Eigen::Vector3d> end_of(scene::SceneDescription scene, double duration_s, int steps) {
  scene.method.substeps = 1;
  scene.method.tolerance_m_s = 1e-12;
  dynamics::Simulation simulation(scene);
  for (int step = 0; step < steps; ++step)
    (void)simulation.step(duration_s / steps, [] { return std::nullopt; });
  std::vector<Eigen::Vector3d> places;
  for (const bodies::Node& node : simulation.world().nodes) places.push_back(node.position_m);
  for (const bodies::RigidBody& body : simulation.world().rigid_bodies) {
    places.push_back(body.position_m);
    places.push_back(body.orientation * Eigen::Vector3d(0.01, 0.02, 0.0));
  }
  return places;
}

/// With dampers Verlet is of first order (docs/algorithms/explicit_step.md).
int order_of(const scene::SceneDescription& scene) {
  const scene::IntegratorKind kind = scene.method.integrator;
  const auto is_damped = [](const bodies::BodyDescription& body) {
    const bodies::SpringDescription* springs = bodies::springs_of(body);
    return springs != nullptr && springs->spring_damping_N_s_per_m > 0.0;
  };
  const bool is_second = kind == scene::IntegratorKind::kVelocityVerlet &&
                         std::none_of(scene.bodies.begin(), scene.bodies.end(), is_damped);
  return is_second ? 2 : 1;
}

/// Steps by error: a tenth of the tolerance leaves less error.
Finding tolerance_converges(scene::SceneDescription scene, const LawCase& law_case) {
  const auto at = [&](double tolerance_m_s) {
    scene.method.tolerance_m_s = tolerance_m_s;
    return laws::end_of(scene, law_case, {});
  };
  constexpr double kLeast_m = 3e-8;  // 1e-7 m/s in each step, where the coarse run errs by no more
  const Centres exact = at(1e-11);
  const double coarse_m = farthest_m(at(1e-4), exact), fine_m = farthest_m(at(1e-7), exact);
  return {.measured = fine_m,
          .allowed = std::max(kLeast_m, 0.2 * coarse_m),
          .what = "m of error at 1e-7; allowed: a fifth of that at 1e-4"};
}

}  // namespace

Finding refinement_converges(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  if (scene::chooses_steps(scene.method.integrator)) return tolerance_converges(scene, law_case);
  constexpr int kSteps = 64;
  const double duration_s = law_case.duration_s;
  // Another method's own, so that what one of them leaves out shows.
  scene::SceneDescription verlet = scene;
  verlet.method = {.integrator = scene::IntegratorKind::kVelocityVerlet};
  const Centres exact = end_of(verlet, duration_s, 128 * kSteps);
  double coarse_m = std::numeric_limits<double>::infinity();
  try {
    coarse_m = farthest_m(end_of(scene, duration_s, kSteps), exact);
  } catch (const std::domain_error&) {  // a place that is no number
  }
  const double fine_m = farthest_m(end_of(scene, duration_s, 4 * kSteps), exact);
  if (!std::isfinite(coarse_m) || coarse_m > 0.01)
    return {.applies = false, .what = "steps are beyond stability"};
  const int order = order_of(scene);
  // Of order p an error falls to 4^-p: order 1 instead of 2 leaves a quarter. Of first order, modes
  // that are faster than the step are still far from that.
  constexpr double kReference_m = 5e-7;
  const double share = order == 2 ? 0.15 : 0.7;
  return {.measured = fine_m,
          .allowed = std::max(share * coarse_m, kReference_m),
          .what = "m of error at a quarter of the step, order " + std::to_string(order) +
                  "; allowed: " + short_number(share) + " of that at the step"};
}

Finding every_vector_alike(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  const ToolPaths paths = tool_paths_of(law_case);
  const auto end_with = [&](std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return laws::end_of(scene, law_case, paths);
  };
  const std::int64_t all = hwy::SupportedTargets() & HWY_TARGETS;
  const Centres widest = end_with(all);
  Finding finding;
  const bool solves = !scene::is_explicit(scene.method.integrator);
  finding.allowed = std::max({1e-8, 100.0 * rounding_m(scene, law_case, paths),
                              solves ? 100.0 * scene.method.tolerance_m_s : 0.0});
  int tried = 0;
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1, ++tried) {
    const std::int64_t target = rest & -rest;
    const double apart_m = farthest_m(end_with(target), widest);
    if (!(apart_m < finding.measured)) {
      finding.measured = apart_m;
      finding.what = std::string("m between centres, ") + hwy::TargetName(target);
    }
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  finding.what += ", " + std::to_string(tried) + " targets";
  return finding;
}

}  // namespace stillgrid::laws
