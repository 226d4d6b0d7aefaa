// What the linear analysis says of every law at every rate, cost of a step and body, as CSV: the
// contact stiffness at which stability is first lost, inf where it is not by 100 kN/m. --small: two
// periods and three laws.
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/tools/laboratory/two_rate.hpp"

namespace stillgrid::laboratory::two_rate {
namespace {

std::string name_of(const Body& body) {
  std::array<char, 64> text{};
  if (body.masses == 1)
    std::snprintf(text.data(), text.size(), "free %g kg", body.mass_kg);
  else
    std::snprintf(text.data(), text.size(), "chain %d x %g g", body.masses, 1e3 * body.mass_kg);
  return text.data();
}

void print_rows(std::string_view law, const Cycle& cycle, int cost_ticks, double cost) {
  const auto period_ticks = static_cast<int>(cycle.size());
  const auto print_device = [&](const char* device_name, const Device& device) {
    for (const Body& body : reacting_bodies()) {
      const auto limit = stiffness_limit(Loop{device, body, cycle, cost_ticks});
      std::printf("%s,%d,%.3g,%d,%s,%s,%.6g\n", device_name, period_ticks, cost, cost_ticks,
                  name_of(body).c_str(), std::string(law).c_str(),
                  limit ? limit->limit_N_per_m : INFINITY);
    }
  };
  print_device("light", kLightDevice);
  print_device("hand", kDeviceInHand);
}

/// The periods and laws of the chart, but for the longest period, or all.
void print_all(bool is_small) {
  using Laws = std::vector<std::string_view>;
  const auto periods_ticks = is_small ? std::vector{10, 33} : std::vector{1, 2, 4, 10, 33, 100};
  Laws laws{"hold", "linear", "predict"};
  if (!is_small) {
    laws.clear();
    for (const display::TransitionLaw& law : display::transitions()) laws.push_back(law.name);
  }
  std::puts("device,period_ms,cost_share,cost_ms,body,law,limit_N_per_m");
  for (const int period_ticks : periods_ticks)
    for (const double cost : {0.0, 0.1, 0.2, 1.0 / 3.0, 0.5, 1.0}) {
      const int cost_ticks = static_cast<int>(std::lround(cost * period_ticks));
      for (const std::string_view name : laws)
        print_rows(name, cycle_of(*display::transition_named(name), period_ticks, cost_ticks),
                   cost_ticks, cost);
      print_rows("constraints", constraints_cycle(period_ticks), cost_ticks, cost);
      if (is_small) continue;
      print_rows("ramp 0.2 P", cycle_of(ramp(0.2), period_ticks), cost_ticks, cost);
      print_rows("ramp 0.2 P to 6 ms", cycle_of(ramp(0.2, 6.0), period_ticks), cost_ticks, cost);
      print_rows("ramp P", cycle_of(ramp(1.0), period_ticks), cost_ticks, cost);
    }
}

int program_main(int argc, char** argv) {
  CLI::App app("What the linear analysis says of every law at every rate, cost and body, as CSV",
               "two_rate_figures");
  command_line::add_version(app);
  bool is_small = false;
  app.add_flag("--small", is_small, "Two periods and three laws: seconds instead of a minute");
  return command_line::run_program(app, argc, argv, [&] {
    print_all(is_small);
    return realtime::kDone;
  });
}

}  // namespace
}  // namespace stillgrid::laboratory::two_rate

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::laboratory::two_rate::program_main(argc, argv);
}
