#include "sim_server/felt_force.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "shared/publication/scene_segment.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/rendering/force_error.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/velocity_estimator.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::sim_server {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;
constexpr double kSettlePeriod_s = 0.01;

double to_s(std::uint64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

std::string unique_session() {
  static std::atomic<int> count = 0;
  return "rate-" + std::to_string(::getpid()) + "-" + std::to_string(++count);
}

publication::SceneView view_of(const std::string& session) {
  auto reader = publication::SegmentReader::open(session, proto::SegmentKind::kScene,
                                                 proto::kSceneLayoutHash);
  if (!reader) throw publication::SegmentError("the session '" + session + "' is gone");
  return publication::SceneView(std::move(*reader));
}

/// The simulation's side: steps that are due, and their snapshots.
class Published {
 public:
  Published(const scene::SceneDescription& scene, const StartState& start,
            const FeltOptions& options, const std::string& session, const CostClock& now_s)
      : period_s_(scene.period_s),
        now_s_(now_s),
        simulation_(scene, start.world),
        writer_(session, static_scene(scene, simulation_), simulation_.world().spheres.size(),
                realtime::to_ns(scene.period_s), proto::Clock::kVirtual, 0),
        schedule_(scene.period_s, 0.0, 1, options.latency_s, options.first_share),
        snapshot_(schedule_.next()) {
    simulation_.stick(start.sticking);
    writer_.publish(simulation_.snapshot(), {.state_ns = 0, .publish_ns = 0});
  }

  /// Takes the tool for each step that is due before now_ns, or with `at_now` also at that time,
  /// and shows what is due by then.
  void run_to(std::uint64_t now_ns, bool at_now, const std::optional<dynamics::ToolSample>& tool) {
    while (true) {
      if (!times_) {
        if (snapshot_.sample_ns > now_ns || (snapshot_.sample_ns == now_ns && !at_now)) return;
        step(tool);
      }
      if (times_->publish_ns > now_ns) return;
      const double began_s = now_s_();
      writer_.publish(simulation_.snapshot(), *times_, prediction_);
      step_s_.back() += now_s_() - began_s;
      times_.reset();
      snapshot_ = schedule_.next();
    }
  }

  /// Of each step with its snapshot.
  [[nodiscard]] const std::vector<double>& step_s() const noexcept { return step_s_; }

 private:
  void step(const std::optional<dynamics::ToolSample>& tool) {
    const double began_s = now_s_();
    const dynamics::StepReport report = simulation_.step(
        to_s(snapshot_.step_ns), [&tool] { return tool; }, {.iterations = kMaxIterations});
    times_ = times_of(snapshot_, report);
    prediction_ = simulation_.predict_next(period_s_);
    step_s_.push_back(now_s_() - began_s);
  }

  double period_s_;
  const CostClock& now_s_;
  dynamics::Simulation simulation_;
  publication::SceneWriter writer_;
  LockstepSchedule schedule_;
  ScheduledSnapshot snapshot_;                       // the next, or computed and not yet shown
  std::optional<publication::SnapshotTimes> times_;  // of a snapshot that is computed
  publication::SnapshotPrediction prediction_;
  std::vector<double> step_s_;
};

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
  StartState end{.world = simulation.world(), .sticking = simulation.sticking()};
  // Whoever goes on from here has yet to find out who rests.
  for (bodies::BodyRange& body : end.world.bodies) body.is_sleeping = false;
  bodies::number_unknowns(end.world);
  return end;
}

void take_costs(std::vector<double> step_s, double period_s, FeltForce& felt) {
  if (step_s.empty() || felt.force_N.empty()) return;
  double sum_s = 0.0;
  for (const double one_s : step_s) sum_s += one_s;
  felt.processor_share = sum_s / (static_cast<double>(felt.force_N.size()) * to_s(kTick_ns));
  const auto slow =
      step_s.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(step_s.size() - 1));
  std::nth_element(step_s.begin(), slow, step_s.end());
  felt.slow_step_share = *slow / period_s;
}

}  // namespace

FeltForce felt_force(const scene::SceneDescription& scene, const StartState& start,
                     const HandPath& hand, const FeltOptions& options, const CostClock& now_s) {
  const std::string session = unique_session();
  Published simulation(scene, start, options, session, now_s);
  const publication::SceneView view = view_of(session);
  const auto renderer = rendering::make_renderer(options.transition);
  FollowedHand tool;
  std::optional<dynamics::ToolSample> sample;
  FeltForce felt;
  const std::uint64_t end_ns = realtime::to_ns(options.duration_s);
  try {
    for (std::uint64_t now_ns = 0; now_ns < end_ns; now_ns += kTick_ns) {
      simulation.run_to(now_ns, false, sample);
      const rendering::ToolPose& pose = tool.follow(hand.at(to_s(now_ns)), now_ns);
      sample = {now_ns, pose.position_m, pose.orientation, pose.velocity_m_s};
      simulation.run_to(now_ns, true, sample);
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
