#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/prepare_daemon.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/publication/hands.hpp"
#include "shared/publication/segment_files.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/realtime/stop_signal.hpp"
#include "shared/tools/scene_viewer/page_server.hpp"
#include "shared/tools/scene_viewer/recorded_view.hpp"
#include "shared/tools/scene_viewer/saved_view.hpp"
#include "shared/tools/scene_viewer/scene_message.hpp"
#include "shared/tools/scene_viewer/views.hpp"

namespace stillgrid::scene_viewer {
namespace {

struct Arguments {
  LiveOptions live;
  std::string hand, surfaces, open, recording;
  std::optional<int> port;
};

constexpr const char* kDescription =
    "Shows a session, or what was kept of one, as a page for a browser on this machine. It only\n"
    "reads, at low priority: the servers notice nothing of it.\n"
    "\n"
    "  scene_viewer --session demo                        then open the address that it prints\n"
    "  scene_viewer                                       the page chooses among sessions that "
    "run\n"
    "  sim_server --scene wall.toml --surfaces wall.json  bodies with a skin: the viewer's\n"
    "  scene_viewer --session demo --surfaces wall.json   --surfaces\n"
    "  scene_viewer --session demo --save run.view        and keep all that is shown\n"
    "  scene_viewer --open run.view                       to look at it again\n"
    "  scene_viewer --recording run.csv                   what haptic_server --record wrote\n"
    "\n"
    "It waits for servers that are not there yet. Ctrl-C ends it.\n";

void add_options(CLI::App& app, Arguments& arguments) {
  auto* session = app.add_option("--session", arguments.live.session,
                                 "The session that is shown first, which joins the two servers; "
                                 "USER/NAME: with USER's; default: one that runs")
                      ->transform(CLI::Validator(publication::settle_session, ""));
  app.add_option(
         "--hand", arguments.hand,
         "Of a scene that names its hands: whose snapshot and ticks are shown; of the others "
         "tool and force are")
      ->check(publication::hand_complaint)
      ->needs(session);
  auto* open = app.add_option("--open", arguments.open, "A view that --save kept");
  auto* recording = app.add_option("--recording", arguments.recording,
                                   "A recording (CSV) of haptic_server: the tool, no bodies");
  session->excludes(open)->excludes(recording);
  open->excludes(recording);
  app.add_option("--port", arguments.port,
                 "Of the page; 0: any that is free; default: 8642, or any where that is taken")
      ->check(command_line::integer_in(0, 65535));
  app.add_option("--surfaces", arguments.surfaces,
                 "Names and surfaces of the bodies (JSON), from sim_server --surfaces; shown where "
                 "that scene runs")
      ->excludes(open)
      ->excludes(recording);
  app.add_option("--save", arguments.live.save,
                 "Keep what is shown, frame by frame, for --open; some MB a minute")
      ->needs(session);
  app.add_option("--frames-per-s", arguments.live.frames_per_s, "Frames a second; default 30")
      ->check(command_line::number_in(1.0, 120.0))
      ->excludes(open)
      ->excludes(recording);
}

std::unique_ptr<Views> make_views(Arguments& arguments) {
  if (!arguments.open.empty())
    return std::make_unique<Views>(std::make_unique<SavedView>(arguments.open));
  if (!arguments.recording.empty())
    return std::make_unique<Views>(std::make_unique<RecordedView>(arguments.recording));
  arguments.live.session = publication::hand_session(arguments.live.session, arguments.hand);
  if (!arguments.hand.empty()) publication::require_hand(arguments.live.session);
  if (!arguments.surfaces.empty()) arguments.live.surfaces = read_surfaces(arguments.surfaces);
  return std::make_unique<Views>(arguments.live);
}

int run(Arguments& arguments) {
  // What others have to do comes first; threads made from here on have it from us.
  ::setpriority(PRIO_PROCESS, 0, 10);
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  const auto page = program.parent_path().parent_path() / "share" / "stillgrid" / "viewer";
  // Bad input is found before a view begins: that would empty the file of --save, and talk.
  std::unique_ptr<Views> views;
  PageServer server(arguments.port);
  views = make_views(arguments);
  if (!std::filesystem::exists(page / "index.html"))
    spdlog::warn("{}: no page is there, only /api is served", page.string());
  server.start(*views, page);
  std::printf("%s\n", server.address().c_str());
  std::fflush(stdout);
  while (!realtime::stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return realtime::kDone;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "scene_viewer");
  Arguments arguments;
  add_options(app, arguments);
  command_line::add_version(app, {command_line::segment_interface()});
  return command_line::run_program(app, argc, argv, [&] {
    command_line::prepare_daemon("scene_viewer");
    return run(arguments);
  });
}

}  // namespace
}  // namespace stillgrid::scene_viewer

int main(int argc, char** argv) {
  return stillgrid::scene_viewer::program_main(argc, argv);
}
