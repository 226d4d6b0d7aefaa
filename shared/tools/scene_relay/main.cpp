#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/prepare_daemon.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/publication/hands.hpp"
#include "shared/publication/segment.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "shared/tools/scene_relay/relay.hpp"
#include "shared/tools/scene_relay/ros_topics.hpp"

namespace stillgrid::scene_relay {
namespace {

struct Arguments {
  RelayOptions options;
  std::string hand, group;
  std::filesystem::path report;
};

struct RosArguments {
  RosOptions ros;
  NetworkOptions network;
  std::string hand;
};

constexpr const char* kDescription =
    "Carries a session between the machine of the simulation and that of the hand, over DDS. One\n"
    "runs on each; neither server knows of it. The 1 kHz loop stays beside the hand. Or tells\n"
    "ROS 2 of the tool.\n"
    "\n"
    "  workstation$ sim_server --scene organ.toml --session demo\n"
    "  workstation$ scene_relay simulation --session demo --interface wg0\n"
    "  at the hand$ scene_relay hand --session demo --interface wg0\n"
    "  at the hand$ haptic_server --session demo --device phantom\n"
    "\n"
    "  scene_relay ros --session demo     the tool's pose and force as topics of ROS 2\n"
    "\n"
    "Without --interface it keeps to this machine. Who may join is said by the interface, a\n"
    "tunnel, by --security, or by --open: docs/network.md.\n";

void add_session(CLI::App& app, std::string& session, std::string& hand) {
  app.add_option("--session", session, "Name of the session, alike on both machines")
      ->required()
      ->transform(CLI::Validator(publication::settle_session, ""));
  app.add_option("--hand", hand, "Of a scene that names its hands: which")
      ->check(publication::hand_complaint);
}

void add_network(CLI::App& app, NetworkOptions& network) {
  app.add_option("--interface", network.interface,
                 "Network interface to keep to; default: the loopback, this machine alone");
  app.add_option("--peer", network.peers,
                 "Address of the other machine, where no multicast reaches it");
  app.add_option("--domain", network.domain, "DDS domain, default 0")
      ->check(command_line::integer_in(0, 230));
  auto* security = app.add_option(
      "--security", network.security,
      "Folder of DDS Security: identity_ca.pem, identity.pem, key.pem, permissions_ca.pem, "
      "governance.p7s, permissions.p7s");
  security->check(CLI::ExistingDirectory);
  app.add_flag("--open", network.is_open,
               "Whoever is in this private network may join: move the tool, and be felt")
      ->excludes(security);
}

void add_options(CLI::App& app, Arguments& arguments) {
  RelayOptions& options = arguments.options;
  add_session(app, options.session, arguments.hand);
  add_network(app, options.network);
  app.add_option("--duration", options.duration_s, "Time to run, s; default: until Ctrl-C")
      ->check(command_line::number_in(1e-3, 1e8));
  app.add_option("--group", arguments.group,
                 "Let this group of users read what is published here too; default: only its owner")
      ->check(publication::group_complaint);
  app.add_option("--report", arguments.report, "Write a report (JSON) at exit");
}

void add_ros(CLI::App& app, RosArguments& arguments) {
  add_session(app, arguments.ros.session, arguments.hand);
  add_network(app, arguments.network);
  app.add_option("--rate", arguments.ros.rate_hz,
                 "Messages a second on each topic at most, Hz; default 1000")
      ->check(command_line::number_in(0.1, 1000.0));
}

int run(Arguments& arguments, Role role) {
  command_line::prepare_daemon("scene_relay");
  arguments.options.session = publication::hand_session(arguments.options.session, arguments.hand);
  if (!arguments.group.empty())
    arguments.options.readers = publication::group_named(arguments.group);
  if (!arguments.report.empty()) files::require_writable(arguments.report);
  RelayReport report;
  int status = realtime::kDone;
  try {
    (role == Role::kHand ? relay_beside_hand : relay_beside_simulation)(arguments.options, report,
                                                                        realtime::stop_requested());
  } catch (const NetworkError& error) {
    spdlog::error(error.what());
    status = realtime::kCouldNotStart;
  } catch (const publication::SegmentError& error) {
    spdlog::error(error.what());
    status = realtime::kCouldNotStart;
  }
  if (!arguments.report.empty() && report.figures.relay_id != 0)
    write_report(report, arguments.report);
  return status;
}

int run_ros(RosArguments& arguments) {
  command_line::prepare_daemon("scene_relay");
  arguments.ros.session = publication::hand_session(arguments.ros.session, arguments.hand);
  try {
    const Participant participant(arguments.network);
    (void)run_ros_topics(participant.entity(), arguments.ros, realtime::stop_requested());
  } catch (const NetworkError& error) {
    spdlog::error(error.what());
    return realtime::kCouldNotStart;
  }
  return realtime::kDone;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "scene_relay");
  std::array<Arguments, 2> arguments;
  app.require_subcommand(1);
  CLI::App* simulation =
      app.add_subcommand("simulation", "Beside sim_server: sends its scene, brings the tool");
  CLI::App* hand =
      app.add_subcommand("hand", "Beside haptic_server: brings the scene, sends the tool");
  CLI::App* ros = app.add_subcommand("ros", "Publishes the tool's pose and force to ROS 2");
  RosArguments ros_arguments;
  add_ros(*ros, ros_arguments);
  add_options(*simulation, arguments[0]);
  add_options(*hand, arguments[1]);
  simulation->add_flag_callback(
      "--no-deltas", [&arguments] { arguments[0].options.has_deltas = false; },
      "Tell every snapshot whole, to compare");
  hand->add_option("--deadband", arguments[1].options.deadband,
                   "Keep back samples of the tool that are led on within this share of its "
                   "velocity; 0.07 is not noticed; default, and of a scene that is stepped "
                   "here: every tick is sent")
      ->check(command_line::number_in(0.001, 1.0));
  simulation
      ->add_option("--rate", arguments[0].options.rate_hz,
                   "Snapshots a second at most, Hz; default: all that are published")
      ->check(command_line::number_in(1.0, 1e4));
  command_line::add_version(
      app, {command_line::segment_interface(), "protocol " + std::to_string(kProtocol)});
  return command_line::run_program(app, argc, argv, [&] {
    if (ros->parsed()) return run_ros(ros_arguments);
    return hand->parsed() ? run(arguments[1], Role::kHand) : run(arguments[0], Role::kSimulation);
  });
}

}  // namespace
}  // namespace stillgrid::scene_relay

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::scene_relay::program_main(argc, argv);
}
