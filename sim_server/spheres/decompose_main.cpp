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

#include "shared/command_line/number_in.hpp"
#include "shared/command_line/version.hpp"
#include "shared/files/json_file.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/realtime/exit_status.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decompose_report.hpp"
#include "sim_server/spheres/fineness.hpp"
#include "sim_server/spheres/sphere_file.hpp"

namespace stillgrid::spheres {
namespace {

struct Arguments {
  std::filesystem::path mesh, out, report;
  Fineness fineness;
  double scale = 1.0;
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
    "  sphere_decompose part.stl --scale 0.001 --surface-spacing 0.004 --out part.csv\n"
    "      even spheres, 4 mm apart below the surface\n";

void add_options(CLI::App& app, Arguments& arguments) {
  app.add_option("MESH", arguments.mesh, "OBJ, OFF, STL or PLY file")->required();
  CLI::App* const kind = app.add_option_group("spheres");
  kind->require_option(1);
  kind->add_option("--tolerance", arguments.fineness.tolerance_m,
                   "Two-sided Hausdorff distance of mesh and spheres, m")
      ->check(command_line::number_in(1e-9, 1e3));
  kind->add_option("--surface-spacing", arguments.fineness.surface_spacing_m,
                   "Even spheres below the surface, so far apart, m")
      ->check(command_line::number_in(1e-9, 1e3));
  kind->add_option("--volume-spacing", arguments.fineness.volume_spacing_m,
                   "Even spheres through the volume, so far apart, m")
      ->check(command_line::number_in(1e-9, 1e3));
  app.add_option("--scale", arguments.scale, "Metres in the file's unit; default 1")
      ->check(command_line::number_in(1e-9, 1e9));
  app.add_option("--out", arguments.out, "Write x_m,y_m,z_m,radius_m (CSV), a row a sphere")
      ->required();
  app.add_option("--report", arguments.report,
                 "Write a report (JSON): mesh, number of spheres, distances");
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

/// Prints what was made. Returns whether it is what was asked for.
bool print_result(const Arguments& arguments, const Decomposition& made) {
  std::printf("%s: %zu spheres; mesh within %.3g m of them, they within %.3g m of it\n",
              arguments.out.c_str(), made.balls.size(), made.mesh_to_union_m, made.union_to_mesh_m);
  if (arguments.fineness.tolerance_m == 0.0 || made.is_reached()) return true;
  std::fprintf(stderr,
               "sphere_decompose: warning: %s: the tolerance of %.3g m was not reached, "
               "%.3g m was; a coarser one may be, or a mesh that does not cut itself\n",
               arguments.out.c_str(), made.tolerance_m, made.hausdorff_m);
  return false;
}

int run(const Arguments& arguments) {
  for (const auto& file : {arguments.out, arguments.report})
    if (!file.empty()) files::require_writable(file);
  const mesh::TriangleMesh read = mesh::load_mesh(arguments.mesh, arguments.scale);
  const mesh::ClosedMesh closed = mesh::make_closed(read, arguments.mesh.string());

  const auto start = std::chrono::steady_clock::now();
  const Decomposition made = cover_mesh(closed.mesh, arguments.fineness, progress_on_terminal());
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  clear_progress();

  write_spheres(made.balls, arguments.out);
  const bool is_as_asked = print_result(arguments, made);
  if (!arguments.report.empty()) {
    nlohmann::json json = report_fields(read, closed, arguments.fineness, made, time.count());
    json["mesh"]["file"] = arguments.mesh.string();
    json["mesh"]["scale"] = arguments.scale;
    json["file"] = arguments.out.string();
    files::write_json(arguments.report, json);
  }
  return is_as_asked ? realtime::kDone : realtime::kToleranceNotReached;
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
