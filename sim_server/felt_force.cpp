#include "sim_server/felt_force.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "shared/realtime/percentile.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/rendering/force_error.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/velocity_estimator.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::sim_server {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;
constexpr double kSettlePeriod_s = 0.01;

double to_s(std::uint64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

/// The tool as haptic_server takes it from a device.
class FollowedHand {
 public:
  const rendering::ToolPose& follow(const HandPose& hand, std::uint64_t now_ns) {
    pose_.position_m = hand.position_m;
    pose_.orientation = hand.orientation;
    pose_.velocity_m_s = velocity_.update(now_ns, hand.position_m);
    pose_.angular_velocity_rad_s = angular_velocity_.update(now_ns, hand.orientation);
    return pose_;
  }

 private:
  rendering::ToolPose pose_;
  rendering::VelocityEstimator velocity_;
  rendering::AngularVelocityEstimator angular_velocity_;
};

/// The method that the truth is simulated by: no method of the scene's own is its own judge.
scene::SceneDescription reference_of(const scene::SceneDescription& scene) {
  scene::SceneDescription reference = scene;
  reference.method = {};
  reference.choose_method = false;
  reference.period_s = 1e-3;
  return reference;
}

StartState settled(const scene::SceneDescription& scene, const bodies::World& start,
                   double deadline_s, const CostClock& now_s) {
  dynamics::Simulation simulation(reference_of(scene), start);
  const auto steps = std::lround(scene.hand->settle_s / kSettlePeriod_s);
  for (long i = 0; i < steps && now_s() < deadline_s; ++i)
    (void)simulation.step(kSettlePeriod_s, [] { return std::nullopt; },
                          {.iterations = kMaxIterations});
  StartState end{.world = simulation.world(), .contacts = simulation.contact_state()};
  // Whoever goes on from here has yet to find out who rests.
  for (bodies::BodyRange& body : end.world.bodies) body.is_sleeping = false;
  bodies::number_unknowns(end.world);
  return end;
}

void take_costs(const std::vector<double>& step_s, double period_s, FeltForce& felt) {
  if (step_s.empty() || felt.force_N.empty()) return;
  double sum_s = 0.0;
  for (const double one_s : step_s) sum_s += one_s;
  felt.processor_share = sum_s / (static_cast<double>(felt.force_N.size()) * to_s(kTick_ns));
  felt.slow_step_share = realtime::percentile(step_s, 0.95) / period_s;
}

}  // namespace

FeltForce felt_force(const scene::SceneDescription& scene, const StartState& start,
                     const HandPath& hand, const FeltOptions& options, const CostClock& now_s) {
  LockstepSimulation simulation(
      scene, start.world, {scene.period_s, 0.0, 1, options.latency_s, options.first_share}, now_s);
  simulation.simulation().set_contact_state(start.contacts);
  const publication::SceneView view = simulation.view();
  const auto renderer = rendering::make_renderer(options.transition);
  FollowedHand tool;
  std::optional<dynamics::ToolSample> sample;
  const auto take_tool = [&sample] { return sample; };
  FeltForce felt;
  const std::uint64_t end_ns = realtime::to_ns(options.duration_s);
  try {
    for (std::uint64_t now_ns = 0; now_ns < end_ns; now_ns += kTick_ns) {
      simulation.run_to(now_ns, false, take_tool);
      const rendering::ToolPose& pose = tool.follow(hand.at(to_s(now_ns)), now_ns);
      sample = {now_ns, pose.position_m, pose.orientation, pose.velocity_m_s};
      simulation.run_to(now_ns, true, take_tool);
      const rendering::ToolForce force = renderer->render(view, pose, now_ns).force;
      felt.force_N.push_back(force.force_N);
      felt.touches.push_back(force.contacts > 0 || force.force_N != Eigen::Vector3d::Zero());
      if (now_s() <= options.deadline_s) continue;
      felt.failure = "out of time";
      break;
    }
  } catch (const std::domain_error&) {  // a place that is no number
    felt.failure = "unstable";
  }
  take_costs(simulation.step_s(), scene.period_s, felt);
  return felt;
}

TrueForce true_force(const scene::SceneDescription& scene, const bodies::World& start,
                     const HandPath& hand, double deadline_s, const CostClock& now_s) {
  TrueForce truth{.start = settled(scene, start, deadline_s, now_s), .felt = {}};
  truth.felt = felt_force(reference_of(scene), truth.start, hand,
                          {.transition = display::Transition::kHold,
                           .duration_s = hand.duration_s(),
                           .deadline_s = deadline_s},
                          now_s);
  return truth;
}

double force_error_share(const FeltForce& force, const FeltForce& truth) {
  rendering::ForceError error;
  for (std::size_t i = 0; i < std::min(force.force_N.size(), truth.force_N.size()); ++i)
    if (force.touches[i] || truth.touches[i]) error.add(force.force_N[i], truth.force_N[i]);
  return error.ticks() > 0 ? error.share() : -1.0;
}

}  // namespace stillgrid::sim_server
