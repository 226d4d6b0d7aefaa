// Whether a fitted scene is stable in the closed loop; scene_fit runs it.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "haptic_server/devices/phantom_model.hpp"
#include "shared/command_line/number_in.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/fit_run/held_press.hpp"

namespace stillgrid::fit_run {
namespace {

constexpr const char* kDescription =
    "Presses a scene in the closed loop where its own [hand] presses hardest, contacts --margin "
    "times as stiff, and says in one line of JSON whether the hand comes to rest.\n"
    "\n"
    "  fit_run ball_fitted.toml --transition local --margin 2\n";

struct Arguments {
  std::string scene, transition = "local", device = "touch";
  double margin = 1.0, latency_share = 0.0;
  bool search_margin = false;
};

int run(const Arguments& arguments) {
  const auto transition = display::transition_named(arguments.transition);
  if (!transition)
    throw std::runtime_error("--transition: value '" + arguments.transition +
                             "': expected a transition of haptic_server --help");
  if (!devices::phantom_profile(arguments.device))
    throw std::runtime_error("--device: value '" + arguments.device +
                             "': expected touch, touchx or premium15");
  const scene::SceneDescription scene = scene::load_scene(arguments.scene);
  if (!scene.hand || scene.choose_method)
    throw std::runtime_error(arguments.scene +
                             ": expected a scene with a table [hand] and an integrator");
  const Press press({scene, *transition, arguments.latency_share}, arguments.device);
  const HeldPress held = press.at(arguments.margin);
  nlohmann::ordered_json line = {{"stable", nullptr},
                                 {"margin", arguments.margin},
                                 {"swing_m", held.swing_m},
                                 {"truth_swing_m", held.truth_swing_m},
                                 {"largest_margin", nullptr}};
  if (held.stable) line["stable"] = *held.stable;
  if (arguments.search_margin)
    if (const auto margin = press.largest_margin()) line["largest_margin"] = *margin;
  std::printf("%s\n", line.dump().c_str());
  return realtime::kDone;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "fit_run");
  Arguments arguments;
  app.add_option("SCENE", arguments.scene, "Scene file with a table [hand]")->required();
  app.add_option("--transition", arguments.transition, "As haptic_server's; default local");
  app.add_option("--device", arguments.device,
                 "touch (default), touchx or premium15: whose hand presses");
  app.add_option("--margin", arguments.margin, "Contacts that many times as stiff; default 1")
      ->check(command_line::number_in(0.01, 1000.0));
  app.add_option("--latency-share", arguments.latency_share,
                 "How late a snapshot is, in periods; default 0")
      ->check(command_line::number_in(0.0, 1.0));
  app.add_flag("--search-margin", arguments.search_margin,
               "The largest stable margin of 1, 1.26, 1.59, 2, ... 16 too");
  command_line::add_version(app, {command_line::device_interface()});
  return command_line::run_program(app, argc, argv, [&] { return run(arguments); });
}

}  // namespace
}  // namespace stillgrid::fit_run

int main(int argc, char** argv) {
  return stillgrid::fit_run::program_main(argc, argv);
}
