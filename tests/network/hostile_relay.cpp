#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/scene_relay/network.hpp"
#include "shared/tools/scene_relay/relay.hpp"
#include "tests/network/hostile_samples.hpp"

namespace stillgrid::network {
namespace {

using scene_relay::Delivery;

constexpr const char* kDescription =
    "A relay that is none of ours, for relay_hostile_test: it joins a session in a protocol of\n"
    "another release, or listens to what the relays tell each other and sends it changed.\n"
    "Prints how many messages it sent.\n";

struct Arguments {
  std::string session, interface;
  double seconds = 1.0;
  std::uint64_t seed = 1, protocol = 99, role = 1;
  bool steals = false;
};

/// A topic of the session, listened to and written to.
template <class Message>
class Overheard {
 public:
  Overheard(const scene_relay::Participant& participant, const dds_topic_descriptor_t& type,
            const std::string& topic, Delivery delivery)
      : writer_(participant.writer(type, topic, delivery)),
        reader_(participant.reader(type, topic, delivery, false)) {
    // What this program sends is no relay's.
    dds_get_instance_handle(writer_, &own_);
  }

  /// The newest of a relay's, changed; in its name, or in that of relay_id. Whether there was one.
  bool send(HostileSamples& samples, std::uint64_t relay_id, bool steals) {
    void* taken[1] = {};
    dds_sample_info_t info[1];
    const dds_return_t count = dds_read(reader_, taken, info, 1, 1);
    if (count <= 0) return false;
    const bool is_relays = info[0].valid_data && info[0].publication_handle != own_;
    if (is_relays) {
      auto message = samples.changed(*static_cast<const Message*>(taken[0]));
      if (!steals) message.relay_id = relay_id;
      dds_write(writer_, &message);
    }
    dds_return_loan(reader_, taken, count);
    return is_relays;
  }

 private:
  dds_entity_t writer_, reader_;
  dds_instance_handle_t own_ = 0;
};

std::uint64_t send_samples(const scene_relay::Participant& participant,
                           const Arguments& arguments) {
  const auto topic = [&](const char* name) {
    return scene_relay::topic_of(arguments.session, name);
  };
  Overheard<scene_relay::Status> hand(participant, stillgrid_relay3_Status_desc, topic("hand"),
                                      Delivery::kBestEffort);
  Overheard<scene_relay::Status> simulation(participant, stillgrid_relay3_Status_desc,
                                            topic("simulation"), Delivery::kBestEffort);
  Overheard<scene_relay::ToolMessage> tool(participant, stillgrid_relay3_Tool_desc, topic("tool"),
                                           Delivery::kBestEffort);
  Overheard<scene_relay::SceneMessage> scene(participant, stillgrid_relay3_Scene_desc,
                                             topic("scene"), Delivery::kLasting);
  Overheard<scene_relay::SnapshotMessage> snapshot(participant, stillgrid_relay3_Snapshot_desc,
                                                   topic("snapshot"), Delivery::kNewest);
  HostileSamples samples(arguments.seed);
  const std::uint64_t end_ns = realtime::monotonic_ns() + realtime::to_ns(arguments.seconds);
  std::uint64_t sent = 0, round = 0;
  while (realtime::monotonic_ns() < end_ns) {
    const auto send = [&](auto& overheard) {
      sent += overheard.send(samples, arguments.seed + 1, arguments.steals) ? 1U : 0U;
    };
    if (++round % 10 == 0) {
      send(hand);
      send(simulation);
    }
    if (round % 50 == 0) send(scene);
    send(tool);
    send(snapshot);
    participant.wait(realtime::monotonic_ns() + 1'000'000);
  }
  return sent;
}

std::uint64_t send_greetings(const scene_relay::Participant& participant,
                             const Arguments& arguments) {
  const dds_entity_t writer =
      participant.writer(stillgrid_Greeting_desc, scene_relay::greeting_topic(arguments.session),
                         Delivery::kBestEffort);
  scene_relay::Greeting greeting{};
  greeting.relay_id = arguments.seed + 1;
  greeting.protocol = static_cast<std::uint32_t>(arguments.protocol);
  greeting.role = static_cast<std::uint32_t>(arguments.role);
  std::string("99.0\x1b[2J").copy(greeting.release, sizeof greeting.release - 1);
  const std::uint64_t end_ns = realtime::monotonic_ns() + realtime::to_ns(arguments.seconds);
  std::uint64_t sent = 0;
  for (; realtime::monotonic_ns() < end_ns; ++sent) {
    dds_write(writer, &greeting);
    participant.wait(realtime::monotonic_ns() + 200'000'000);
  }
  return sent;
}

int program_main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(kDescription, "hostile_relay");
  app.require_subcommand(1);
  CLI::App* const greeting = app.add_subcommand("greeting", "Joins in another protocol");
  CLI::App* const samples = app.add_subcommand("samples", "Sends what it hears, changed");
  for (CLI::App* command : {greeting, samples}) {
    command->add_option("--session", arguments.session, "Name of the session")->required();
    command->add_option("--interface", arguments.interface, "Network interface")->required();
    command->add_option("--seconds", arguments.seconds, "Time to run, s")
        ->check(command_line::number_in(0.1, 1e4));
    command->add_option("--seed", arguments.seed, "Of all that is drawn, and its relay_id");
  }
  greeting->add_option("--protocol", arguments.protocol, "That it speaks; default 99");
  greeting->add_option("--role", arguments.role, "1: beside the simulation, 2: beside the hand");
  samples->add_flag("--steal", arguments.steals, "In the names of the relays that it hears");
  return command_line::run_program(app, argc, argv, [&] {
    scene_relay::NetworkOptions options;
    options.interface = arguments.interface;
    options.is_open = true;
    const scene_relay::Participant participant(options);
    std::cout << (samples->parsed() ? send_samples(participant, arguments)
                                    : send_greetings(participant, arguments))
              << '\n';
    return static_cast<int>(realtime::kDone);
  });
}

}  // namespace
}  // namespace stillgrid::network

int main(int argc, char** argv) {
  return stillgrid::network::program_main(argc, argv);
}
