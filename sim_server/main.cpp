#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "shared/command_line/file_name.hpp"
#include "shared/command_line/number_in.hpp"
#include "shared/command_line/prepare_daemon.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "sim_server/available_memory.hpp"
#include "sim_server/bodies/kinds/body_in_world.hpp"
#include "sim_server/contact/start_warnings.hpp"
#include "sim_server/contact_log.hpp"
#include "sim_server/dynamics/choice/counted_work.hpp"
#include "sim_server/dynamics/choice/memory_need.hpp"
#include "sim_server/dynamics/workers/workers.hpp"
#include "sim_server/hand_path.hpp"
#include "sim_server/report.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "sim_server/scene_summary.hpp"
#include "sim_server/server.hpp"
#include "sim_server/settle_choices.hpp"
#include "sim_server/surface_file.hpp"
#include "sim_server/try_files.hpp"

namespace stillgrid::sim_server {
namespace {

struct Arguments {
  std::filesystem::path scene, report, final_state, contacts, surfaces;
  std::optional<double> rate_hz;
  std::string group;
  bool lockstep = false, offline = false, explain = false, check = false, tries = false;
  ServerOptions server;
};

constexpr const char* kDescription =
    "Simulates a scene and publishes its filled voxel grid, for a haptic_server of the same "
    "session.\n"
    "\n"
    "  sim_server --scene tissue_and_blocks.toml --session demo            until Ctrl-C\n"
    "  sim_server --scene wall.toml --session ci --lockstep --duration 5   repeatable, with "
    "haptic_server\n"
    "  sim_server --scene threads.toml --offline --duration 2 --final-state end.csv\n"
    "  sim_server --scene threads.toml --check                             whether it would start\n"
    "  sim_server --scene threads.toml --explain                           which method serves "
    "it\n"
    "  sim_server --scene organ.toml --surfaces organ.json                 for scene_viewer\n";

void add_options(CLI::App& app, Arguments& arguments) {
  ServerOptions& server = arguments.server;
  app.add_option("--scene", arguments.scene, "Scene file (TOML), see docs/formats.md")->required();
  auto* session = app.add_option("--session", server.session,
                                 "Name that joins the two servers; USER/NAME: with USER's")
                      ->transform(CLI::Validator(publication::settle_session, ""));
  auto* rate = app.add_option("--rate", arguments.rate_hz,
                              "Steps a second, Hz; overrides rate_hz of the scene")
                   ->check(command_line::number_in(0.01, 1e5));
  auto* duration =
      app.add_option("--duration", server.duration_s, "Simulated time, s; default: until Ctrl-C")
          ->check(command_line::number_in(1e-6, 1e8));
  auto* lockstep = app.add_flag("--lockstep", arguments.lockstep,
                                "Virtual time, in agreement with haptic_server --lockstep; ends "
                                "after its hands unless there is a --duration");
  auto* offline = app.add_flag("--offline", arguments.offline,
                               "Virtual time, alone; needs --duration, publishes nothing");
  offline->excludes(lockstep)->excludes(session);
  auto* explain =
      app.add_flag(
             "--explain", arguments.explain,
             "Print the method that the spectrum asks for, and counted work, error and reason "
             "of each model where contact = \"auto\", and end")
          ->excludes(lockstep)
          ->excludes(offline);
  auto* surfaces =
      app.add_option("--surfaces", arguments.surfaces,
                     "Write what the bodies look like, for scene_viewer (JSON), and end")
          ->excludes(lockstep)
          ->excludes(offline);
  auto* check = app.add_flag("--check", arguments.check,
                             "Read and build the scene, warn and choose as a start would, print "
                             "what it holds, and end; publishes nothing")
                    ->excludes(lockstep)
                    ->excludes(offline);
  auto* tries =
      app.add_flag("--try", arguments.tries,
                   "Read lines FILE.toml TRANSITION from standard input; print work and error of "
                   "each under the scene's hand, a line of JSON; scene_fit does")
          ->excludes(lockstep)
          ->excludes(offline);
  app.add_option("--latency", server.latency_s, "Virtual cost of a step, s; only with --lockstep")
      ->check(command_line::number_in(0.0, 100.0))
      ->needs(lockstep);
  app.add_option("--jitter", server.jitter,
                 "Draw each period from P (1 + u), u uniform in +-FRACTION; virtual time only")
      ->check(command_line::number_in(0.0, 0.95));
  auto* seed = app.add_option("--seed", server.seed, "Of the jitter; default 1")
                   ->check(command_line::integer_in(0, 999'999'999'999'999));
  auto* report = app.add_option("--report", arguments.report, "Write a report (JSON) at exit");
  auto* final_state = app.add_option("--final-state", arguments.final_state,
                                     "Write nodes and bodies (CSV) at exit");
  auto* contacts = app.add_option("--contacts", arguments.contacts,
                                  "Write the forces between bodies after each step (CSV); no body "
                                  "sleeps then")
                       ->check(command_line::file_name());
  auto* group =
      app.add_option("--group", arguments.group,
                     "Let this group of users read the session too; default: only its owner")
          ->check(publication::group_complaint)
          ->excludes(offline);
  auto* cpu = app.add_option("--cpu", server.cpu, "Run on this processor")
                  ->check(command_line::integer_in(0, 8191));
  auto* threads =
      app.add_option("--threads", server.threads,
                     "Share the work of a large scene among so many, by explicit methods; no byte "
                     "depends on it; default: from 1,000 spheres on a processor each, at most 8, "
                     "but one for haptic_server")
          ->check(command_line::integer_in(1, 1024))
          ->excludes(cpu);
  // What only a run needs: elsewhere it would do nothing.
  for (auto* of_run : {session, duration, seed, report, final_state, contacts, group, cpu, threads})
    of_run->excludes(explain)->excludes(surfaces)->excludes(check)->excludes(tries);
  explain->excludes(check)->excludes(tries);
  tries->excludes(check)->excludes(surfaces)->excludes(rate);
  surfaces->excludes(explain)->excludes(check)->excludes(rate);
}

/// What CLI11 cannot say by itself.
void check(const Arguments& arguments) {
  const bool is_run =
      !arguments.explain && !arguments.check && !arguments.tries && arguments.surfaces.empty();
  if (is_run && !arguments.offline && arguments.server.session.empty())
    throw CLI::ValidationError("--session",
                               "is required unless --offline, --check, --explain, --try or "
                               "--surfaces is given");
  if (arguments.offline && !arguments.server.duration_s)
    throw CLI::ValidationError("--offline", "needs --duration");
  if (!arguments.offline && !arguments.lockstep && arguments.server.jitter > 0.0)
    throw CLI::ValidationError("--jitter", "needs --lockstep or --offline");
}

void check_latency(const Arguments& arguments, double period_s) {
  if (arguments.server.latency_s > period_s)
    throw CLI::ValidationError("--latency", "value " + std::to_string(arguments.server.latency_s) +
                                                ": expected at most the period, " +
                                                std::to_string(period_s) + " s");
}

/// Throws std::runtime_error unless the path of the scene's hand can be played. A start does not
/// read it.
void require_hand(const scene::SceneDescription& scene, const std::filesystem::path& file) {
  if (!scene.hand) return;
  try {
    static_cast<void>(HandPath(scene.hand->file, scene.device));
  } catch (const std::exception& refusal) {
    throw std::runtime_error(file.string() + ':' + std::to_string(scene.hand->line) +
                             ": hand.file: " + refusal.what());
  }
}

/// Refuses what would not fit; says what is likely not meant.
bodies::World checked_world(const scene::SceneDescription& scene, const Arguments& arguments) {
  const std::string file = arguments.scene.string();
  dynamics::Memory room = available_memory();
  if (arguments.offline || arguments.explain || arguments.tries || !arguments.surfaces.empty())
    room.shared_bytes = INFINITY;  // nothing is published
  scene::SceneDescription cheapest = scene;
  if (scene.choose_method) cheapest.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  dynamics::require_room(cheapest, file, room);
  bodies::World world = scene::build_world(scene);
  for (const std::string& warning : contact::start_warnings(scene, world, file))
    spdlog::warn("{}", warning);
  const scene::Method& method = scene.method;
  if (scene.choose_method || !scene::is_explicit(method.integrator) || method.substeps == 0)
    return world;
  const int stable = dynamics::stable_substeps(dynamics::load_of(world), scene.period_s);
  if (method.substeps < stable)
    spdlog::warn(
        "{}: simulation.substeps: value {}: may not be stable in a step of {} s; {} is, and so is "
        "leaving it out",
        file, method.substeps, scene.period_s, stable);
  return world;
}

int fail(const std::exception& error, realtime::ExitStatus status) {
  std::fprintf(stderr, "sim_server: %s\n", error.what());
  return status;
}

/// Chooses as a start would.
int print_summary(scene::SceneDescription& scene, const bodies::World& world) {
  settle_choices(scene, world);
  std::fputs(summary_of(scene, world).c_str(), stdout);
  return realtime::kDone;
}

int write_surfaces_of(const Arguments& arguments, const scene::SceneDescription& scene,
                      const bodies::World& world) {
  std::vector<std::string> names;
  for (const auto& body : scene.bodies) names.push_back(body.name);
  write_surfaces(scene.name, names, world.spheres.size() + world.static_spheres.size(),
                 bodies::rest_surfaces(scene.bodies, world), arguments.surfaces);
  return realtime::kDone;
}

/// As asked; else, for a scene that may be large, a processor each, but for one that haptic_server
/// has to itself.
int threads_of(const ServerOptions& options, const scene::Method& method,
               const bodies::World& world) {
  constexpr std::size_t kLargeSpheres = 1000;
  constexpr int kMaxThreads = 8;  // more would wait for the same memory
  const auto processors = static_cast<int>(std::thread::hardware_concurrency());
  if (options.threads > processors)
    spdlog::warn("--threads {}: slower than {}, the number of processors", options.threads,
                 processors);
  if (options.threads > 0) return options.threads;
  if (options.cpu || !scene::is_explicit(method.integrator) || world.spheres.size() < kLargeSpheres)
    return 1;
  return std::clamp(processors - 1, 1, kMaxThreads);
}

/// Returns whether the results of a run are worth nothing. In real time a slow machine cuts steps
/// short: there every step must have failed, elsewhere more than half.
bool is_unconverged(const SimulationReport& report, SimulationClock clock) {
  const std::uint64_t failed = report.not_converged;
  return clock == SimulationClock::kReal ? failed > 0 && failed == report.steps
                                         : 2 * failed > report.steps;
}

/// Throws std::runtime_error unless every output can be written, and no file is written over the
/// scene or twice. What is no file, such as /dev/null, may be named twice.
void require_outputs(const Arguments& arguments) {
  const auto place_of = [](const std::filesystem::path& file) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file));
  };
  std::vector<std::filesystem::path> taken{place_of(arguments.scene)};
  for (const auto& file :
       {arguments.report, arguments.final_state, arguments.contacts, arguments.surfaces}) {
    if (file.empty()) continue;
    const std::filesystem::path path = place_of(file);
    const bool is_file = !std::filesystem::exists(path) || std::filesystem::is_regular_file(path);
    if (is_file && std::find(taken.begin(), taken.end(), path) != taken.end())
      throw std::runtime_error(file.string() +
                               ": expected a file of its own: the scene or another "
                               "output has this name");
    taken.push_back(path);
    files::require_writable(file);
  }
}

/// Where the system refuses oneTBB a thread: another program may have taken it since `Workers` saw
/// that it was to be had. What is left of oneTBB cannot be ended otherwise.
[[noreturn]] void end_without_threads(const std::runtime_error& refusal) {
  std::fprintf(stderr, "sim_server: --threads: expected fewer: %s (ulimit -u, -v)\n",
               refusal.what());
  std::_Exit(realtime::kCouldNotStart);
}

const std::terminate_handler kEndOfABug = std::get_terminate();

/// oneTBB throws that from within its own threads too, where nobody can catch it.
[[noreturn]] void end_in_a_line() {
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::runtime_error& error) {
    if (std::string_view(error.what()).starts_with("pthread_create has failed"))
      end_without_threads(error);
  } catch (...) {  // a bug, as without an exception
  }
  kEndOfABug();
  std::abort();
}

dynamics::Workers make_workers(int threads) {
  std::set_terminate(end_in_a_line);
  try {
    return dynamics::Workers(threads);
  } catch (const std::runtime_error& refusal) {
    end_without_threads(refusal);
  }
}

/// Runs the scene; report and final state are written however it ended.
int run(Arguments& arguments) {
  check(arguments);
  // While it is held without a segment, haptic_server waits for the scene to be loaded.
  std::optional<publication::SessionLock> lock;
  try {
    if (!arguments.server.session.empty())
      lock.emplace(arguments.server.session, proto::SegmentKind::kScene);
  } catch (const publication::SegmentError& error) {
    return fail(error, realtime::kCouldNotStart);
  }
  scene::SceneDescription scene = scene::load_scene(arguments.scene);
  for (const std::string& note : scene.notes) spdlog::info("{}", note);
  if (arguments.rate_hz) scene.period_s = 1.0 / *arguments.rate_hz;
  if (!arguments.contacts.empty()) scene.sleeping = false;
  arguments.server.clock = arguments.offline    ? SimulationClock::kOffline
                           : arguments.lockstep ? SimulationClock::kLockstep
                                                : SimulationClock::kReal;
  require_outputs(arguments);
  if (!arguments.group.empty())
    arguments.server.readers = publication::group_named(arguments.group);
  bodies::World world = checked_world(scene, arguments);
  if (!arguments.rate_hz) dynamics::settle_step(scene, world);
  check_latency(arguments, scene.period_s);
  if (arguments.explain) {
    explain_choices(scene, world);
    return realtime::kDone;
  }
  if (arguments.tries) {
    require_hand(scene, arguments.scene);
    if (!scene.hand) throw std::runtime_error("--try: expected a scene with a table [hand]");
    try_files(scene, std::cin, std::cout);
    return realtime::kDone;
  }
  if (!arguments.surfaces.empty()) return write_surfaces_of(arguments, scene, world);
  if (arguments.check) {
    require_hand(scene, arguments.scene);
    for (const std::string& warning : contact::cover_warnings(scene, arguments.scene.string()))
      spdlog::warn("{}", warning);
    return print_summary(scene, world);
  }
  settle_choices(scene, world);
  const int threads = threads_of(arguments.server, scene.method, world);
  const dynamics::Workers workers = make_workers(threads);
  if (workers.threads() < threads)
    spdlog::warn("{} threads in place of {}: no more can be made (ulimit -u, -v)",
                 workers.threads(), threads);
  dynamics::Simulation simulation(scene, std::move(world));
  simulation.share_work(workers);
  SimulationReport report;
  report.scene = scene.name;
  for (const scene::Hand& hand : scene::hands_of(scene))
    report.hands.emplace_back().name = hand.name;
  report.solver = scene::describe(scene.method);
  report.rate_hz = 1.0 / scene.period_s;
  std::optional<ContactLog> contacts;
  if (!arguments.contacts.empty()) {
    std::vector<std::string> hands;
    for (const HandReport& hand : report.hands) hands.push_back(hand.name);
    contacts.emplace(arguments.contacts, hands);
    arguments.server.after_step = [&] { contacts->add(simulation); };
  }
  simulation.watch_energy();
  if (!arguments.report.empty()) simulation.account_energy();
  int status = realtime::kDone;
  // Before, a signal ends the process, which leaves at worst the file of the lock, and it is free.
  realtime::install_stop_signal();
  try {
    run_simulation(scene, arguments.server, std::move(lock), simulation, report,
                   realtime::stop_requested());
    simulation.judge_energy();
  } catch (const publication::SegmentError& error) {
    status = fail(error, realtime::kCouldNotStart);
  } catch (const std::domain_error& error) {  // the state is not finite, or gained energy
    status = fail(error, realtime::kNotConverged);
    report.ended_by = error.what();
  } catch (const std::bad_alloc&) {
    status = fail(std::runtime_error("out of memory"), realtime::kCouldNotStart);
    report.ended_by = "out of memory";
  }
  if (!arguments.final_state.empty()) write_final_state(simulation.world(), arguments.final_state);
  if (report.ended_by.empty()) report.energy = simulation.energy_account();
  if (!arguments.report.empty()) write_report(report, simulation.world(), arguments.report);
  if (contacts) contacts->finish();
  if (!report.ended_by.empty()) return status;
  for (const std::string& complaint :
       {convergence_complaint(report, scene.method), lateness_complaint(report)})
    if (!complaint.empty()) spdlog::warn("{}", complaint);
  if (status == realtime::kDone && is_unconverged(report, arguments.server.clock))
    status = realtime::kNotConverged;
  if (report.crossings_left > 0)
    spdlog::warn("{} times something moved so fast that it may have passed through another body",
                 report.crossings_left);
  return status;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "sim_server");
  Arguments arguments;
  add_options(app, arguments);
  command_line::add_version(app, {command_line::segment_interface()});
  return command_line::run_program(app, argc, argv, [&] {
    command_line::prepare_log("sim_server");
    return run(arguments);
  });
}

}  // namespace
}  // namespace stillgrid::sim_server

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::sim_server::program_main(argc, argv);
}
