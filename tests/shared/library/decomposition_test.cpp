#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim_server/spheres/sphere_file.hpp"
#include "tests/shared/library/published_session.hpp"
#include "tests/sim_server/mesh/solids.hpp"

namespace stillgrid::library::decomposition_test {
namespace {

struct Arrays {
  std::vector<double> vertices_m;
  std::vector<std::uint32_t> triangles;
};

Arrays torus() {
  const mesh::TriangleMesh torus = mesh::torus_mesh(0.05, 0.02, 12, 6);
  Arrays arrays;
  for (const Eigen::Vector3d& vertex_m : torus.vertices_m)
    arrays.vertices_m.insert(arrays.vertices_m.end(), vertex_m.begin(), vertex_m.end());
  for (const Eigen::Vector3i& triangle : torus.triangles)
    for (const int vertex : triangle) arrays.triangles.push_back(std::uint32_t(vertex));
  return arrays;
}

Sized<stillgrid_cover> fineness(double tolerance_m, double surface_m, double volume_m) {
  Sized<stillgrid_cover> cover;
  cover.tolerance_m = tolerance_m;
  cover.surface_spacing_m = surface_m;
  cover.volume_spacing_m = volume_m;
  return cover;
}

std::string line_of(const Arrays& mesh, const Sized<stillgrid_cover>& cover) {
  try {
    const Decomposition made(mesh.vertices_m, mesh.triangles, cover);
  } catch (const Error& error) {
    CHECK(error.code() == STILLGRID_E_ARGUMENT);
    return error.what();
  }
  return {};
}

TEST_CASE("The library makes the spheres and the report of sphere_decompose", "[library]") {
  const publication::TestSession name;
  const auto folder = std::filesystem::temp_directory_path() / name.name();
  std::filesystem::create_directory(folder);
  const Arrays mesh = torus();
  {
    std::ofstream file(folder / "torus.obj");
    file.precision(std::numeric_limits<double>::max_digits10);
    for (std::size_t i = 0; i < mesh.vertices_m.size(); i += 3)
      file << "v " << mesh.vertices_m[i] << ' ' << mesh.vertices_m[i + 1] << ' '
           << mesh.vertices_m[i + 2] << '\n';
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
      file << "f " << mesh.triangles[i] + 1 << ' ' << mesh.triangles[i + 1] + 1 << ' '
           << mesh.triangles[i + 2] + 1 << '\n';
  }
  const auto [option, cover] = GENERATE(
      std::pair<std::string, Sized<stillgrid_cover>>{"--tolerance 0.004", fineness(0.004, 0, 0)},
      std::pair<std::string, Sized<stillgrid_cover>>{"--surface-spacing 0.01",
                                                     fineness(0, 0.01, 0)},
      std::pair<std::string, Sized<stillgrid_cover>>{"--volume-spacing 0.01",
                                                     fineness(0, 0, 0.01)});
  const std::string in = folder.string() + "/";
  REQUIRE(std::system((STILLGRID_BINARY_DIR "/bin/sphere_decompose " + in + "torus.obj " + option +
                       " --out " + in + "torus.csv --report " + in + "torus.json >/dev/null")
                          .c_str()) == 0);
  const auto balls = spheres::read_spheres(folder / "torus.csv");
  auto report = nlohmann::json::parse(std::ifstream(folder / "torus.json"));
  std::filesystem::remove_all(folder);

  const Decomposition made(mesh.vertices_m, mesh.triangles, cover);

  REQUIRE(made.spheres().size() == 4 * balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      CHECK(made.spheres()[4 * i + std::size_t(axis)] == balls[i].centre_m[axis]);
    CHECK(made.spheres()[4 * i + 3] == balls[i].radius_m);
  }
  auto told = nlohmann::json::parse(made.report());
  told.erase("time_s");
  report.erase("time_s");
  report["mesh"].erase("file");
  report["mesh"].erase("scale");
  report.erase("file");
  CHECK(told == report);
}

TEST_CASE("A mesh that has no inside, and fineness that is none, are refused in a line",
          "[library]") {
  const Arrays mesh = torus();
  const auto cover = fineness(0.004, 0, 0);
  const double kNan = std::numeric_limits<double>::quiet_NaN();
  Arrays open = mesh;
  open.triangles.resize(open.triangles.size() / 6 * 3);  // a half
  CHECK_THAT(line_of(open, cover), Catch::Contains("not closed"));
  Arrays foreign = mesh;
  foreign.triangles[4] = 0xFFFFFFFF;
  CHECK(line_of(foreign, cover).find("mesh: face 2") == 0);
  Arrays none = mesh;
  none.vertices_m[5] = kNan;
  CHECK(line_of(none, cover).find("mesh: vertex 2") == 0);
  CHECK(line_of({}, cover).find("mesh.vertices_m: expected an array") == 0);
  CHECK(line_of(mesh, fineness(0, 0, 0)).find("expected one") != std::string::npos);
  CHECK(line_of(mesh, fineness(0.004, 0.01, 0)).find("expected one") != std::string::npos);
  CHECK(line_of(mesh, fineness(kNan, 0, 0)).find("nan m: expected") != std::string::npos);
  CHECK(line_of(mesh, fineness(-0.01, 0, 0)).find("expected 1e-9") != std::string::npos);
  CHECK(line_of(mesh, fineness(1e-8, 0, 0)).find('\n') == std::string::npos);

  stillgrid_decomposition* made = nullptr;
  CHECK(stillgrid_decompose(nullptr, nullptr, &made) == STILLGRID_E_ARGUMENT);
  CHECK(stillgrid_decompose(nullptr, nullptr, nullptr) == STILLGRID_E_ARGUMENT);
  CHECK(made == nullptr);
  CHECK(stillgrid_decomposition_count(nullptr) == 0);
  stillgrid_decomposition_free(nullptr);
}

}  // namespace
}  // namespace stillgrid::library::decomposition_test
