#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/json_file.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/realtime/exit_status.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decompose_report.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/feel.hpp"
#include "sim_server/spheres/feel_search.hpp"
#include "sim_server/spheres/fineness.hpp"
#include "sim_server/spheres/sphere_file.hpp"

namespace stillgrid::spheres {
namespace {

struct Arguments {
  std::filesystem::path mesh, out, report;
  Fineness fineness;
  std::string feel;  // a share of the force; empty: none is asked for
  std::size_t most_balls = kMaxFeltBalls;
  double scale = 1.0;
  double tool_radius_m = 0.0, press_depth_m = 0.0;  // 0: by the mesh's size
  int levels = 1;
};

constexpr const char* kDescription =
    "Covers a closed triangle mesh (OBJ, OFF, STL or PLY) with spheres: few, or even ones.\n"
    "\n"
    "With --tolerance no point of the mesh is farther than the tolerance from the surface of the "
    "union of spheres,\n"
    "nor that surface from the mesh. What is certain to be wrong in a mesh is repaired; an open "
    "one\n"
    "is refused, with the number of its open edges.\n"
    "\n"
    "  sphere_decompose liver.obj --scale 0.04 --tolerance 0.002 --out liver.csv\n"
    "      the file's unit is 4 cm; spheres within 2 mm of it, in metres\n"
    "  sphere_decompose part.stl --scale 0.001 --tolerance 0.0005 --out part.csv --report "
    "part.json\n"
    "      a file in millimetres; counts, errors and volumes beside\n"
    "  sphere_decompose part.stl --scale 0.001 --tolerance 0.0005 --levels 4 --out part.csv\n"
    "      part_1.csv (tolerance 4 mm) to part_4.csv (0.5 mm)\n"
    "  sphere_decompose part.stl --scale 0.001 --surface-spacing 0.004 --out part.csv\n"
    "      even spheres, 4 mm apart below the surface\n"
    "  sphere_decompose part.stl --scale 0.001 --feel 0.7jnd --tool-radius 0.004 --out part.csv\n"
    "      the fewest whose force on that tool is within 0.7 just noticeable differences of the "
    "mesh's\n";

void add_options(CLI::App& app, Arguments& arguments) {
  app.add_option("MESH", arguments.mesh, "OBJ, OFF, STL or PLY file")->required();
  CLI::App* const kind = app.add_option_group("spheres");
  kind->require_option(1);
  CLI::Option* const tolerance =
      kind->add_option("--tolerance", arguments.fineness.tolerance_m,
                       "Two-sided Hausdorff distance, m; a level's is twice the next finer one's")
          ->check(command_line::number_in(1e-9, 1e3));
  kind->add_option("--surface-spacing", arguments.fineness.surface_spacing_m,
                   "Even spheres below the surface, so far apart, m: more of them, less ripple")
      ->check(command_line::number_in(1e-9, 1e3));
  kind->add_option("--volume-spacing", arguments.fineness.volume_spacing_m,
                   "Even spheres through the volume, so far apart, m")
      ->check(command_line::number_in(1e-9, 1e3));
  CLI::Option* const feel =
      kind->add_option("--feel", arguments.feel,
                       "How far the force may be from the mesh's, rms: 5%, 0.05 or 0.7jnd, just "
                       "noticeable differences of 7 %")
          ->check(CLI::Validator(
              [](const std::string& text) {
                return read_force_share(text)
                           ? std::string()
                           : "value '" + text + "': expected " + kForceShareWords;
              },
              "SHARE"));
  app.add_option("--max-spheres", arguments.most_balls,
                 "Where a search for --feel ends; default " + std::to_string(kMaxFeltBalls))
      ->needs(feel)
      ->check(command_line::integer_in(1, 200000));
  app.add_option("--scale", arguments.scale, "Metres in the file's unit; default 1")
      ->check(command_line::number_in(1e-9, 1e9));
  app.add_option("--out", arguments.out, "Write x_m,y_m,z_m,radius_m (CSV), a row a sphere")
      ->required();
  app.add_option("--levels", arguments.levels,
                 "Levels of detail, written to FILE_1.csv (coarse) and on; default 1, to FILE.csv")
      ->needs(tolerance)
      ->check(command_line::integer_in(1, 12));
  app.add_option("--tool-radius", arguments.tool_radius_m,
                 "Radius of the tool whose force is reported, m; default 2 % of the box's diagonal")
      ->check(command_line::number_in(1e-9, 1e3));
  app.add_option(
         "--press-depth", arguments.press_depth_m,
         "How deep it is pressed, m; default a quarter of its radius, the tolerance at most")
      ->check(command_line::number_in(1e-9, 1e3));
  app.add_option(
      "--report", arguments.report,
      "Write a report (JSON): mesh, errors, and ripple, holes and stiffness of the force");
}

/// A line that is written over and over, where somebody looks.
DecompositionProgress progress_on_terminal() {
  if (isatty(STDERR_FILENO) == 0) return {};
  return [](const char* step, double done) {
    std::fprintf(stderr, "\r%-20s %3.0f %%", step, 100.0 * done);
  };
}

void clear_progress() {
  if (isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\r%26s\r", "");
}

std::filesystem::path file_of_level(const Arguments& arguments, std::size_t level) {
  const std::filesystem::path& file = arguments.out;
  if (arguments.levels == 1) return file;
  return file.parent_path() /
         (file.stem().string() + '_' + std::to_string(level + 1) + file.extension().string());
}

/// A line a level, for a search may take minutes.
void tell_searched(const FeltLevel& level) {
  std::fprintf(stderr, "sphere_decompose: %zu spheres: force within %.3g %% (%.3g JND)\n",
               level.balls.size(), 100.0 * level.error.share, level.error.jnd());
}

/// Spheres as asked for, and what a search by feel looked at.
struct Made {
  std::vector<Decomposition> levels;
  std::vector<FeltLevel> searched;
  double share = 0.0;  // that was searched for
};

Made make_spheres(const Arguments& arguments, const mesh::TriangleMesh& closed,
                  const Press& press) {
  if (arguments.feel.empty())
    return {cover_mesh(closed, arguments.fineness, arguments.levels, progress_on_terminal()), {}};
  constexpr double kPrecision = 0.05;  // of the error in metres, in the fineness
  Made made;
  made.share = read_force_share(arguments.feel).value();
  made.searched = search_by_feel(closed, press, made.share, tell_searched, arguments.most_balls);
  const FeltLevel& best = best_of(made.searched, made.share);
  made.levels = {with_error(MeshSolid(closed), best.balls, kPrecision * best.fineness_m)};
  return made;
}

/// Whether the level is what was asked for; a line says what it is.
bool tell_level(const Arguments& arguments, const std::filesystem::path& file,
                const Decomposition& level, const Feel& feel, const Press& press, double share) {
  std::printf(
      "%s: %zu spheres; mesh within %.3g m of them, they within %.3g m of it; force on a "
      "tool of %.3g m, %.3g m deep, within %.3g %% (%.3g JND) of the mesh's\n",
      file.string().c_str(), level.balls.size(), level.mesh_to_union_m, level.union_to_mesh_m,
      press.tool_radius_m, press.depth_m, 100.0 * feel.error.share, feel.error.jnd());
  if (share > 0.0 && !(feel.error.share <= share)) {
    std::fprintf(stderr,
                 "sphere_decompose: warning: %s: the feel of %s was not reached, %.3g %% "
                 "(%.3g JND) was, of at most %zu spheres; a larger tool or a deeper press feels "
                 "them nearer\n",
                 file.string().c_str(), arguments.feel.c_str(), 100.0 * feel.error.share,
                 feel.error.jnd(), arguments.most_balls);
    return false;
  }
  if (arguments.fineness.tolerance_m > 0.0 && !level.is_reached()) {
    std::fprintf(stderr,
                 "sphere_decompose: warning: %s: the tolerance of %.3g m was not reached, "
                 "%.3g m was; a coarser one may be, or a mesh that does not cut itself\n",
                 file.string().c_str(), level.tolerance_m, level.hausdorff_m);
    return false;
  }
  if (share == 0.0 && is_worse_than_nearest_face(feel))
    std::fprintf(stderr,
                 "sphere_decompose: warning: %s: a tool of %.3g m feels them %s, worse than the "
                 "nearest face; --feel 0.7jnd%s comes nearer\n",
                 file.string().c_str(), press.tool_radius_m, fault_of(feel).c_str(),
                 arguments.fineness.tolerance_m > 0.0 ? " or --surface-spacing" : "");
  return true;
}

int run(const Arguments& arguments) {
  for (const auto& file : {arguments.out, arguments.report})
    if (!file.empty()) files::require_writable(file);
  const mesh::TriangleMesh read = mesh::load_mesh(arguments.mesh, arguments.scale);
  const mesh::ClosedMesh closed = mesh::make_closed(read, arguments.mesh.string());
  const Press press = make_press(closed.mesh, arguments.tool_radius_m, arguments.press_depth_m,
                                 arguments.fineness.tolerance_m);

  const auto start = std::chrono::steady_clock::now();
  const Made made = make_spheres(arguments, closed.mesh, press);
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  clear_progress();

  const std::vector<Feel> feels = feels_of(made.levels, closed.mesh, press);
  nlohmann::json json =
      report_fields(read, closed, arguments.fineness, made.levels, feels, press, time.count());
  if (made.share > 0.0) json["feel"] = search_fields(made.share, made.searched);
  int status = realtime::kDone;
  json["mesh"]["file"] = arguments.mesh.string();
  json["mesh"]["scale"] = arguments.scale;
  for (std::size_t i = 0; i < made.levels.size(); ++i) {
    const std::filesystem::path file = file_of_level(arguments, i);
    write_spheres(made.levels[i].balls, file);
    if (!tell_level(arguments, file, made.levels[i], feels[i], press, made.share))
      status = realtime::kToleranceNotReached;
    json["levels"][i]["file"] = file.string();
  }
  if (!arguments.report.empty()) files::write_json(arguments.report, json);
  return status;
}

int program_main(int argc, char** argv) {
  CLI::App app(kDescription, "sphere_decompose");
  Arguments arguments;
  add_options(app, arguments);
  command_line::add_version(app);
  try {
    app.parse(argc, argv);
    return run(arguments);
  } catch (const CLI::Success& printed) {
    return app.exit(printed);
  } catch (const std::bad_alloc&) {
    clear_progress();
    std::fprintf(stderr, "sphere_decompose: out of memory\n");
    return realtime::kCouldNotStart;
  } catch (const std::exception& error) {
    clear_progress();
    std::fprintf(stderr, "sphere_decompose: %s\n", error.what());
    return realtime::kBadInput;
  }
  return 0;
}

}  // namespace
}  // namespace stillgrid::spheres

int main(int argc, char** argv) {
  return stillgrid::spheres::program_main(argc, argv);
}
