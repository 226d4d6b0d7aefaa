#include "shared/tools/laboratory/lab.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <memory>
#include <utility>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/haptic_loop.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/laboratory/path_file.hpp"
#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/published_scene.hpp"
#include "sim_server/scene/build_world.hpp"

namespace stillgrid::laboratory {
namespace {

std::string unique_name() {
  static std::atomic<int> count = 0;
  return "lab-" + std::to_string(::getpid()) + "-" + std::to_string(++count);
}

double processor_s() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bodies::World start_world(const scene::SceneDescription& scene, const WorldState* start) {
  bodies::World world = scene::build_world(scene);
  if (start != nullptr) set_state(world, *start);
  return world;
}

template <class View>
View view_of(const std::string& session, proto::SegmentKind kind, std::uint64_t layout_hash) {
  auto reader = publication::SegmentReader::open(session, kind, layout_hash);
  if (!reader)
    throw publication::SegmentError("the laboratory's own session '" + session + "' is gone");
  return View(std::move(*reader));
}

/// sim_server's lockstep without a peer to wait for: the caller knows what time it is.
class SimulationSide {
 public:
  SimulationSide(const scene::SceneDescription& scene, const LabOptions& options,
                 const std::string& session, LabRun& run)
      : period_s_(scene.period_s),
        measures_(options.measures_ticks),
        state_interval_s_(options.state_interval_s),
        run_(run),
        simulation_(scene, start_world(scene, options.start)),
        writer_(session, sim_server::static_scene(scene, simulation_),
                simulation_.world().spheres.size(), realtime::to_ns(scene.period_s),
                proto::Clock::kVirtual, 0),
        schedule_(scene.period_s, options.jitter, options.seed, options.latency_s),
        snapshot_(schedule_.next()) {
    writer_.publish(simulation_.snapshot(), {.state_ns = 0, .publish_ns = 0});
    if (options.accounts_energy) simulation_.account_energy();
    const bodies::World& world = simulation_.world();
    run_.simulation.moving_spheres = world.spheres.size();
    run_.simulation.spheres = world.spheres.size() + world.static_spheres.size();
    start_s_ = world.time_s;
    keep_state();
  }

  /// Takes the tool at each sample that is due before now_ns, or with `at_now` also at that time,
  /// and shows each snapshot due by then.
  void run_to(std::uint64_t now_ns, bool at_now, const publication::ToolView& tool) {
    while (true) {
      if (!times_) {
        if (snapshot_.sample_ns > now_ns || (snapshot_.sample_ns == now_ns && !at_now)) return;
        step(tool);
      }
      if (times_->publish_ns > now_ns) return;
      const double began_s = measures_ ? processor_s() : 0.0;
      writer_.publish(simulation_.snapshot(), *times_, prediction_);
      if (measures_) run_.simulation.step_s.back() += processor_s() - began_s;
      times_.reset();
      snapshot_ = schedule_.next();
    }
  }

  /// To the scene up to the newest state; zero where nobody accounts.
  [[nodiscard]] double given_J() const noexcept { return given_J_; }

 private:
  void step(const publication::ToolView& tool) {
    const double began_s = measures_ ? processor_s() : 0.0;
    const auto take_tool = [&tool]() -> std::optional<dynamics::ToolSample> {
      const auto state = tool.read();
      if (!state) return std::nullopt;
      return sim_server::sample_of(*state);
    };
    const dynamics::StepReport report =
        simulation_.step(static_cast<double>(snapshot_.step_ns) * 1e-9, take_tool,
                         {.iterations = sim_server::kMaxIterations});
    times_ = sim_server::times_of(snapshot_, report);
    prediction_ = simulation_.predict_next(period_s_);
    if (const auto account = simulation_.energy_account()) given_J_ = account->flow.given_J;
    if (measures_) run_.simulation.step_s.push_back(processor_s() - began_s);
    ++run_.simulation.steps;
    run_.simulation.not_converged += report.solve.converged ? 0 : 1;
    run_.simulation.contacts += static_cast<std::uint64_t>(report.contacts);
    keep_state();
  }

  /// The world's state at the first step's end in each interval.
  void keep_state() {
    if (state_interval_s_ <= 0.0) return;
    const double due_s = start_s_ + static_cast<double>(run_.states.size()) * state_interval_s_;
    if (simulation_.world().time_s >= due_s - 1e-9)
      run_.states.push_back(state_of(simulation_.world()));
  }

  double period_s_;
  bool measures_;
  double state_interval_s_;
  double given_J_ = 0.0;
  double start_s_ = 0.0;  // the world's time when the run began
  LabRun& run_;
  dynamics::Simulation simulation_;
  publication::SceneWriter writer_;
  sim_server::LockstepSchedule schedule_;
  sim_server::ScheduledSnapshot snapshot_;           // the next, or computed and not yet shown
  std::optional<publication::SnapshotTimes> times_;  // of a snapshot that is computed
  publication::SnapshotPrediction prediction_;
};

}  // namespace

LabRun run_lab(const scene::SceneDescription& scene, const LabOptions& options) {
  const std::string session = unique_name();
  const std::uint64_t tick_ns = realtime::to_ns(1.0 / options.tick_rate_hz);
  const std::uint64_t end_ns = realtime::to_ns(options.duration_s);
  LabRun run;
  run.report.rate_hz = options.tick_rate_hz;
  run.report.scene = scene.name;
  run.report.transition = display::name_of(options.transition);
  run.report.measures_time = options.measures_ticks;
  run.rows.reserve(std::min<std::size_t>(end_ns / tick_ns + 1, 100'000));

  SimulationSide simulation(scene, options, session, run);
  device::Device device(device::parse_device_spec(options.device),
                        {.period_ns = tick_ns, .is_virtual = true});
  device.activate();
  run.report.device = device.descriptor().name;
  publication::ToolWriter tool(session, tick_ns, proto::Clock::kVirtual, 0);
  const auto scene_view =
      view_of<publication::SceneView>(session, proto::SegmentKind::kScene, proto::kSceneLayoutHash);
  const auto tool_view =
      view_of<publication::ToolView>(session, proto::SegmentKind::kTool, proto::kToolLayoutHash);
  const auto loop = std::make_unique<haptic_server::HapticLoop>(
      device, tool, make_renderer(options.rival, options.transition),
      safety::safety_limits(options.safety, device.descriptor()), tick_ns);

  const double began_s = processor_s();
  for (std::uint64_t now_ns = 0; now_ns < end_ns; now_ns += tick_ns) {
    simulation.run_to(now_ns, false, tool_view);  // samples before this tick's
    haptic_server::TickEnd end = loop->sense(scene_view, now_ns);
    if (end == haptic_server::TickEnd::kGoOn) {
      simulation.run_to(now_ns, true, tool_view);
      const std::uint64_t began_ns = options.measures_ticks ? realtime::monotonic_ns() : 0;
      end = loop->act(scene_view, true, now_ns, run.rows.emplace_back());
      if (options.measures_ticks) run.rows.back().tick_ns = realtime::monotonic_ns() - began_ns;
      if (loop->rendered().switch_jump_N)
        run.jumps.push_back({run.rows.size() - 1, *loop->rendered().switch_jump_N});
      loop->count(run.rows.back(), run.report);
      if (options.accounts_energy) run.given_J.push_back(simulation.given_J());
    }
    run.device_failed = end == haptic_server::TickEnd::kDeviceFault;
    if (end != haptic_server::TickEnd::kGoOn) break;
  }
  run.processor_s = processor_s() - began_s;
  return run;
}

LabRun run_reference(const scene::SceneDescription& scene, const LabOptions& options,
                     const LabRun& run) {
  std::vector<PathPoint> points;
  for (const recording::TickRow& row : run.rows) points.push_back({row.time_s, row.position_m});
  const PathFile path(scene.device, points);
  scene::SceneDescription fine = scene;
  fine.period_s = 1.0 / options.tick_rate_hz;
  LabOptions low_latency = options;
  low_latency.device = "replay:file=" + path.path().string();
  low_latency.rival = nullptr;
  low_latency.transition = display::Transition::kHold;
  low_latency.latency_s = low_latency.jitter = 0.0;
  return run_lab(fine, low_latency);
}

}  // namespace stillgrid::laboratory
