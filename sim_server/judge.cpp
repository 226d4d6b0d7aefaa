#include "sim_server/judge.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim_server/dynamics/choice/counted_work.hpp"
#include "sim_server/scene/build_world.hpp"

namespace stillgrid::sim_server {
namespace {

constexpr double kRateShare = 0.7;  // of the period, for 19 of 20 steps
constexpr double kLateFrom = 0.05;  // of the period: faster steps are not felt to be late
constexpr double kHopeless = 1.0;   // processors: a candidate that needs more is not run to its end
constexpr double kBeside_m = 1e-6;

/// Moves a world to where another is. Returns false for a world of other bodies.
bool put_to(bodies::World& world, const bodies::World& to) {
  if (world.nodes.size() != to.nodes.size() || world.rigid_bodies.size() != to.rigid_bodies.size())
    return false;
  for (std::size_t i = 0; i < to.nodes.size(); ++i) {
    world.nodes[i].position_m = to.nodes[i].position_m;
    world.nodes[i].velocity_m_s = to.nodes[i].velocity_m_s;
  }
  for (std::size_t i = 0; i < to.rigid_bodies.size(); ++i) {
    bodies::RigidBody& body = world.rigid_bodies[i];
    const bodies::RigidBody& from = to.rigid_bodies[i];
    body.position_m = from.position_m;
    body.orientation = from.orientation;
    body.velocity_m_s = from.velocity_m_s;
    body.angular_velocity_rad_s = from.angular_velocity_rad_s;
  }
  world.time_s = to.time_s;
  return true;
}

}  // namespace

scene::SceneDescription true_scene(scene::SceneDescription scene, double rate_hz) {
  scene.method = {.integrator = scene::IntegratorKind::kVelocityVerlet};
  scene.period_s = 1.0 / rate_hz;
  return scene;
}

HandRun Judge::truth_at(double rate_hz, double beside_m) const {
  const scene::SceneDescription scene = true_scene(scene_, rate_hz);
  return run_hand(scene, settled(scene, rest_), hand_,
                  {.transition = display::Transition::kHold,
                   .duration_s = hand_.duration_s(),
                   .beside_m = beside_m,
                   .has_engine_friction = true});
}

Judge::Judge(const scene::SceneDescription& scene)
    : hand_(scene.hand->file, scene.device), scene_(scene) {
  try {
    const scene::SceneDescription falls = true_scene(scene, 0.5 * kTruth_hz);
    rest_ = settled(falls, scene::build_world(falls)).world;
    truth_.run = truth_at(kTruth_hz, 0.0);
  } catch (const std::domain_error&) {
    truth_.run.failure = "unstable";
  }
  if (truth_.run.failure == "unstable") throw std::runtime_error("no truth: the scene is unstable");
  const HandRun coarse = truth_at(0.5 * kTruth_hz, kBeside_m);
  truth_.error_share = std::max(0.0, force_error_share(coarse, truth_.run));
}

double Judge::watched_s() const noexcept {
  return 1e-3 * static_cast<double>(truth_.run.force_N.size());
}

/// A world of other bodies than the truth's falls from its own start.
StartState Judge::rest_of(const scene::SceneDescription& scene) const {
  bodies::World world = scene::build_world(scene);
  put_to(world, rest_);
  return settled(scene, world, kHopeless * dynamics::kWorkPerProcessor_ms);
}

Record Judge::judge(const Candidate& candidate, const StartState& start) const {
  const double period_s = candidate.scene.period_s;
  Record record = candidate.record;
  record.truth_error_share = truth_.error_share;
  record.spheres = start.world.spheres.size() + start.world.static_spheres.size();
  HandRunOptions options{.transition = candidate.transition,
                         .duration_s = watched_s(),
                         .most_work_per_ms = kHopeless * dynamics::kWorkPerProcessor_ms};
  const auto run = [&] {
    HandRun felt = run_hand(candidate.scene, start, hand_, options);
    record.work_per_ms = std::max(record.work_per_ms, felt.work_per_ms());
    record.refusal = felt.failure;
    return felt;
  };
  const double slow_share = run().slow_step_share(period_s);  // asks only how late steps are
  if (slow_share > kRateShare && record.refusal.empty()) record.refusal = "cannot keep its rate";
  if (slow_share >= kLateFrom) record.latency_share = std::ceil(10.0 * slow_share) / 10.0;
  options.latency_s = record.latency_share * period_s;
  // Steps of a millisecond begin with the ticks, wherever they are.
  const int runs = std::clamp(static_cast<int>(std::lround(1e3 * period_s)), 1, kRuns);
  for (int i = 0; i < runs && record.refusal.empty(); ++i) {
    options.first_share = 1.0 - static_cast<double>(i) / runs;
    const double error = force_error_share(run(), truth_.run);
    if (error >= 0.0 && record.refusal.empty())
      record.error_share = std::max(record.error_share.value_or(0.0), error);
  }
  return record;
}

Record Judge::judge(const Candidate& candidate) const {
  try {
    return judge(candidate, rest_of(candidate.scene));
  } catch (const std::domain_error&) {
    Record record = candidate.record;
    record.refusal = "unstable";
    return record;
  }
}

}  // namespace stillgrid::sim_server
