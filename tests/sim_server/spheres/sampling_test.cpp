#include "sim_server/spheres/sampling.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "sim_server/mesh/mesh_distance.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/surface_samples.hpp"
#include "tests/sim_server/mesh/solids.hpp"

namespace stillgrid::spheres::sampling_test {
namespace {

TEST_CASE("A cube of edge n spacings holds n cubed lattice points", "[sampling]") {
  const int n = GENERATE(1, 2, 4, 8);
  const std::vector<Ball> balls = volume_balls(mesh::cube_mesh(), 1.0 / n, 0.1);
  CHECK(balls.size() == static_cast<std::size_t>(n * n * n));
  CHECK((balls[0].centre_m - Eigen::Vector3d::Constant(0.5 / n)).norm() < 1e-12);
}

TEST_CASE("A spacing that gives too many balls, or none, is refused with their number",
          "[sampling]") {
  CHECK_THROWS_WITH(surface_balls(mesh::cube_mesh(), 0.001, 0.001),
                    Catch::Contains("about 6e+06 balls"));
  CHECK_THROWS_WITH(volume_balls(mesh::cube_mesh(), 0.01, 0.01),
                    Catch::Contains("about 1e+06 balls"));
  // The middle of the torus's box, the lattice's only point, lies in its hole.
  CHECK_THROWS_WITH(volume_balls(mesh::torus_mesh(1.0, 0.3, 24, 12), 5.0, 1.0),
                    Catch::Contains("0 balls"));
}

TEST_CASE("Balls under a surface touch it from inside, apart, and leave no gap", "[sampling]") {
  const mesh::TriangleMesh mesh = mesh::torus_mesh(1.0, 0.3, 60, 24);
  const mesh::MeshDistance distance(mesh);
  const double spacing_m = 0.15, radius_m = GENERATE(0.1, 0.5);

  const std::vector<Ball> balls = surface_balls(mesh, spacing_m, radius_m);

  std::vector<Eigen::Vector3d> touching_m;
  for (const Ball& ball : balls) {
    const double depth_m = -distance.signed_distance_m(ball.centre_m);
    CHECK(ball.radius_m == Approx(depth_m).margin(1e-5));
    CHECK(ball.radius_m < radius_m + 1e-12);
    CHECK(ball.radius_m < 0.3001);  // the tube
    touching_m.push_back(distance.closest(ball.centre_m).point_m);
  }
  for (const Eigen::Vector3d& place_m : sample_surface(mesh, 500).points_m) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& other_m : touching_m)
      nearest_m = std::min(nearest_m, (other_m - place_m).norm());
    CHECK(nearest_m < 1.5 * spacing_m);
  }
  // They cut the mesh by rounding alone, which must not be taken for a crevice that they fill.
  const Decomposition measured = with_error(MeshSolid(mesh), balls, 0.05 * spacing_m);
  CHECK(measured.mesh_to_union_m < spacing_m);
  CHECK(static_cast<double>(balls.size()) < 1.3 * 11.8 / (spacing_m * spacing_m));  // its area
}

}  // namespace
}  // namespace stillgrid::spheres::sampling_test
