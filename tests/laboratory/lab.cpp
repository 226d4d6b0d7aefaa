#include "tests/laboratory/lab.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/haptic_loop.hpp"
#include "shared/publication/tool_segment.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/processor_time.hpp"
#include "shared/rendering/local_copy.hpp"
#include "sim_server/lockstep_simulation.hpp"
#include "sim_server/published_scene.hpp"
#include "sim_server/scene/build_world.hpp"
#include "tests/laboratory/path_file.hpp"

namespace stillgrid::laboratory {
namespace {

bodies::World start_world(const scene::SceneDescription& scene, const WorldState* start) {
  bodies::World world = scene::build_world(scene);
  if (start != nullptr) set_state(world, *start);
  return world;
}

/// With the snapshot of time zero on its way; none where both sides share memory.
std::unique_ptr<Network> network_of(const scene::SceneDescription& scene, const LabOptions& options,
                                    sim_server::LockstepSimulation& simulation) {
  if (!options.network) return nullptr;
  const dynamics::Simulation& simulated = simulation.simulation();
  auto network = std::make_unique<Network>(scene, simulated, *options.network, options.seed);
  network->send(simulated, {.state_ns = 0, .publish_ns = 0});
  return network;
}

/// What a run tells of its simulation.
class SimulationRecord {
 public:
  SimulationRecord(dynamics::Simulation& simulation, const LabOptions& options, LabRun& run)
      : state_interval_s_(options.state_interval_s), run_(run) {
    const bodies::World& world = simulation.world();
    run_.simulation.moving_spheres = world.spheres.size();
    run_.simulation.spheres = world.spheres.size() + world.static_spheres.size();
    start_s_ = world.time_s;
    keep_state(world);
  }

  void take(dynamics::Simulation& simulation, const dynamics::StepReport& report) {
    ++run_.simulation.steps;
    run_.simulation.not_converged += report.solve.converged ? 0 : 1;
    run_.simulation.contacts += static_cast<std::uint64_t>(report.contacts);
    keep_state(simulation.world());
  }

 private:
  /// The world's state at the first step's end in each interval.
  void keep_state(const bodies::World& world) {
    if (state_interval_s_ <= 0.0) return;
    const double due_s = start_s_ + static_cast<double>(run_.states.size()) * state_interval_s_;
    if (world.time_s >= due_s - 1e-9) run_.states.push_back(state_of(world));
  }

  double state_interval_s_;
  double start_s_ = 0.0;  // the world's time when the run began
  LabRun& run_;
};

}  // namespace

LabRun run_lab(const scene::SceneDescription& scene, const LabOptions& options) {
  const std::uint64_t tick_ns = realtime::to_ns(1.0 / options.tick_rate_hz);
  const std::uint64_t end_ns = realtime::to_ns(options.duration_s);
  LabRun run;
  run.report.rate_hz = options.tick_rate_hz;
  run.report.scene = scene.name;
  run.report.transition = display::name_of(options.transition);
  run.report.measures_time = options.measures_ticks;
  if (!options.watch) run.rows.reserve(std::min<std::size_t>(end_ns / tick_ns + 1, 100'000));

  sim_server::LockstepSimulation simulation(
      scene, start_world(scene, options.start),
      {scene.period_s, options.jitter, options.seed, options.latency_s},
      options.measures_ticks ? sim_server::CostClock(realtime::thread_processor_s)
                             : sim_server::CostClock());
  SimulationRecord record(simulation.simulation(), options, run);
  device::Device device(device::parse_device_spec(options.device),
                        {.period_ns = tick_ns, .is_virtual = true});
  device.activate();
  run.report.device = device.descriptor().name;
  publication::ToolWriter tool(simulation.session(), tick_ns, proto::Clock::kVirtual, 0);
  const publication::SceneView own_view = simulation.view();
  const publication::ToolView tool_view(publication::SegmentReader::require(
      simulation.session(), proto::SegmentKind::kTool, proto::kToolLayoutHash));
  if (!options.network && !options.steps_by_samples) simulation.follow(tool_view);
  const std::unique_ptr<Network> network = network_of(scene, options, simulation);
  const publication::SceneView& scene_view = network ? network->view() : own_view;
  const auto local =
      scene_view.model().empty() ? nullptr : std::make_unique<rendering::LocalCopy>(scene_view);
  auto renderer = make_renderer(options.rival, options.transition);
  const auto run_to = [&](std::uint64_t now_ns, bool at_now) {
    simulation.run_to(
        now_ns, at_now,
        [&]() -> std::optional<dynamics::ToolSample> {
          if (network) return network->tool_at(simulation.sample_ns());
          const auto state = tool_view.read();
          if (!state) return std::nullopt;
          return sim_server::sample_of(*state);
        },
        [&](dynamics::Simulation& stepped, const dynamics::StepReport& report) {
          record.take(stepped, report);
        },
        [&](const auto& simulated, const auto& times) {
          if (network) network->send(simulated, times);
        });
    if (network) network->deliver(now_ns);
  };
  const auto loop = std::make_unique<haptic_server::HapticLoop>(
      device, tool, std::move(renderer), safety::safety_limits(options.safety, device.descriptor()),
      tick_ns);

  const auto keep = [&](const recording::TickRow& row) {
    run.rows.push_back(row);
    if (loop->rendered().switch_jump_N)
      run.jumps.push_back({run.rows.size() - 1, *loop->rendered().switch_jump_N});
    loop->count(row, run.report);
  };

  const double began_s = realtime::thread_processor_s();
  for (std::uint64_t now_ns = 0; now_ns < end_ns; now_ns += tick_ns) {
    run_to(now_ns, false);  // samples before this tick's
    haptic_server::TickEnd end = loop->sense(scene_view, now_ns);
    if (network)
      if (const auto state = tool_view.read(); state && state->time_ns == now_ns)
        network->send(*state);
    if (end == haptic_server::TickEnd::kGoOn) {
      run_to(now_ns, true);
      const std::uint64_t began_ns = options.measures_ticks ? realtime::monotonic_ns() : 0;
      recording::TickRow row;
      end = loop->act(scene_view, true, now_ns, row, {}, local.get());
      if (options.measures_ticks) row.tick_ns = realtime::monotonic_ns() - began_ns;
      if (options.watch && !options.watch(row)) break;
      if (!options.watch) keep(row);
    }
    run.device_failed = end == haptic_server::TickEnd::kDeviceFault;
    if (end != haptic_server::TickEnd::kGoOn) break;
  }
  run.processor_s = realtime::thread_processor_s() - began_s;
  run.simulation.step_s = simulation.step_s();
  if (network) run.network = network->figures();
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
  low_latency.network.reset();
  return run_lab(fine, low_latency);
}

}  // namespace stillgrid::laboratory
