#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/run_program.hpp"
#include "shared/command_line/version.hpp"
#include "shared/publication/hands.hpp"
#include "shared/realtime/exit_status.hpp"
#include "shared/tools/segment_inspect/inspection_json.hpp"
#include "shared/tools/segment_inspect/inspection_text.hpp"
#include "shared/tools/segment_inspect/segment_summary.hpp"

namespace stillgrid::segment_inspect {
namespace {

struct Arguments {
  std::string session;
  bool is_json = false, remove_dead = false;
  std::optional<double> watch_s;
  JsonOptions json;
};

constexpr const char* kDescription =
    "Shows what stands in shared memory: every session, or one in detail. It only reads; the\n"
    "servers notice nothing of it.\n"
    "\n"
    "  segment_inspect                              every session: who writes, how fast, how old\n"
    "  segment_inspect --session demo               one in detail\n"
    "  segment_inspect --session demo+left          one hand's of a scene that names its hands\n"
    "  segment_inspect --session demo --json        its latest snapshot, every sphere of it\n"
    "  segment_inspect --session demo --json | jq '.scene.snapshot.spheres[0].position_m'\n"
    "  watch -n 1 segment_inspect                   again and again\n"
    "  segment_inspect --remove-dead                clears what killed servers left behind\n"
    "\n"
    "Exit status: 0 done, 1 a bad option, 2 no such session, or what it may not remove.\n";

void add_options(CLI::App& app, Arguments& arguments) {
  app.add_option("--session", arguments.session,
                 "Only this one, in detail; USER/NAME: of another user")
      ->transform(CLI::Validator(publication::settle_hand_session, ""));
  auto* json = app.add_flag("--json", arguments.is_json, "JSON, see docs/formats.md");
  auto* watch = app.add_option("--watch-s", arguments.watch_s,
                               "Measure the rates for that long, s; 0: not at all; default: 0.3, "
                               "or up to 2 where a slow simulation asks for it")
                    ->check(command_line::number_in(0.0, 3600.0));
  app.add_flag("--history", arguments.json.history, "With --json: earlier snapshots of each sphere")
      ->needs(json);
  app.add_option("--max-spheres", arguments.json.max_spheres,
                 "With --json: moving and static spheres, at most so many of each; default 100000")
      ->check(command_line::integer_in(0, 1'000'000'000))
      ->needs(json);
  app.add_flag("--remove-dead", arguments.remove_dead,
               "Remove what killed servers left; what lives is not touched")
      ->excludes(watch);
}

int fail(const char* what, realtime::ExitStatus status) {
  std::fprintf(stderr, "segment_inspect: %s\n", what);
  return status;
}

std::string absence(const std::string& session) {
  std::string line = "no session '" + session + "' in shared memory";
  for (const std::string& hand : publication::hands_of_session(session))
    line += ", but '" + publication::hand_session(session, hand) + "'";
  return line;
}

void print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
}

std::vector<publication::SegmentFile> segments_of(const std::string& session) {
  std::vector<publication::SegmentFile> files = publication::list_segments();
  if (!session.empty())
    std::erase_if(files,
                  [&](const publication::SegmentFile& file) { return file.session != session; });
  return files;
}

int remove_dead(const std::vector<publication::SegmentFile>& files, bool is_json) {
  int status = realtime::kDone;
  auto removed = nlohmann::ordered_json::array();
  for (const publication::SegmentFile& file : files) try {
      if (!remove_leftover(file)) continue;
      const std::string kind(name_of(file.kind));
      removed.push_back({{"session", file.session}, {"kind", kind}});
      if (!is_json) print("removed the " + kind + " segment of session " + file.session + "\n");
    } catch (const publication::SegmentError& error) {
      status = fail(reading::printable(error.what()).c_str(), realtime::kCouldNotStart);
    }
  if (is_json) print(text_of(removed) + "\n");
  if (!is_json && removed.empty()) print("nothing to remove\n");
  return status;
}

int show_session(const Arguments& arguments, const std::vector<publication::SegmentFile>& files) {
  std::vector<reading::ObservedSegment> observed;
  observed.reserve(files.size());
  for (const publication::SegmentFile& file : files) observed.push_back(reading::observe(file));
  measure_rates(observed, arguments.watch_s);
  for (reading::ObservedSegment& segment : observed) reading::look_again(segment);
  const auto of_kind = [&](proto::SegmentKind kind) -> const reading::ObservedSegment* {
    for (const reading::ObservedSegment& segment : observed)
      if (segment.summary.file.kind == kind &&
          segment.summary.state != reading::SegmentState::kGone)
        return &segment;
    return nullptr;
  };
  const auto* scene = of_kind(proto::SegmentKind::kScene);
  const auto* tool = of_kind(proto::SegmentKind::kTool);
  if (scene == nullptr && tool == nullptr)
    return fail(absence(arguments.session).c_str(), realtime::kCouldNotStart);
  const JsonOptions options = arguments.is_json ? arguments.json : JsonOptions{.max_spheres = 0};
  const auto json = json_of(arguments.session, scene, tool, options);
  print(arguments.is_json ? text_of(json) + "\n" : detail_of(json));
  return realtime::kDone;
}

int run(const Arguments& arguments) {
  const std::vector<publication::SegmentFile> files = segments_of(arguments.session);
  if (!arguments.session.empty() && files.empty())
    return fail(absence(arguments.session).c_str(), realtime::kCouldNotStart);
  if (arguments.remove_dead) return remove_dead(files, arguments.is_json);
  if (!arguments.session.empty()) return show_session(arguments, files);
  const auto json = json_of(survey(files, arguments.watch_s));
  print(arguments.is_json ? text_of(json) + "\n" : table_of(json));
  return realtime::kDone;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "segment_inspect");
  Arguments arguments;
  add_options(app, arguments);
  command_line::add_version(app, {command_line::segment_interface()});
  try {
    app.parse(argc, argv);
    return command_line::after_output(app, run(arguments));
  } catch (const CLI::Success& printed) {
    return command_line::after_output(app, app.exit(printed));
  } catch (const CLI::Error& error) {
    return fail(error.what(), realtime::kBadInput);
  } catch (const std::exception& error) {
    return fail(error.what(), realtime::kCouldNotStart);
  }
}

}  // namespace
}  // namespace stillgrid::segment_inspect

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape)
  return stillgrid::segment_inspect::program_main(argc, argv);
}
