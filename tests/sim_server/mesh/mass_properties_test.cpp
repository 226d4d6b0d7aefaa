#include "sim_server/mesh/mass_properties.hpp"

#include <catch2/catch.hpp>
#include <numbers>

#include "tests/sim_server/mesh/solids.hpp"

namespace stillgrid::mesh::mass_properties_test {
namespace {

constexpr double kPi = std::numbers::pi;

TEST_CASE("A box has the volume, centre and inertia of a box", "[mass_properties]") {
  const MassProperties box = mass_properties(box_mesh({1, 2, 3}, {1.2, 2.5, 4.0}));

  CHECK(box.volume_m3 == Approx(0.2 * 0.5 * 1.0));
  CHECK((box.centre_m - Eigen::Vector3d(1.1, 2.25, 3.5)).norm() < 1e-12);
  const Eigen::Vector3d expected = Eigen::Vector3d(1.25, 1.04, 0.29) / 12.0;
  CHECK((box.inertia_per_kg_m2 - Eigen::Matrix3d(expected.asDiagonal())).norm() < 1e-12);
}

TEST_CASE("A fine ball and a fine torus have theirs", "[mass_properties]") {
  const MassProperties ball = mass_properties(ball_mesh(0.3, 400, 100));
  CHECK(ball.volume_m3 == Approx(4.0 / 3.0 * kPi * 0.027).epsilon(3e-4));
  CHECK(ball.inertia_per_kg_m2(2, 2) == Approx(0.4 * 0.09).epsilon(3e-4));

  const MassProperties torus = mass_properties(torus_mesh(1.0, 0.3, 400, 200));
  CHECK(torus.volume_m3 == Approx(2.0 * kPi * kPi * 0.09).epsilon(3e-4));
  CHECK(torus.inertia_per_kg_m2(2, 2) == Approx(1.0 + 0.75 * 0.09).epsilon(3e-4));
  CHECK(torus.inertia_per_kg_m2(0, 0) == Approx(0.5 + 0.625 * 0.09).epsilon(3e-4));
}

TEST_CASE("Mass properties move and turn with the solid, also far from the origin",
          "[mass_properties]") {
  const TriangleMesh mesh = box_mesh({0, 0, 0}, {0.1, 0.2, 0.3});
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Eigen::Vector3d by_m(500.0, -300.0, 200.0);
  const MassProperties still = mass_properties(mesh),
                       carried = mass_properties(moved(mesh, turn, by_m));

  CHECK(carried.volume_m3 == Approx(still.volume_m3));
  CHECK((carried.centre_m - (turn * still.centre_m + by_m)).norm() < 1e-9);
  CHECK((carried.inertia_per_kg_m2 - turn * still.inertia_per_kg_m2 * turn.transpose()).norm() <
        1e-9);
}

TEST_CASE("The area is that of the faces", "[mass_properties]") {
  CHECK(surface_area_m2(box_mesh({0, 0, 0}, {1, 2, 3})) == Approx(22.0));
}

}  // namespace
}  // namespace stillgrid::mesh::mass_properties_test
