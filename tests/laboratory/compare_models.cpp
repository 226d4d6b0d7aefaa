// One path of the device through all intermediate models, a row of CSV each: what of
// docs/charts/model_table.csv is measured here. scripts/gallery/measure_models.py runs it.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "tests/laboratory/lab_cell.hpp"
#include "tests/laboratory/model_comparison.hpp"

namespace stillgrid::laboratory {
namespace {

struct Arguments {
  LabCell cell;
  double from_s = 0.0;
  std::string reference_scene;
  std::vector<std::string> names;
  std::vector<double> periods_s;
};

constexpr const char* kHead =
    "model,period_ms,jump_max_N,jump_p99_N,jump_max_jnd,jump_p99_jnd,slew_max_N_per_ms,slew_p99_N_"
    "per_ms,"
    "stage_max_jnd,stage_p99_jnd,stage_felt_share,rms_error_N,rms_error_at_lag_N,lag_ms,"
    "plateau_share,plateau_longest_ms,vibration_N2,vibration_at_harmonics_N2,energy_given_mJ,"
    "force_rms_N,longest_period_ms,tick_median_us,processor_ms_per_s\n";

void print_row(const std::string& name, double period_s, const ComparedRun& run) {
  const auto& [switches, slew, error, plateau, vibration, energy_given_J] = run.metrics;
  std::printf(
      "%s,%.6g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g,%.4g"
      ",%.4g,%.4g,%.4g,%.4g\n",
      name.c_str(), 1e3 * period_s, switches.jump_N.max, switches.jump_N.p99, switches.jump_jnd.max,
      switches.jump_jnd.p99, slew.max, slew.p99, run.stages.jnd.max, run.stages.jnd.p99,
      run.stages.felt_share, error.rms_N, error.rms_at_lag_N, 1e3 * error.lag_s, plateau.share,
      1e3 * plateau.longest_s, vibration.power_N2, vibration.at_harmonics_N2, 1e3 * energy_given_J,
      run.force_rms_N, 1e3 * run.longest_period_s, 1e6 * run.tick_median_s,
      1e3 * run.processor_s_per_s);
}

bool is_asked_for(const Arguments& arguments, const Contender& contender) {
  const auto& names = arguments.names;
  return names.empty() || std::find(names.begin(), names.end(), contender.name) != names.end();
}

/// One reference, at a tick a step, for all models and periods.
void compare_all(const Arguments& arguments) {
  LabCell reference_cell = arguments.cell;
  if (!arguments.reference_scene.empty()) reference_cell.scene = arguments.reference_scene;
  const LabOptions options = options_of(arguments.cell);
  const LabRun reference = path_reference(scene_of(reference_cell, std::nullopt), options);
  std::fputs(kHead, stdout);
  for (const double period_s : arguments.periods_s) {
    LabCell cell = arguments.cell;
    cell.period_s = period_s;
    const scene::SceneDescription scene = scene_of(cell, std::nullopt);
    for (const Contender& contender : contenders())
      if (is_asked_for(arguments, contender))
        print_row(contender.name, contender.period_s.value_or(period_s),
                  compare(scene, options_of(cell), contender, reference, arguments.from_s));
  }
  print_row("reference", 1.0 / options.tick_rate_hz,
            compare_reference(reference, arguments.from_s));
}

int program_main(int argc, char** argv) {
  CLI::App app("One path of the device through all intermediate models, as CSV", "compare_models");
  command_line::add_version(app, {command_line::device_interface()});
  Arguments arguments;
  LabCell& cell = arguments.cell;
  app.add_option("--scene", cell.scene, "FILE.toml, wall, free, chain or block")->required();
  app.add_option("--device", cell.device, "As haptic_server takes it; one that heeds no force")
      ->required();
  app.add_option("--period", arguments.periods_s, "Of the simulation, s; one or more")
      ->check(command_line::number_in(1e-4, 10.0))
      ->required();
  app.add_option("--latency", cell.latency_share, "What a step costs, of its period; default 0")
      ->check(command_line::number_in(0.0, 1.0));
  app.add_option("--jitter", cell.jitter, "Of the periods, default 0")
      ->check(command_line::number_in(0.0, 0.95));
  app.add_option("--seed", cell.seed, "Of the jitter")
      ->check(command_line::integer_in(0, 999'999'999'999'999));
  app.add_option("--friction", cell.friction, "Of contacts of the laboratory's scenes")
      ->check(command_line::number_in(0.0, 10.0));
  app.add_option("--duration", cell.duration_s, "Of a run, s; default 20")
      ->check(command_line::number_in(0.01, 1e5));
  app.add_option("--from", arguments.from_s, "What is measured begins here, s; default 0")
      ->check(command_line::number_in(0.0, 1e5));
  app.add_option("--models", arguments.names, "Rows by name; default all");
  app.add_option("--reference-scene", arguments.reference_scene,
                 "Whose force is the reference; default the scene itself");
  return command_line::run_program(app, argc, argv, [&] {
    compare_all(arguments);
    return realtime::kDone;
  });
}

}  // namespace
}  // namespace stillgrid::laboratory

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::laboratory::program_main(argc, argv);
}
