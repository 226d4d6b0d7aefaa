// One candidate of a fit as one command line with one JSON result: what scene_fit runs, here or on
// other machines.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>

#include "haptic_server/device/negotiation.hpp"
#include "haptic_server/devices/phantom_model.hpp"
#include "shared/command_line/number_in.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/failing_writes.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/publication/segment.hpp"
#include "shared/realtime/exit_status.hpp"
#include "sim_server/dynamics/choice/method_choice.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/cannot_start.hpp"
#include "tests/laboratory/fit_run/fit_json.hpp"
#include "tests/laboratory/fit_run/fit_scene.hpp"

namespace stillgrid::fit_run {
namespace {

constexpr int kCrashed = 3;

constexpr const char* kDescription =
    "One candidate of a fit: simulates and renders a scene along a trajectory, in virtual time, "
    "and "
    "says by how much the force errs and what it costs, as one line of JSON.\n"
    "\n"
    "  fit_run organ --trajectory hand.csv --write-reference ref.csv\n"
    "      the truth: the scene as given, one implicit Euler step a millisecond, each snapshot "
    "shown "
    "at once\n"
    "  fit_run organ --trajectory hand.csv --reference ref.csv --set simulation.rate_hz=20 "
    "--margin "
    "2\n"
    "      a candidate against it: error, cost, and whether a hand that presses hard stays still\n"
    "\n"
    "ref.csv has its worlds beside it, in ref.state.csv: where candidates start, and where the "
    "hand "
    "presses. With --settle the scene first comes to rest without the tool, by the reference, so "
    "that "
    "all candidates start from the same world: scenes whose bodies fall cannot be compared "
    "otherwise.\n"
    "\n"
    "The error is the rms of the force's difference over the ticks in which either is in contact; "
    "its "
    "share is of the reference's rms there; 7 % is one just noticeable difference (JND). Cost is "
    "processor time; only it differs from run to run.\n"
    "\n"
    "--set KEY=VALUE, VALUE as TOML has it: simulation.rate_hz=50, "
    "simulation.integrator='\"velocity_verlet\"', "
    "grid.voxel_ratio=2, body.NAME.spheres.spacing_m=0.02, body.NAME.stiffness_scale=1.96, "
    "material.NAME.friction=0.1. What it contradicts goes: rate_hz replaces period_s and the "
    "reverse; an integrator the whole method of the file; one way to make a mesh's spheres the "
    "others.\n"
    "\n"
    "Exit status: 0 done, also if the candidate is bad (`problems` of the JSON say why); 1 bad "
    "input, one line; 2 the machine was at fault, and the same may do again: no temporary folder, "
    "no shared memory, no device plugin; 3 something broke.\n";

struct Arguments {
  std::string scene, transition = "predict", latency = "auto", device = "touch";
  FitPath path;
  std::filesystem::path write_reference, reference;
  int steps_per_tick = 1, repeats = 1;
  std::optional<double> settle_s, margin;
  bool search_margin = false;
  std::vector<std::string> set;
};

void add_options(CLI::App& app, Arguments& arguments) {
  app.add_option("SCENE", arguments.scene, "Scene file, or the name of one that ships")->required();
  app.add_option("--trajectory", arguments.path.trajectory, "CSV, as the replay device reads it")
      ->required();
  app.add_option("--replay", arguments.path.replay,
                 "Options of the replay device: scale=0.5,resample=cubic");
  app.add_option("--duration", arguments.path.duration_s,
                 "Seconds; default: the reference's, and its the trajectory's, at most 600")
      ->check(command_line::number_in(0.01, 600.0));
  app.add_option("--settle", arguments.settle_s,
                 "Seconds that the scene rests before, without the tool; default: the reference's, "
                 "and its 0")
      ->check(command_line::number_in(0.0, 600.0));
  auto* write = app.add_option("--write-reference", arguments.write_reference,
                               "Run the reference, and write it: REF.csv and REF.state.csv");
  app.add_option("--steps-per-tick", arguments.steps_per_tick,
                 "With it: steps of a millisecond; 2 tells what the reference itself errs")
      ->check(CLI::Range(1, 16))
      ->needs(write);
  auto* reference = app.add_option("--reference", arguments.reference,
                                   "REF.csv that the candidate is measured against")
                        ->excludes(write);
  const auto of_candidate = [&](CLI::Option* option) { option->needs(reference); };
  of_candidate(app.add_option("--set", arguments.set, "KEY=VALUE: another value in the scene")
                   ->allow_extra_args(false));
  of_candidate(
      app.add_option("--transition", arguments.transition, "As haptic_server's; default predict"));
  of_candidate(app.add_option("--latency-share", arguments.latency,
                              "How late a snapshot is, in periods; auto (default): as slow as the "
                              "step was measured, in tenths"));
  of_candidate(app.add_option("--repeats", arguments.repeats, "Cost is the median of so many runs")
                   ->check(CLI::Range(1, 1000)));
  of_candidate(app.add_option("--device", arguments.device,
                              "touch (default), touchx or premium15: whose hand presses"));
  of_candidate(app.add_option("--margin", arguments.margin,
                              "Test stability, contacts that many times as stiff: the hand that "
                              "presses hardest must come to rest, in contact")
                   ->check(command_line::number_in(0.01, 1000.0)));
  of_candidate(app.add_flag("--search-margin", arguments.search_margin,
                            "The largest stable margin of 1, 1.26, 1.59, 2, ... 16"));
}

[[noreturn]] void refuse(const std::string& option, const std::string& value,
                         const std::string& expected) {
  throw std::runtime_error(option + ": value '" + value + "': expected " + expected);
}

void print(const std::string& line) {
  std::printf("%s\n", line.c_str());
}

FitSettings settings_of(const Arguments& arguments, const scene::SceneDescription& scene) {
  return {.set = arguments.set,
          .scene = arguments.scene,
          .trajectory = arguments.path.trajectory.string(),
          .replay = arguments.path.replay,
          .transition = arguments.transition,
          .method = scene::describe(scene.method),
          .rate_hz = 1.0 / scene.period_s,
          .latency_share = std::nullopt,
          .settle_s = arguments.settle_s.value_or(0.0)};
}

int write_reference(Arguments& arguments) {
  const scene::SceneDescription given = scene::load_scene(find_scene(arguments.scene));
  scene::require_one_hand(given, find_scene(arguments.scene));
  for (const auto& file : {arguments.write_reference, state_file_of(arguments.write_reference)})
    files::require_writable(file);
  laboratory::LabRun run;
  const FitReference reference = make_reference(given, arguments.path, arguments.steps_per_tick,
                                                arguments.settle_s.value_or(0.0), run);
  try {
    write_reference(arguments.write_reference, given, reference);
  } catch (const std::runtime_error& error) {  // it could be written when this began
    throw laboratory::CannotStart(error.what());
  }
  const scene::SceneDescription scene = reference_scene(given, arguments.steps_per_tick);
  arguments.transition = display::name_of(display::Transition::kHold);
  FitSettings settings = settings_of(arguments, scene);
  settings.latency_share = 0.0;
  print(json_line(settings, reference, run, scene.period_s));
  return realtime::kDone;
}

/// The method that sim_server would choose.
void settle_method(scene::SceneDescription& scene) {
  if (!scene.choose_method) return;
  scene.method = dynamics::choose_method(scene, [](const std::string&) {}).method;
  scene.choose_method = false;
}

FitCandidate candidate_of(const Arguments& arguments) {
  FitCandidate candidate;
  const auto transition = display::transition_named(arguments.transition);
  if (!transition)
    refuse("--transition", arguments.transition, "a transition of haptic_server --help");
  candidate.transition = *transition;
  if (arguments.latency != "auto") {
    if (!command_line::number_in(0.0, 1.0)(arguments.latency).empty())
      refuse("--latency-share", arguments.latency, "auto, or a number from 0 to 1");
    candidate.latency_share = std::stod(arguments.latency);
  }
  candidate.repeats = arguments.repeats;
  if (!devices::phantom_profile(arguments.device))
    refuse("--device", arguments.device, "touch, touchx or premium15");
  candidate.scene = load_scene_with(find_scene(arguments.scene), arguments.set);
  if (candidate.scene.choose_rate)
    refuse("SCENE", arguments.scene, "a scene with a rate, or --set simulation.rate_hz=HZ");
  settle_method(candidate.scene);
  return candidate;
}

std::optional<FitStabilityResult> test_stability(const Arguments& arguments,
                                                 const FitCandidate& candidate,
                                                 const FitReference& reference, FitResult& result) {
  const bool is_asked = arguments.margin || arguments.search_margin;
  if (!is_asked || !result.problems.empty()) return std::nullopt;
  std::unique_ptr<scene::SceneDescription> loaded;
  const auto given = [&]() -> const scene::SceneDescription& {
    if (!loaded)
      loaded =
          std::make_unique<scene::SceneDescription>(scene::load_scene(find_scene(arguments.scene)));
    return *loaded;
  };
  FitStabilityResult stability{.profile = arguments.device,
                               .margin = arguments.margin.value_or(1.0),
                               .found = {},
                               .searched = arguments.search_margin,
                               .largest_margin = std::nullopt};
  const HeldPresses presses(candidate, result.latency_share, reference, given, arguments.device);
  stability.found = presses.at(stability.margin);
  if (!stability.found.stable)
    result.problems.emplace_back("stability not tested: the hand that presses touches nothing");
  else if (!*stability.found.stable)
    result.problems.emplace_back("unstable at its margin");
  if (stability.searched) stability.largest_margin = presses.largest_margin();
  return stability;
}

/// The device plugins are part of the program, not of what the user gave.
void require_plugins() {
  for (const char* const plugin : {"replay", "phantom"}) {
    try {
      (void)device::negotiate_device(plugin, {.period_ns = 1'000'000, .is_virtual = true});
    } catch (const device::DeviceError& error) {
      throw laboratory::CannotStart(error.what());
    }
  }
}

int run_fit(Arguments& arguments) {
  require_plugins();
  if (!arguments.write_reference.empty()) return write_reference(arguments);
  if (arguments.reference.empty()) refuse("--reference", "missing", "it, or --write-reference");
  const FitCandidate candidate = candidate_of(arguments);
  const FitReference reference = read_reference(arguments.reference, candidate.scene);
  if (arguments.settle_s && *arguments.settle_s != reference.settle_s)
    refuse("--settle", std::to_string(*arguments.settle_s),
           std::to_string(reference.settle_s) + ", as of " + arguments.reference.string());
  arguments.settle_s = reference.settle_s;
  FitResult result = run_candidate(candidate, arguments.path, reference);
  const auto stability = test_stability(arguments, candidate, reference, result);
  FitSettings settings = settings_of(arguments, candidate.scene);
  settings.latency_share = result.latency_share;
  print(json_line(settings, reference, result, candidate.repeats, stability));
  return realtime::kDone;
}

/// What is wrong with the machine, or with the program, has a status of its own.
int run_guarded(Arguments& arguments) {
  const auto fail = [](const std::exception& error, int status) {
    std::fprintf(stderr, "fit_run: %s\n", error.what());
    return status;
  };
  try {
    return run_fit(arguments);
  } catch (const laboratory::CannotStart& error) {
    return fail(error, realtime::kCouldNotStart);
  } catch (const publication::SegmentError& error) {
    return fail(error, realtime::kCouldNotStart);
  } catch (const std::logic_error& error) {
    return fail(error, kCrashed);
  } catch (const std::bad_alloc& error) {
    return fail(error, kCrashed);
  }
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "fit_run");
  Arguments arguments;
  add_options(app, arguments);
  command_line::add_version(app, {command_line::device_interface()});
  return command_line::run_program(app, argc, argv, [&] {
    files::make_writes_fail();
    return run_guarded(arguments);
  });
}

}  // namespace
}  // namespace stillgrid::fit_run

int main(int argc, char** argv) {
  return stillgrid::fit_run::program_main(argc, argv);
}
