#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "tests/sim_server/spheres/generated_solids.hpp"
#include "tests/sim_server/spheres/pushed_out.hpp"

// No spheres that are offered for a body that does not deform may be pushed through.
namespace stillgrid::spheres::firm_sampling_test {
namespace {

struct Named {
  std::string name;
  mesh::TriangleMesh mesh;
};

std::vector<Named> generated_solids() {
  return {{"torus", mesh::torus_mesh(1.0, 0.31, 61, 25)},
          {"box", random_box(1)},
          {"star", star_mesh(2, 0.12, 22, 11)},
          {"slab", slab_mesh(3, 17, 13, 0.21, -4.3)}};
}

/// By every way, as coarse as named, in shares of the solid's size.
std::vector<Ball> balls_of(const std::string& way, const MeshSolid& solid, double fineness_m) {
  if (way == "surface") return firm_surface_balls(solid.mesh, fineness_m);
  if (way == "volume") return firm_volume_balls(solid.mesh, fineness_m);
  return decompose(solid.mesh, fineness_m).balls;
}

void check_pushed_out(const Named& named, const std::string& way, double fineness, double share) {
  const MeshSolid solid(named.mesh);
  const double fineness_m = fineness * solid.size_m;
  const std::vector<Ball> balls = balls_of(way, solid, fineness_m);
  for (const double tools : {2.0, 3.3, 5.1}) {
    CAPTURE(named.name, way, fineness, tools, balls.size());
    const double first_m = (way == "tolerance" ? 2.0 : 1.0) * fineness_m;
    const PushedOut out =
        press_in(solid, balls, tools * fineness_m, first_m, share, fineness_m, 401);
    if (out.presses == 0) continue;  // a tool that fits nowhere
    CAPTURE(out.worst_m.transpose());
    CHECK(out.least > 0.0);
  }
}

TEST_CASE("Whatever its spheres are made by, no tool is pulled in or let go as deep as is promised",
          "[firm]") {
  const std::string way = GENERATE("surface", "volume", "tolerance");
  for (const Named& named : generated_solids())
    for (const double fineness : {0.0131, 0.0273})
      if (way == "surface" || fineness > 0.02)  // the finer takes long
        check_pushed_out(named, way, fineness, kFirmShare);
}

TEST_CASE("Nor half the way to the medial axis of scanned and drawn meshes", "[firm][real_data]") {
  const char* const named = std::getenv("STILLGRID_DATA");
  const std::filesystem::path meshes =
      (named ? std::filesystem::path(named)
             : std::filesystem::path(STILLGRID_SOURCE_DIR) / ".." / "shared" / "data") /
      "meshes";
  if (!std::filesystem::exists(meshes)) {
    WARN("skipped: no meshes");
    return;
  }
  const std::string way = GENERATE("surface", "volume", "tolerance");
  for (const char* const file : {"npm_bunny.off", "sofa_liver-smooth.obj", "mujoco_spot.obj"})
    check_pushed_out({file, mesh::make_closed(mesh::load_mesh(meshes / file, 1.0), file).mesh}, way,
                     0.0153, 0.5);
}

TEST_CASE(
    "Firm balls touch the surface from inside and are touched in about equal numbers, thick "
    "or thin",
    "[firm]") {
  const MeshSolid solid(mesh::torus_mesh(1.0, 0.31, 61, 25));
  for (const Ball& ball : firm_surface_balls(solid.mesh, 0.05))
    CHECK(ball.radius_m == Approx(-solid.distance.signed_distance_m(ball.centre_m)).margin(1e-12));
  // A box 20 spacings thick and one of 4: a tool that lies on either touches as many.
  const auto touched = [](double thick_m) {
    const mesh::TriangleMesh box = mesh::box_mesh(Eigen::Vector3d::Zero(), {1.0, 1.0, thick_m});
    const std::vector<Ball> made = firm_surface_balls(box, 0.02);
    double sum = 0.0;
    for (int place = 0; place < 100; ++place)
      for (const Ball& ball : made)
        sum += (ball.centre_m - Eigen::Vector3d(0.3 + 0.04 * (place % 10),
                                                0.3 + 0.04 * (place / 10), thick_m + 0.05))
                   .norm() < ball.radius_m + 0.06;
    return sum / 100.0;
  };
  CHECK(touched(0.08) == Approx(touched(0.4)).epsilon(0.15));
}

}  // namespace
}  // namespace stillgrid::spheres::firm_sampling_test
