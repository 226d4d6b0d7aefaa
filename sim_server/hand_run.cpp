#include "sim_server/hand_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "shared/dynamics/engine.hpp"
#include "shared/publication/tool_segment.hpp"
#include "shared/realtime/percentile.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/rendering/force_error.hpp"
#include "shared/rendering/local_copy.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/velocity_estimator.hpp"
#include "sim_server/dynamics/choice/counted_work.hpp"
#include "sim_server/lockstep_simulation.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::sim_server {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;
constexpr double kFirst_ms = 100.0;  // not judged by its cost

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

bool divides_itself(const scene::Method& method) {
  return scene::is_explicit(method.integrator) && method.substeps == 0;
}

double work_of_step(const dynamics::SceneLoad& load, const scene::SceneDescription& scene,
                    const dynamics::StepReport& report) {
  const int ticks = dynamics::ticks_of(scene.period_s);
  return dynamics::work_of(
      load, scene.method,
      {.parts = static_cast<double>(divides_itself(scene.method) ? ticks : report.substeps),
       .iterations = static_cast<double>(report.solve.iterations),
       .products = static_cast<double>(report.solve.products),
       .contacts = static_cast<double>(report.contacts)});
}

proto::ToolState state_of(const rendering::ToolPose& pose, std::uint64_t now_ns) {
  const auto array = [](const Eigen::Vector3d& v) { return std::array{v.x(), v.y(), v.z()}; };
  const Eigen::Quaterniond& q = pose.orientation;
  proto::ToolState state{};
  state.time_ns = now_ns;
  state.path_number = now_ns / proto::kPathTick_ns;
  state.position_m = array(pose.position_m);
  state.orientation_xyzw = {q.x(), q.y(), q.z(), q.w()};
  state.velocity_m_s = array(pose.velocity_m_s);
  return state;
}

/// A step shorter than a tick gets a sample of its own: otherwise the tool would move in jerks.
std::uint64_t samples_per_tick(double period_s) {
  constexpr double kRounding = 1e-6;
  return static_cast<std::uint64_t>(
      std::max(1.0, std::ceil(1e-9 * static_cast<double>(kTick_ns) / period_s - kRounding)));
}

}  // namespace

double HandRun::work_per_ms() const {
  return force_N.empty() ? 0.0 : all_work / static_cast<double>(force_N.size());
}

double HandRun::slow_step_share(double period_s) const {
  if (step_work.empty()) return 0.0;
  return realtime::percentile(step_work, 0.95) / (1e3 * period_s * dynamics::kWorkPerProcessor_ms);
}

double rest_step_s(const scene::SceneDescription& scene) {
  return divides_itself(scene.method) ? scene.period_s / dynamics::ticks_of(scene.period_s)
                                      : scene.period_s;
}

StartState settled(scene::SceneDescription scene, const bodies::World& start,
                   double most_work_per_ms) {
  scene.period_s = rest_step_s(scene);
  dynamics::Simulation simulation(scene, start);
  const dynamics::SceneLoad load = dynamics::load_of(start);
  const auto steps = std::lround((scene.hand ? scene.hand->settle_s : 0.0) / scene.period_s);
  double work = 0.0;
  for (long i = 0;
       i < steps && work <= most_work_per_ms * (kFirst_ms + 1e3 * scene.period_s * double(i)); ++i)
    work += work_of_step(load, scene, simulation.step(scene.period_s, [] { return std::nullopt; }));
  StartState end{simulation.world(), simulation.contact_state()};
  // A simulation that goes on from here has yet to find out which bodies rest.
  for (bodies::BodyRange& body : end.world.bodies) body.is_sleeping = false;
  return end;
}

HandRun run_hand(const scene::SceneDescription& scene, const StartState& start,
                 const HandPath& hand, const HandRunOptions& options) {
  LockstepSimulation simulation(scene, start.world,
                                {scene.period_s, 0.0, 1, options.latency_s, options.first_share},
                                {}, start.contacts);
  publication::ToolWriter published(simulation.session(), kTick_ns, proto::Clock::kVirtual, 0);
  const publication::ToolView followed(publication::SegmentReader::require(
      simulation.session(), proto::SegmentKind::kTool, proto::kToolLayoutHash));
  simulation.follow(followed);
  const dynamics::SceneLoad load = dynamics::load_of(start.world);
  const publication::SceneView view = simulation.view();
  const auto renderer = rendering::make_renderer(options.transition);
  const auto local = view.model().empty() ? nullptr : std::make_unique<rendering::LocalCopy>(view);
  FollowedHand tool;
  std::optional<dynamics::ToolSample> sample;
  const auto take_tool = [&sample] { return sample; };
  HandRun run;
  const auto count = [&](const dynamics::Simulation&, const dynamics::StepReport& report) {
    run.step_work.push_back(work_of_step(load, scene, report));
    run.all_work += run.step_work.back();
  };
  const std::uint64_t parts = samples_per_tick(scene.period_s);
  const std::uint64_t end_ns = realtime::to_ns(options.duration_s);
  const auto is_within = [&](std::uint64_t now_ns) {
    return run.all_work <= options.most_work_per_ms * (kFirst_ms + 1e3 * to_s(now_ns));
  };
  try {
    for (std::uint64_t i = 0, now_ns = 0; now_ns < end_ns; now_ns = ++i * kTick_ns / parts) {
      if (!is_within(now_ns)) {
        run.failure = "costs too much";
        break;
      }
      simulation.run_to(now_ns, false, take_tool, count);
      HandPose at = hand.at(to_s(now_ns));
      at.position_m.array() += options.beside_m;
      const rendering::ToolPose& pose = tool.follow(at, now_ns);
      sample = {now_ns, pose.position_m, pose.orientation, pose.velocity_m_s};
      published.publish(state_of(pose, now_ns));
      simulation.run_to(now_ns, true, take_tool, count);
      if (i % parts != 0) continue;
      std::span<const dynamics::Vector4> stretches_m;
      if (options.has_engine_friction) stretches_m = simulation.simulation().stretches_m(0);
      const rendering::ToolForce force =
          renderer->render(view, pose, now_ns, {}, local.get(), stretches_m).force;
      run.force_N.push_back(force.force_N);
      run.touches.push_back(force.contacts > 0 || force.force_N != Eigen::Vector3d::Zero());
    }
  } catch (const std::domain_error&) {
    run.failure = "unstable";
  }
  return run;
}

double force_error_share(const HandRun& run, const HandRun& truth) {
  rendering::ForceError error;
  for (std::size_t i = 0; i < std::min(run.force_N.size(), truth.force_N.size()); ++i)
    if (run.touches[i] || truth.touches[i]) error.add(run.force_N[i], truth.force_N[i]);
  return error.ticks() > 0 ? error.share() : -1.0;
}

}  // namespace stillgrid::sim_server
