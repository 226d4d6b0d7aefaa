// The laboratory from the command line: one cell as a recording, its largest stable stiffness,
// maps.

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "haptic_server/recording/recorder.hpp"
#include "shared/command_line/number_in.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/json_file.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "shared/tables/number_table.hpp"
#include "tests/laboratory/lab_cell.hpp"
#include "tests/laboratory/metrics.hpp"
#include "tests/laboratory/stability_map.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr double kLeastRows_per_s = 100.0;  // of a recording of ticks

struct Arguments {
  LabCell cell;
  std::optional<double> stiffness_N_per_m;
  std::filesystem::path record, metrics, recorded;
  StiffnessSearch search;
  StabilityMap map;
  std::filesystem::path out;
  unsigned threads = 2;
};

constexpr const char* kDescription =
    "The laboratory for stability: sim_server's and haptic_server's code in one process, in "
    "virtual "
    "time.\n"
    "\n"
    "  stability_lab run --scene free:0.1 --period 0.033 --latency 0.1 --stiffness 2000 --record "
    "a.csv\n"
    "  stability_lab judge --scene pinch --device hand --jitter 0.3 --stiffness 5000\n"
    "  stability_lab limit --scene chain --device hand --transition hold --period 0.01\n"
    "  stability_lab map --scene free:0.05 free:0.1 chain --period 0.1 0.033 0.01 --out map.csv\n"
    "\n"
    "A scene is wall, or free, row, chain, spring, pinch, block, floor or soft, each with :KG if "
    "any, or a FILE.toml, whose method may be one that only the laboratory has; a device is light, "
    "hand, none, or as haptic_server takes it.\n";

void add_shared_options(CLI::App& app, Arguments& arguments) {
  LabCell& cell = arguments.cell;
  app.add_option("--resolution", cell.resolution_m, "Encoder step of light, hand, none, m")
      ->check(command_line::number_in(0.0, 1.0));
  app.add_option("--device-friction", cell.device_friction_N, "Coulomb's, of light, hand, none, N")
      ->check(command_line::number_in(0.0, 100.0));
  app.add_option("--damping", cell.contact_damping_N_s_per_m, "Of contacts of our scenes, N s/m")
      ->check(command_line::number_in(0.0, 1e6));
  app.add_option("--friction", cell.friction, "Of contacts of our scenes; default 0, of blocks 0.3")
      ->check(command_line::number_in(0.0, 10.0));
  app.add_option("--seed", cell.seed, "Of jitter and network; of a limit the first")
      ->check(command_line::integer_in(0, 999'999'999'999'999));
  app.add_option("--duration", cell.duration_s, "Of a run at least, s; default 20")
      ->check(command_line::number_in(0.01, 1e5));
}

/// What a cell has one of and a map several: numbers and names, or lists of them.
template <class Names, class Numbers>
struct Axes {
  Names &scene, &tool, &device, &limits, &from, &transition, &model;
  Numbers &period_s, &latency_share, &jitter;
};

template <class Names, class Numbers>
void add_axes(CLI::App& app, Axes<Names, Numbers> axes) {
  app.add_option("--scene", axes.scene, "Default wall");
  app.add_option("--tool", axes.tool, "1x1, 2x2 or 3x1 spheres, of our scenes; default 1x1");
  app.add_option("--device", axes.device, "Default light");
  app.add_option("--limits", axes.limits,
                 "Of light, hand, none: none, or declared, with its force, slew, friction, "
                 "encoders; default none");
  app.add_option(
      "--from", axes.from,
      "Of light, hand, none: inside, in contact, or outside, 10 mm above; default inside");
  app.add_option("--transition", axes.transition, "Default local");
  app.add_option("--model", axes.model, "Default grid");
  app.add_option("--period", axes.period_s, "Of the simulation, s; default 0.01")
      ->check(command_line::number_in(1e-4, 10.0));
  app.add_option("--latency", axes.latency_share, "What a step costs, of its period; default 0")
      ->check(command_line::number_in(0.0, 1.0));
  app.add_option("--jitter", axes.jitter, "Of the periods, default 0")
      ->check(command_line::number_in(0.0, 0.95));
}

void add_network_options(CLI::App& app, NetworkOptions& network) {
  app.add_option("--delay", network.path.delay_s, "Of a network between the sides, one way, s")
      ->check(command_line::number_in(0.0, 10.0));
  app.add_option("--delay-jitter", network.path.delay_jitter, "Of each packet's delay, default 0")
      ->check(command_line::number_in(0.0, 0.95));
  app.add_option("--loss", network.path.loss, "Of its packets, default 0")
      ->check(command_line::number_in(0.0, 0.95));
  app.add_option("--bytes", network.snapshot_bytes, "Of a snapshot on its way; default one packet")
      ->check(command_line::integer_in(0, 100'000'000));
  app.add_option("--kept", network.kept_snapshots,
                 "Snapshots that the sender keeps, to be asked for again; default 1")
      ->check(command_line::integer_in(1, 1000));
  app.add_option("--told-period", network.told_period_s,
                 "Of snapshots, as the hand is told, s: overdue ones fade; default --period")
      ->check(command_line::number_in(1e-4, 10.0));
  app.add_option("--deadband", network.deadband,
                 "Share of its velocity by which the tool must change for a sample to be sent; "
                 "default 0: every one is")
      ->check(command_line::number_in(0.0, 1.0));
}

void add_cell_options(CLI::App& app, Arguments& arguments) {
  LabCell& cell = arguments.cell;
  add_axes<std::string, double>(
      app, {cell.scene, cell.tool, cell.device, cell.limits, cell.from, cell.transition, cell.model,
            cell.period_s, cell.latency_share, cell.jitter});
  add_network_options(app, cell.network);
  add_shared_options(app, arguments);
}

void add_search_options(CLI::App& app, Arguments& arguments) {
  StiffnessSearch& search = arguments.search;
  app.add_option("--seeds", arguments.cell.seeds,
                 "Of the jitter, one after the other: the least limit counts; default 8")
      ->check(command_line::number_in(1, 1000));
  app.add_option("--lowest", search.lowest_N_per_m, "Of the search, N/m")
      ->check(command_line::number_in(1.0, 1e6));
  app.add_option("--highest", search.highest_N_per_m, "Of the search, N/m")
      ->check(command_line::number_in(1.0, 1e6));
}

void add_map_options(CLI::App& app, Arguments& arguments) {
  StabilityMap& map = arguments.map;
  add_axes<std::vector<std::string>, std::vector<double>>(
      app, {map.scenes, map.tools, map.devices, map.limits, map.froms, map.transitions, map.models,
            map.periods_s, map.latency_shares, map.jitters});
  app.add_option("--out", arguments.out, "CSV, a row a cell; rows that are there stay")->required();
  app.add_option("--threads", arguments.threads)->check(command_line::number_in(1, 64));
  add_shared_options(app, arguments);
  add_search_options(app, arguments);
}

nlohmann::json to_json(const Extremes& extremes) {
  return {{"p99", extremes.p99}, {"max", extremes.max}};
}

/// All metrics of a run but the stable stiffness, which takes many.
void write_metrics(const Arguments& arguments, const scene::SceneDescription& scene,
                   const LabOptions& options, const LabRun& run) {
  const RunMetrics metrics =
      metrics_of(run, run_reference(scene, options, run), 1.0 / arguments.cell.period_s);
  const auto& [switches, slew_N_per_ms, error, plateau, vibration, energy_given_J] = metrics;
  const auto ns_at = [](const realtime::Histogram& times, double share) {
    return times.percentile(share);
  };
  files::write_json(
      arguments.metrics,
      {{"scene", scene.name},
       {"transition", run.report.transition},
       {"model", arguments.cell.model},
       {"verdict", name_of(verdict_of(run.rows, rule_of(arguments.cell)))},
       {"switches", switches.count},
       {"switch_jump_N", to_json(switches.jump_N)},
       {"switch_jump_jnd", to_json(switches.jump_jnd)},
       {"slew_N_per_ms", to_json(slew_N_per_ms)},
       {"error_N",
        {{"rms", error.rms_N},
         {"max", error.max_N},
         {"rms_at_lag", error.rms_at_lag_N},
         {"lag_s", error.lag_s}}},
       {"plateau",
        {{"share", plateau.share},
         {"longest_s", plateau.longest_s},
         {"left_over", plateau.left_over}}},
       {"vibration_N2",
        {{"power", vibration.power_N2}, {"at_harmonics", vibration.at_harmonics_N2}}},
       {"energy_given_J", energy_given_J},
       {"network",
        {{"samples", run.network.samples},
         {"samples_sent", run.network.samples_sent},
         {"snapshots", run.network.snapshots},
         {"snapshots_shown", run.network.snapshots_shown},
         {"replaced", run.network.replaced},
         {"late", run.network.late}}},
       {"age_s", 1e-9 * static_cast<double>(ns_at(run.report.age_ns, 0.5))},
       {"tick_ns",
        {{"p50", ns_at(run.report.tick_ns, 0.5)}, {"p99", ns_at(run.report.tick_ns, 0.99)}}}});
}

void run_cell(const Arguments& arguments) {
  const scene::SceneDescription scene = scene_of(arguments.cell, arguments.stiffness_N_per_m);
  LabOptions options = options_of(arguments.cell);
  if (!arguments.metrics.empty()) {
    options.measures_ticks = true;  // in a run of its own: a recording has no times
    write_metrics(arguments, scene, options, run_lab(scene, options));
    options.measures_ticks = false;
  }
  if (!arguments.metrics.empty() && arguments.record.empty()) return;
  const LabRun run = run_lab(scene, options);
  if (!arguments.record.empty()) {
    recording::Recorder recorder(arguments.record, scene.name, run.report.device);
    for (const recording::TickRow& row : run.rows) recorder.record_waiting(row);
    if (recorder.finish() > 0)
      throw std::runtime_error(arguments.record.string() + ": could not be written");
  }
}

/// The rows of a recording in CSV, as far as a verdict needs them. Refuses one of less than
/// least_s.
std::vector<recording::TickRow> rows_of(const std::filesystem::path& file, double least_s) {
  tables::NumberTable table(file, "time_s,x_m,y_m,z_m,contacts", tables::LastLine::kMayBeCut);
  const auto column = [&](const std::string& name) { return table.require({name}, name); };
  const tables::Column time = column("time_s"), contacts = column("contacts");
  const std::array<tables::Column, 3> position = {column("x_m"), column("y_m"), column("z_m")};
  std::vector<recording::TickRow> rows;
  while (table.next()) {
    recording::TickRow& row = rows.emplace_back();
    row.time_s = table.number(time);
    if (rows.size() > 1 && !(row.time_s > rows[rows.size() - 2].time_s))
      table.refuse_value(time, "a time later than in the row before");
    for (std::size_t axis = 0; axis < 3; ++axis)
      row.position_m[static_cast<Eigen::Index>(axis)] = table.length_m(position[axis]);
    row.contacts = table.number(contacts) > 0.0 ? 1 : 0;
  }
  const double lasts_s = rows.empty() ? 0.0 : rows.back().time_s - rows.front().time_s;
  if (!(lasts_s >= least_s) || static_cast<double>(rows.size()) < least_s * kLeastRows_per_s)
    table.refuse_file("lasts " + std::to_string(lasts_s) + " s in " + std::to_string(rows.size()) +
                      " rows: expected " + std::to_string(least_s) + " s of ticks at least");
  return rows;
}

Verdict judged(const Arguments& arguments) {
  if (!arguments.recorded.empty()) {
    const VerdictRule rule = rule_of(arguments.cell);
    return verdict_of(rows_of(arguments.recorded, 2.0 * rule.window_s), rule);
  }
  return verdict_of(arguments.cell, arguments.stiffness_N_per_m.value_or(kAnyStiffness_N_per_m));
}

void find_limit(const Arguments& arguments) {
  const CellLimit found = limit_of(arguments.cell, arguments.search);
  if (!found.limit_N_per_m) {
    std::printf("%s at %.6g\n", name_of(found.lost_by).data(), arguments.search.lowest_N_per_m);
    return;
  }
  std::printf("%.6g\n", *found.limit_N_per_m);
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "stability_lab");
  app.require_subcommand(1);
  command_line::add_version(app, {command_line::device_interface()});
  Arguments arguments;
  auto* run = app.add_subcommand("run", "One closed loop");
  add_cell_options(*run, arguments);
  run->add_option("--stiffness", arguments.stiffness_N_per_m, "Of the scene's first material, N/m")
      ->check(command_line::number_in(1e-6, 1e9));
  run->add_option("--record", arguments.record, "Record every tick (CSV), as haptic_server does")
      ->check(recording::name_complaint);
  run->add_option("--metrics", arguments.metrics,
                  "Write the metrics against the reference (JSON), and what a tick takes here");
  auto* judge = app.add_subcommand(
      "judge", "What one closed loop comes to: stable, swings, parted or nowhere");
  add_cell_options(*judge, arguments);
  judge->add_option("--stiffness", arguments.stiffness_N_per_m, "N/m; default 1000")
      ->check(command_line::number_in(1e-6, 1e9));
  judge
      ->add_option("--recorded", arguments.recorded,
                   "Judge this recording (CSV) of haptic_server, and run nothing")
      ->check(CLI::ExistingFile);
  auto* device =
      app.add_subcommand("device", "Print a device of ours as haptic_server --device takes it");
  add_cell_options(*device, arguments);
  auto* text = app.add_subcommand("scene", "Print the file of a scene of ours");
  add_cell_options(*text, arguments);
  text->add_option("--stiffness", arguments.stiffness_N_per_m)
      ->check(command_line::number_in(1e-6, 1e9));
  auto* limit = app.add_subcommand("limit", "The largest stable stiffness, N/m");
  add_cell_options(*limit, arguments);
  add_search_options(*limit, arguments);
  limit
      ->add_option("--step", arguments.search.step,
                   "Ratio of neighbours of the search; default 1.05")
      ->check(command_line::number_in(1.001, 10.0));
  auto* map =
      app.add_subcommand("map", "The largest stable stiffness of every combination, as CSV");
  add_map_options(*map, arguments);
  return command_line::run_program(app, argc, argv, [&] {
    if (arguments.search.lowest_N_per_m > arguments.search.highest_N_per_m)
      throw std::runtime_error("--lowest: expected no more than --highest");
    if (map->parsed()) realtime::install_stop_signal();
    if (run->parsed()) run_cell(arguments);
    if (judge->parsed()) std::puts(name_of(judged(arguments)).data());
    if (device->parsed()) {
      if (!lab_hand_named(arguments.cell.device))
        throw std::runtime_error("--device: value '" + arguments.cell.device +
                                 "': expected light, hand or none");
      std::puts(options_of(arguments.cell).device.c_str());
    }
    if (text->parsed())
      std::fputs(
          scene_text_of(arguments.cell, arguments.stiffness_N_per_m.value_or(kAnyStiffness_N_per_m))
              .c_str(),
          stdout);
    if (limit->parsed()) find_limit(arguments);
    if (map->parsed()) {
      arguments.map.common = arguments.cell;
      draw_map(arguments.map, arguments.search, arguments.threads, arguments.out);
    }
    return realtime::kDone;
  });
}

}  // namespace
}  // namespace stillgrid::laboratory

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::laboratory::program_main(argc, argv);
}
