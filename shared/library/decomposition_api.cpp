#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "shared/library/known_part.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decompose_report.hpp"
#include "sim_server/spheres/fineness.hpp"

struct stillgrid_decomposition {
  std::vector<double> spheres;  // 4 values each
  std::string report;
};

namespace stillgrid::library {
namespace {

int read_mesh(const stillgrid_mesh* given, mesh::PolygonMesh& polygons) {
  stillgrid_mesh mesh;
  if (const int code = take_known(given, "mesh", sizeof(stillgrid_mesh), mesh)) return code;
  if (mesh.vertices_m == nullptr || mesh.triangles == nullptr)
    return fail(STILLGRID_E_ARGUMENT, "mesh.%s: expected an array, not null",
                mesh.vertices_m == nullptr ? "vertices_m" : "triangles");
  for (std::size_t i = 0; i < mesh.vertex_count; ++i) {
    const double* v = mesh.vertices_m + 3 * i;
    polygons.add_vertex(v[0], v[1], v[2]);
  }
  for (std::size_t i = 0; i < mesh.triangle_count; ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner)
      polygons.add_corner(mesh.triangles[3 * i + corner]);
    polygons.end_face();
  }
  return STILLGRID_OK;
}

int read_cover(const stillgrid_cover* given, spheres::Fineness& fineness) {
  stillgrid_cover asked;
  if (const int code = take_known(given, "cover", sizeof(stillgrid_cover), asked)) return code;
  fineness = {asked.tolerance_m, asked.surface_spacing_m, asked.volume_spacing_m};
  int wanted = 0;
  for (const double length_m :
       {fineness.tolerance_m, fineness.surface_spacing_m, fineness.volume_spacing_m}) {
    if (length_m == 0.0) continue;
    ++wanted;
    if (!(length_m >= 1e-9 && length_m <= 1e3))
      return fail(STILLGRID_E_ARGUMENT, "cover: %g m: expected 1e-9 to 1000 m, or 0", length_m);
  }
  if (wanted == 1) return STILLGRID_OK;
  return fail(STILLGRID_E_ARGUMENT,
              "cover: %d of tolerance_m, surface_spacing_m and volume_spacing_m: expected one",
              wanted);
}

int decompose(const stillgrid_mesh* given_mesh, const stillgrid_cover* given_cover,
              stillgrid_decomposition** decomposition) {
  if (decomposition == nullptr)
    return fail(STILLGRID_E_ARGUMENT, "decomposition: expected a place for the handle, not null");
  *decomposition = nullptr;
  mesh::PolygonMesh polygons{"mesh", {}, {}, {}};
  spheres::Fineness fineness;
  try {
    if (const int code = read_mesh(given_mesh, polygons)) return code;
    if (const int code = read_cover(given_cover, fineness)) return code;
    const mesh::TriangleMesh read = mesh::sized_mesh(std::move(polygons), 1.0);
    const mesh::ClosedMesh closed = mesh::make_closed(read, "mesh");
    const auto start = std::chrono::steady_clock::now();
    const spheres::Decomposition cover = spheres::cover_mesh(closed.mesh, fineness);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    auto made = std::make_unique<stillgrid_decomposition>();
    for (const spheres::Ball& ball : cover.balls) {
      made->spheres.insert(made->spheres.end(), ball.centre_m.begin(), ball.centre_m.end());
      made->spheres.push_back(ball.radius_m);
    }
    made->report = spheres::report_fields(read, closed, fineness, cover, time.count()).dump(2);
    *decomposition = made.release();
  } catch (const std::runtime_error& error) {  // the mesh is none that can be covered so
    return fail(STILLGRID_E_ARGUMENT, "%s", error.what());
  }
  return STILLGRID_OK;
}

}  // namespace
}  // namespace stillgrid::library

int stillgrid_decompose(const stillgrid_mesh* mesh, const stillgrid_cover* cover,
                        stillgrid_decomposition** decomposition) {
  return stillgrid::library::guarded(
      [&] { return stillgrid::library::decompose(mesh, cover, decomposition); });
}

void stillgrid_decomposition_free(stillgrid_decomposition* decomposition) {
  delete decomposition;
}

uint32_t stillgrid_decomposition_count(const stillgrid_decomposition* decomposition) {
  return decomposition == nullptr ? 0 : static_cast<uint32_t>(decomposition->spheres.size() / 4);
}

const double* stillgrid_decomposition_spheres(const stillgrid_decomposition* decomposition) {
  return decomposition == nullptr ? nullptr : decomposition->spheres.data();
}

const char* stillgrid_decomposition_report(const stillgrid_decomposition* decomposition) {
  return decomposition == nullptr ? nullptr : decomposition->report.c_str();
}
