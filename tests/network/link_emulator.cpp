// Two machines on one: what scene_relay is tested over.
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "tests/network/link_pump.hpp"
#include "tests/network/network_side.hpp"

namespace stillgrid::network {
namespace {

constexpr const char* kDescription =
    "Two machines on one, a and b, and a link between them that delays, loses, repeats, reorders "
    "and\n"
    "corrupts packets: two network namespaces with an interface \"link\" each (10.77.0.1, "
    "10.77.0.2), each with\n"
    "a /dev/shm and, with --clock-offset, a monotonic clock of its own. Needs no root where user "
    "namespaces\n"
    "may be made.\n"
    "\n"
    "  link_emulator 'delay_ms 10' 'loss 0.01' 'a partition on'\n"
    "\n"
    "A setting is 'KEY VALUE', of both directions, or 'a KEY VALUE' of what a sends. Keys: "
    "delay_ms,\n"
    "jitter_ms, loss, duplicate, reorder, reorder_ms, corrupt, rate_mbit_per_s, partition.\n"
    "The first line of standard output is JSON: how to enter the sides. Then each line of standard "
    "input is a\n"
    "setting, answered by 'ok' or what is wrong with it, or 'counters', answered by them as JSON. "
    "At the end of\n"
    "standard input every process of both sides is killed, and the last line holds the counters.\n"
    "Exit status: 0; 1 bad input; 2 the machine does not grant what this needs, said in a line.\n";

struct Arguments {
  std::vector<std::string> settings;
  double clock_offset_s = 0.0;
  std::uint64_t seed = 1;
};

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// Throws std::runtime_error.
void apply_line(LinkPump& pump, const std::string& line) {
  std::vector<std::string> words = words_of(line);
  const bool is_of_one = words.size() == 3 && (words[0] == "a" || words[0] == "b");
  if (!is_of_one && words.size() != 2)
    throw std::runtime_error("'" + line + "': expected [a|b] KEY VALUE, or counters");
  for (const std::size_t side : {0U, 1U})
    if (!is_of_one || words[0] == (side == 0 ? "a" : "b"))
      apply_setting(pump.sent_by(side).settings, words[words.size() - 2], words.back());
}

nlohmann::json json_of(const LinkDirection& direction) {
  const LinkCounters& counters = direction.counters();
  return {{"sent", counters.sent},
          {"duplicated", counters.duplicated},
          {"delivered", counters.delivered},
          {"lost", counters.lost},
          {"partitioned", counters.partitioned},
          {"overflowed", counters.overflowed},
          {"refused", counters.refused},
          {"on_their_way", direction.on_their_way()},
          {"reordered", counters.reordered},
          {"corrupted", counters.corrupted},
          {"delivered_bytes", counters.delivered_bytes}};
}

void print_counters(LinkPump& pump) {
  const nlohmann::json json = {{"a", json_of(pump.sent_by(0))}, {"b", json_of(pump.sent_by(1))}};
  std::cout << json.dump() << std::endl;
}

void answer(LinkPump& pump, const std::string& line) {
  if (line == "counters") return print_counters(pump);
  try {
    apply_line(pump, line);
    std::cout << "ok" << std::endl;
  } catch (const std::runtime_error& error) {
    std::cout << error.what() << std::endl;
  }
}

/// Answers the lines of standard input as they come, until its end or a signal to stop.
void serve(LinkPump& pump) {
  std::string text;
  std::array<char, 4096> part;
  while (!realtime::stop_requested()) {
    if (!pump.carry_until_readable(STDIN_FILENO)) continue;
    const ssize_t size = ::read(STDIN_FILENO, part.data(), part.size());
    if (size <= 0) return;
    text.append(part.data(), static_cast<std::size_t>(size));
    for (std::size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1))
      answer(pump, text.substr(0, end));
  }
}

/// What stands before the command line of a program that is to run in a side.
std::vector<std::string> entrance(const NetworkSide& side, bool is_user) {
  std::vector<std::string> words = {"nsenter", "--target", std::to_string(side.holder), "--net",
                                    "--mount"};
  if (is_user) words.insert(words.end(), {"--user", "--preserve-credentials"});
  if (side.has_own_clock) words.emplace_back("--time");
  return words;
}

/// Wakes on time as far as it is granted: before programs at ordinary priority, behind the haptic
/// loop.
void wake_on_time() {
  ::prctl(PR_SET_TIMERSLACK, 1UL);
  sched_param first{};
  first.sched_priority = 1;
  ::sched_setscheduler(0, SCHED_FIFO, &first);
}

int run(const Arguments& arguments) {
  const bool is_user = enter_own_rights();
  const Lifeline lifeline = make_lifeline();
  const NetworkSide a = make_side("10.77.0.1", 0.0, lifeline);
  const NetworkSide b = make_side("10.77.0.2", arguments.clock_offset_s, lifeline);
  leave_sides();
  LinkPump pump({a.tun, b.tun}, arguments.seed);
  for (const std::string& line : arguments.settings) apply_line(pump, line);
  realtime::install_stop_signal();
  wake_on_time();
  std::cout << nlohmann::json{{"a", entrance(a, is_user)}, {"b", entrance(b, is_user)}}.dump()
            << std::endl;
  serve(pump);
  print_counters(pump);
  ::close(lifeline.write);
  for (const NetworkSide& side : {a, b}) ::waitpid(side.holder, nullptr, 0);
  return realtime::kDone;
}

int program_main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(kDescription, "link_emulator");
  app.add_option("SETTING", arguments.settings, "'KEY VALUE' or 'a KEY VALUE'");
  app.add_option("--clock-offset", arguments.clock_offset_s,
                 "How far b's monotonic clock is ahead, s; default 0: both have this machine's")
      ->check(command_line::number_in(-1e6, 1e6));
  app.add_option("--seed", arguments.seed, "Of all that is drawn; default 1")
      ->check(command_line::integer_in(0, 999'999'999'999'999));
  return command_line::run_program(app, argc, argv, [&arguments] {
    try {
      return run(arguments);
    } catch (const NotGranted& missing) {
      std::cerr << "link_emulator: not granted: " << missing.what() << '\n';
      return static_cast<int>(realtime::kCouldNotStart);
    }
  });
}

}  // namespace
}  // namespace stillgrid::network

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::network::program_main(argc, argv);
}
