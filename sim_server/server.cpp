#include "sim_server/server.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "shared/publication/relay_figures.hpp"
#include "shared/publication/session.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/realtime_thread.hpp"
#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/path_steps.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::sim_server {
namespace {

/// Of the period, the processor time that a step may take until it must end: the rest is for its
/// last iteration, and to publish.
constexpr double kStepShare = 0.8;
constexpr std::uint64_t kBehindHands_ns = 200'000;

double to_s(std::uint64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

/// What a step that begins now may cost.
dynamics::Budget budget_of(double period_s, const std::atomic<bool>& stop) {
  dynamics::Budget budget{.stop = &stop};
  budget.end_within(realtime::to_ns(kStepShare * period_s));
  return budget;
}

publication::SessionSpec session_spec(const scene::SceneDescription& scene,
                                      const ServerOptions& options,
                                      const dynamics::Simulation& simulation, proto::Clock clock,
                                      std::uint64_t start_ns) {
  return {.name = options.session,
          .moving_count = simulation.world().spheres.size(),
          .period_ns = realtime::to_ns(scene.period_s),
          .clock = clock,
          .start_ns = start_ns,
          .readers = options.readers,
          .report = [](const std::string& refusal) { spdlog::warn("{}", refusal); }};
}

void run_offline(const scene::SceneDescription& scene, const ServerOptions& options,
                 dynamics::Simulation& simulation, SimulationReport& report,
                 const std::atomic<bool>& stop) {
  std::mt19937_64 random(options.seed);
  std::uniform_real_distribution<double> spread(-options.jitter, options.jitter);
  const double end_s = options.duration_s.value_or(INFINITY);
  while (simulation.world().time_s < end_s - 1e-9 && !stop) {
    const double step_s = scene.period_s * (1.0 + spread(random));
    const std::uint64_t began_ns = realtime::monotonic_ns();
    const dynamics::StepReport step =
        simulation.step(step_s, [] { return std::nullopt; }, {.stop = &stop});
    if (step.stopped) return;
    count_step(report, step);
    report.step_ns.record(realtime::monotonic_ns() - began_ns);
    options.after_step();
  }
}

/// Whether the hands step the scene too, with the same model for all of them.
bool has_model(publication::Session& session) {
  return session.hands().front().writer().scene().model_bytes > 0;
}

/// Begins the paths that hands with a model step along. Says where they have none.
std::optional<PathSteps> begin_paths(publication::Session& session,
                                     dynamics::Simulation& simulation, std::uint64_t number,
                                     double period_s) {
  if (has_model(session))
    return std::optional<PathSteps>(std::in_place, simulation, number, period_s);
  spdlog::info("hands show the scene by linear, for it does not fulfil the conditions of local");
  return std::nullopt;
}

/// How each hand's tool came, if a relay brought it.
void note_relays(publication::Session& session, SimulationReport& report) {
  for (std::size_t hand = 0; hand < report.hands.size(); ++hand)
    if (const publication::ToolView* tool = session.hands()[hand].tool().acquire(false))
      report.hands[hand].relay = publication::load_relay_figures(tool->reader().live());
}

void run_real(const scene::SceneDescription& scene, const ServerOptions& options,
              publication::SessionLock lock, dynamics::Simulation& simulation,
              SimulationReport& report, const std::atomic<bool>& stop) {
  const std::uint64_t start_ns = realtime::monotonic_ns();
  publication::Session session(
      session_spec(scene, options, simulation, proto::Clock::kMonotonic, start_ns), std::move(lock),
      hand_scenes(scene, simulation));
  std::vector<dynamics::TakeTool> take_tools;
  for (publication::HandSession& hand : session.hands()) {
    hand.tool().start();
    take_tools.emplace_back([&hand] { return sample_of(hand.take_tool()); });
  }
  std::optional<PathSteps> paths =
      begin_paths(session, simulation, start_ns / proto::kPathTick_ns, scene.period_s);
  const auto publish = [&](std::size_t hand, std::uint64_t state_ns, std::uint64_t began_ns,
                           const dynamics::StepReport& step) {
    publication::SceneWriter& writer = session.hands()[hand].writer();
    const std::uint64_t computed_ns = realtime::monotonic_ns();
    writer.segment().require_whole();
    const std::uint64_t now_ns = realtime::monotonic_ns();
    const publication::SnapshotTimes times{.state_ns = state_ns,
                                           .publish_ns = now_ns,
                                           .tool_ns = step.tools[hand].time_ns,
                                           .step_ns = now_ns - began_ns,
                                           .contacts = static_cast<std::uint64_t>(step.contacts),
                                           .tool_work_J = step.tools[hand].work_J};
    writer.publish(simulation.snapshot(), times, simulation.field_records(),
                   paths ? paths->state() : publication::SnapshotState());
    report.publish_ns.record(realtime::monotonic_ns() - computed_ns);
    count_snapshot(report, hand, times, writer.has_state());
  };
  for (std::size_t hand = 0; hand < take_tools.size(); ++hand)
    publish(hand, start_ns, start_ns, {});

  // Behind the hands, whose loops wake on the same grid: a step takes the samples of its moment.
  realtime::PeriodicTimer timer(realtime::to_ns(scene.period_s), kBehindHands_ns);
  const std::uint64_t end_ns =
      options.duration_s ? start_ns + realtime::to_ns(*options.duration_s) : proto::kNever;
  while (!stop && realtime::monotonic_ns() < end_ns) {
    const realtime::PeriodicTimer::Wake wake = timer.wait(&stop);
    if (stop) break;
    report.late_steps += wake.skipped;
    for (std::size_t hand = 0; paths && hand < take_tools.size(); ++hand)
      paths->follow(hand, session.hands()[hand].living_tool());
    // A step makes up for a stall, but readers do not wait for it longer than this.
    constexpr double kLongestStep_s = 0.1;
    const double ahead_s = paths ? std::min(paths->ahead_s(wake.now_ns), kLongestStep_s) : 0.0;
    const dynamics::Budget budget = budget_of(std::max(scene.period_s, ahead_s), stop);
    const dynamics::StepReport step = paths ? paths->step_until(wake.now_ns, simulation, budget)
                                            : simulation.step(scene.period_s, take_tools, budget);
    if (step.stopped) break;
    for (std::size_t hand = 0; hand < take_tools.size(); ++hand)
      publish(hand, paths ? paths->time_ns() : wake.deadline_ns, wake.now_ns, step);
    count_step(report, step);
    if (paths) report.left_out_ticks = paths->left_out();
    report.step_ns.record(realtime::monotonic_ns() - wake.now_ns);
    options.after_step();
  }
  note_relays(session, report);
}

void run_lockstep(const scene::SceneDescription& scene, const ServerOptions& options,
                  publication::SessionLock lock, dynamics::Simulation& simulation,
                  SimulationReport& report, const std::atomic<bool>& stop) {
  using Header = proto::SegmentHeader;
  publication::Session session(session_spec(scene, options, simulation, proto::Clock::kVirtual, 0),
                               std::move(lock), hand_scenes(scene, simulation));
  const std::size_t hands = session.hands().size();
  LockstepSchedule schedule(scene.period_s, options.jitter, options.seed, options.latency_s);
  ScheduledSnapshot snapshot = schedule.next();
  std::optional<PathSteps> paths = begin_paths(session, simulation, 0, scene.period_s);
  const auto state = [&] { return paths ? paths->state() : publication::SnapshotState(); };
  for (publication::HandSession& hand : session.hands())
    hand.writer().publish(simulation.snapshot(), {.state_ns = 0, .publish_ns = 0},
                          simulation.field_records(), state());
  ++report.snapshots;
  if (session.hands().front().writer().has_state()) ++report.states;
  session.promise(&Header::lockstep_sample_ns, snapshot.sample_ns);
  session.promise(&Header::lockstep_event_ns, snapshot.publish_ns);

  publication::LockstepPeers peers(session, stop);
  peers.wait_for_arrival();
  std::vector<dynamics::TakeTool> take_tools;
  for (publication::HandSession& hand : session.hands())
    take_tools.emplace_back([&hand] { return sample_of(hand.take_tool()); });
  const std::uint64_t end_ns =
      options.duration_s ? realtime::to_ns(*options.duration_s) : proto::kNever;
  while (snapshot.state_ns <= end_ns) {
    // A sample taken before T_n is complete when the peer's next one lies after it.
    if (stop || !peers.wait(&Header::lockstep_sample_ns, snapshot.sample_ns + 1)) break;
    if (!options.duration_s && peers.have_ended()) break;
    for (std::size_t hand = 0; paths && hand < hands; ++hand)
      paths->follow(hand, session.hands()[hand].tool().acquire());
    const dynamics::Budget budget{.stop = &stop};
    const dynamics::StepReport step =
        paths ? paths->step_until(snapshot.state_ns, simulation, budget)
              : simulation.step(to_s(snapshot.step_ns), take_tools, budget);
    if (step.stopped) break;
    if (paths) snapshot.state_ns = paths->time_ns();
    count_step(report, step);
    options.after_step();
    if (paths) report.left_out_ticks = paths->left_out();

    const ScheduledSnapshot shown = snapshot;
    snapshot = schedule.next();
    session.promise(&Header::lockstep_sample_ns, snapshot.sample_ns);
    if (!peers.wait(&Header::lockstep_event_ns, shown.publish_ns)) break;
    for (std::size_t hand = 0; hand < hands; ++hand) {
      publication::SceneWriter& writer = session.hands()[hand].writer();
      writer.segment().require_whole();
      const publication::SnapshotTimes times = times_of(shown, step, hand);
      writer.publish(simulation.snapshot(), times, simulation.field_records(), state());
      count_snapshot(report, hand, times, writer.has_state());
    }
    // A promise that the next one replaces at once would be seen by some hands only.
    if (snapshot.state_ns <= end_ns)
      session.promise(&Header::lockstep_event_ns, snapshot.publish_ns);
  }
  session.promise(&Header::lockstep_sample_ns, proto::kNever);
  session.promise(&Header::lockstep_event_ns, proto::kNever);
}

}  // namespace

void run_simulation(const scene::SceneDescription& scene, const ServerOptions& options,
                    std::optional<publication::SessionLock> lock, dynamics::Simulation& simulation,
                    SimulationReport& report, const std::atomic<bool>& stop) {
  if (options.cpu && !realtime::pin_to_cpu(*options.cpu))
    spdlog::warn("running without processor {}: there is none of that number for us", *options.cpu);
  report.measures_time = options.clock != SimulationClock::kLockstep;
  switch (options.clock) {
    case SimulationClock::kReal:
      return run_real(scene, options, std::move(*lock), simulation, report, stop);
    case SimulationClock::kLockstep:
      return run_lockstep(scene, options, std::move(*lock), simulation, report, stop);
    case SimulationClock::kOffline:
      return run_offline(scene, options, simulation, report, stop);
  }
}

}  // namespace stillgrid::sim_server
