#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

#include "shared/command_line/number_in.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "sim_server/bodies/sphere_packing.hpp"
#include "sim_server/report.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "sim_server/server.hpp"

namespace stillgrid {
namespace {

struct Arguments {
  std::filesystem::path scene, report, final_state;
  std::optional<double> rate_hz;
  std::string group;
  bool lockstep = false, offline = false;
  ServerOptions server;
};

constexpr const char* kDescription =
    "Simulates a scene and publishes its filled voxel grid, for a haptic_server of the same "
    "session.\n"
    "\n"
    "  sim_server --scene tissue_and_blocks.toml --session demo            until Ctrl-C\n"
    "  sim_server --scene wall.toml --session ci --lockstep --duration 5   repeatable, with "
    "haptic_server\n"
    "  sim_server --scene threads.toml --offline --duration 2 --final-state end.csv\n";

void add_options(CLI::App& app, Arguments& arguments) {
  ServerOptions& server = arguments.server;
  app.add_option("--scene", arguments.scene, "Scene file (TOML), see docs/formats.md")->required();
  auto* session = app.add_option("--session", server.session, "Name that joins the two servers")
                      ->check(session_complaint);
  app.add_option("--rate", arguments.rate_hz, "Steps a second, Hz; default: the scene's")
      ->check(number_in(0.01, 1e5));
  app.add_option("--duration", server.duration_s, "Simulated time, s; default: until Ctrl-C")
      ->check(number_in(1e-6, 1e8));
  auto* lockstep = app.add_flag("--lockstep", arguments.lockstep,
                                "Virtual time, in agreement with haptic_server --lockstep");
  auto* offline = app.add_flag("--offline", arguments.offline,
                               "Virtual time, alone; needs --duration, publishes nothing");
  offline->excludes(lockstep)->excludes(session);
  app.add_option("--latency", server.latency_s, "Virtual cost of a step, s; only with --lockstep")
      ->check(number_in(0.0, 100.0))
      ->needs(lockstep);
  app.add_option("--jitter", server.jitter,
                 "Draw each period from P (1 + u), u uniform in +-FRACTION; virtual time only")
      ->check(number_in(0.0, 0.95));
  app.add_option("--seed", server.seed, "Of the jitter; default 1");
  app.add_option("--report", arguments.report, "Write a report (JSON) at exit");
  app.add_option("--final-state", arguments.final_state, "Write nodes and bodies (CSV) at exit");
  app.add_option("--group", arguments.group,
                 "Let this group of users read the session too; default: only its owner")
      ->check(group_complaint)
      ->excludes(offline);
  app.add_option("--cpu", server.cpu, "Run on this processor")->check(CLI::NonNegativeNumber);
}

/// What CLI11 cannot say by itself.
void check(const Arguments& arguments, double period_s) {
  if (!arguments.offline && arguments.server.session.empty())
    throw CLI::ValidationError("--session", "is required unless --offline is given");
  if (arguments.offline && !arguments.server.duration_s)
    throw CLI::ValidationError("--offline", "needs --duration");
  if (!arguments.offline && !arguments.lockstep && arguments.server.jitter > 0.0)
    throw CLI::ValidationError("--jitter", "needs --lockstep or --offline");
  if (arguments.server.latency_s > period_s)
    throw CLI::ValidationError("--latency", "value " + std::to_string(arguments.server.latency_s) +
                                                ": expected at most the period, " +
                                                std::to_string(period_s) + " s");
}

/// Memory and time grow with the spheres: a thin box without a spacing may ask for billions.
void check_sphere_count(const SceneDescription& scene, const std::string& file) {
  constexpr double kMostSpheres = 1e6;
  double total = 0.0;
  for (const BodyDescription& body : scene.bodies) {
    const double count = sphere_count(body);
    total += count;
    if (total > kMostSpheres)
      throw std::runtime_error(file + ": body '" + body.name + "': spheres: value " +
                               std::to_string(static_cast<std::uint64_t>(count)) +
                               ": expected at most 1000000 in a scene; give "
                               "it a larger spacing_m");
  }
}

int fail(const std::exception& error, ExitStatus status) {
  std::fprintf(stderr, "sim_server: %s\n", error.what());
  return status;
}

/// Runs the scene; report and final state are written however it ended.
int run(Arguments& arguments) {
  SceneDescription scene = load_scene(arguments.scene);
  for (const std::string& note : scene.notes) spdlog::info("{}", note);
  if (arguments.rate_hz) scene.period_s = 1.0 / *arguments.rate_hz;
  check(arguments, scene.period_s);
  arguments.server.clock = arguments.offline    ? SimulationClock::kOffline
                           : arguments.lockstep ? SimulationClock::kLockstep
                                                : SimulationClock::kReal;
  for (const auto& file : {arguments.report, arguments.final_state})
    if (!file.empty()) require_writable(file);
  if (!arguments.group.empty()) arguments.server.readers = group_named(arguments.group);
  check_sphere_count(scene, arguments.scene.string());
  Simulation simulation(scene);
  SimulationReport report;
  report.scene = scene.name;
  report.solver = name_of(scene.method.solver);
  report.rate_hz = 1.0 / scene.period_s;
  int status = kDone;
  try {
    run_simulation(scene, arguments.server, simulation, report, stop_requested());
  } catch (const SegmentError& error) {
    status = fail(error, kCouldNotStart);
  }
  if (!arguments.final_state.empty()) write_final_state(simulation.world(), arguments.final_state);
  if (!arguments.report.empty()) write_report(report, simulation.world(), arguments.report);
  if (report.not_converged > 0)
    spdlog::warn("{} of {} steps did not converge; each used its best iterate",
                 report.not_converged, report.steps);
  if (report.crossings_left > 0)
    spdlog::warn("{} times something moved so fast that it may have passed through another body",
                 report.crossings_left);
  return status;
}

}  // namespace
}  // namespace stillgrid

int main(int argc, char** argv) {
  using namespace stillgrid;
  CLI::App app(kDescription, "sim_server");
  Arguments arguments;
  add_options(app, arguments);
  try {
    app.parse(argc, argv);
    spdlog::set_default_logger(spdlog::stderr_color_mt("sim_server"));
    spdlog::set_pattern("%n: %v");
    install_stop_signal();
    return run(arguments);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const std::exception& error) {
    return fail(error, kBadInput);
  }
}
