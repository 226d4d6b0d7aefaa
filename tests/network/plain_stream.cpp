// A stream over Cyclone DDS as whoever begins with it sends one: its defaults, a message as large
// as the stream's, best effort or reliable with the last one kept. What scene_relay's snapshots and
// tool samples are measured beside (scripts/gallery/measure_relay_age.py).
#include "tests/network/plain_stream.h"  // of the IDL

#include <dds/dds.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/prepare_daemon.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/reading/histogram_json.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/histogram.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::network {
namespace {

using Message = stillgrid_plain_Message;

constexpr std::uint64_t kLook_ns = 1'000'000;
constexpr std::uint64_t kOld_ns = 100'000'000;

struct Arguments {
  bool is_reliable = false;
  double duration_s = 10.0, rate_hz = 30.0;
  std::uint32_t bytes = 100;
};

/// Throws std::runtime_error.
dds_entity_t require(dds_entity_t entity, const char* what) {
  if (entity < 0)
    throw std::runtime_error("DDS: " + std::string(what) + ": " + dds_strretcode(-entity));
  return entity;
}

struct Stream {
  dds_entity_t participant, topic;
  dds_qos_t* qos;
};

Stream open_stream(const Arguments& arguments) {
  const dds_entity_t participant =
      require(dds_create_participant(DDS_DOMAIN_DEFAULT, nullptr, nullptr), "participant");
  const dds_entity_t topic = require(dds_create_topic(participant, &stillgrid_plain_Message_desc,
                                                      "plain_stream", nullptr, nullptr),
                                     "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(
      qos, arguments.is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
  return {participant, topic, qos};
}

/// A message each period, until it is stopped.
int send(const Arguments& arguments) {
  const Stream stream = open_stream(arguments);
  const dds_entity_t writer =
      require(dds_create_writer(stream.participant, stream.topic, stream.qos, nullptr), "writer");
  std::vector<std::uint8_t> bytes(arguments.bytes, 0x5A);
  Message message{};
  message.bytes._buffer = bytes.data();
  message.bytes._length = message.bytes._maximum = arguments.bytes;
  const std::uint64_t end_ns = realtime::monotonic_ns() + realtime::to_ns(arguments.duration_s);
  realtime::PeriodicTimer timer(realtime::to_ns(1.0 / arguments.rate_hz));
  while (!realtime::stop_requested()) {
    message.sent_ns = timer.wait(&realtime::stop_requested()).now_ns;
    if (message.sent_ns >= end_ns) break;
    ++message.number;
    (void)dds_write(writer, &message);  // one that has no room is one that is not heard
  }
  dds_delete_qos(stream.qos);
  dds_delete(stream.participant);
  return realtime::kDone;
}

/// Looks each millisecond how old the newest message is.
int receive(const Arguments& arguments) {
  const Stream stream = open_stream(arguments);
  const dds_entity_t reader =
      require(dds_create_reader(stream.participant, stream.topic, stream.qos, nullptr), "reader");
  realtime::Histogram age_ns;
  std::uint64_t newest_ns = 0, received = 0;
  const std::uint64_t end_ns = realtime::monotonic_ns() + realtime::to_ns(arguments.duration_s);
  realtime::PeriodicTimer timer(kLook_ns);
  while (!realtime::stop_requested() && timer.wait(&realtime::stop_requested()).now_ns < end_ns) {
    void* sample = nullptr;
    dds_sample_info_t info;
    while (dds_take(reader, &sample, &info, 1, 1) == 1) {
      if (info.valid_data) {
        newest_ns = static_cast<const Message*>(sample)->sent_ns;
        ++received;
      }
      dds_return_loan(reader, &sample, 1);
      sample = nullptr;
    }
    if (newest_ns != 0) age_ns.record(realtime::monotonic_ns() - newest_ns);
  }
  nlohmann::json age_s = reading::histogram_json(age_ns, 1e-9);
  age_s["count"] = age_ns.count();
  age_s["over_100_ms"] = age_ns.share_above(kOld_ns);
  std::cout << nlohmann::json{{"received", received}, {"age_s", age_s}} << "\n";
  dds_delete_qos(stream.qos);
  dds_delete(stream.participant);
  return realtime::kDone;
}

int program_main(int argc, char** argv) {
  CLI::App app("A stream over Cyclone DDS with its defaults", "plain_stream");
  app.require_subcommand(1);
  Arguments arguments;
  CLI::App* sender = app.add_subcommand("send", "A message each period");
  CLI::App* receiver = app.add_subcommand("receive", "Prints how old the newest was, each ms");
  for (CLI::App* side : {sender, receiver}) {
    side->add_flag("--reliable", arguments.is_reliable, "What is lost is sent again");
    side->add_option("--duration", arguments.duration_s, "Time to run, s; default 10")
        ->check(command_line::number_in(1e-3, 1e6));
  }
  sender->add_option("--bytes", arguments.bytes, "Of a message; default 100")
      ->check(command_line::integer_in(1, 100'000'000));
  sender->add_option("--rate", arguments.rate_hz, "Messages a second, Hz; default 30")
      ->check(command_line::number_in(0.1, 1e5));
  return command_line::run_program(app, argc, argv, [&] {
    command_line::prepare_daemon("plain_stream");
    return sender->parsed() ? send(arguments) : receive(arguments);
  });
}

}  // namespace
}  // namespace stillgrid::network

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::network::program_main(argc, argv);
}
