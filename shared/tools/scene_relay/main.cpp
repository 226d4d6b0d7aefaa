#include <dds/dds.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <stdexcept>
#include <string>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/prepare_daemon.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/publication/hands.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/tools/scene_relay/ros_topics.hpp"

namespace stillgrid::scene_relay {
namespace {

struct Arguments {
  RosOptions ros;
  std::string hand;
  std::uint32_t domain = 0;
};

constexpr const char* kDescription =
    "Carries a session to other machines and other middleware. It only reads; the servers notice\n"
    "nothing of it.\n"
    "\n"
    "  scene_relay ros --session demo     the tool's pose and force as topics of ROS 2\n";

/// On this machine alone: the loopback interface, and peers that are asked one by one.
constexpr const char* kLoopback =
    "<Domain><General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    "<Peers><Peer address=\"localhost\"/></Peers></Discovery></Domain>";

/// A participant on this machine alone. Throws std::runtime_error.
dds_entity_t make_participant(std::uint32_t domain) {
  const dds_entity_t made = dds_create_domain(domain, kLoopback);
  const dds_entity_t participant =
      made < 0 ? made : dds_create_participant(domain, nullptr, nullptr);
  if (participant < 0)
    throw std::runtime_error("cannot join DDS domain " + std::to_string(domain) + ": " +
                             dds_strretcode(-participant));
  return participant;
}

void add_ros(CLI::App& app, Arguments& arguments) {
  CLI::App* const ros = app.add_subcommand("ros", "Publishes the tool's pose and force to ROS 2");
  ros->add_option("--session", arguments.ros.session,
                  "Name that joins the two servers; USER/NAME: with USER's")
      ->transform(CLI::Validator(publication::settle_session, ""))
      ->required();
  ros->add_option("--hand", arguments.hand, "Of a scene that names its hands: whose tool")
      ->check(publication::hand_complaint);
  ros->add_option("--rate", arguments.ros.rate_hz,
                  "At most so many messages a second on each topic, Hz; default 1000")
      ->check(command_line::number_in(0.1, 1000.0));
  ros->add_option("--domain", arguments.domain, "As ROS_DOMAIN_ID; default 0")
      ->check(command_line::integer_in(0, 232));
}

int run(Arguments& arguments) {
  arguments.ros.session = publication::hand_session(arguments.ros.session, arguments.hand);
  const dds_entity_t participant = make_participant(arguments.domain);
  (void)run_ros_topics(participant, arguments.ros, realtime::stop_requested());
  dds_delete(participant);
  return realtime::kDone;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "scene_relay");
  Arguments arguments;
  app.require_subcommand(1);
  add_ros(app, arguments);
  command_line::add_version(app, {command_line::segment_interface()});
  return command_line::run_program(app, argc, argv, [&] {
    command_line::prepare_daemon("scene_relay");
    return run(arguments);
  });
}

}  // namespace
}  // namespace stillgrid::scene_relay

int main(int argc, char** argv) {
  return stillgrid::scene_relay::program_main(argc, argv);
}
