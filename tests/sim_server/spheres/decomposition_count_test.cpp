#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim_server/spheres/decomposition.hpp"
#include "tests/sim_server/mesh/solids.hpp"
#include "tests/sim_server/spheres/decomposition_checks.hpp"

namespace stillgrid::spheres::decomposition_count_test {
namespace {

/// How steeply the error falls with the count, both logarithmic.
double slope(double coarse_error_m, double coarse_count, double fine_error_m, double fine_count) {
  return std::log(fine_error_m / coarse_error_m) / std::log(fine_count / coarse_count);
}

/// The error of evenly spaced balls inside a torus of radii 1 and 0.3.
double ring_error_m(int count) {
  const double outer_m = 1.3, half_turn = std::numbers::pi / count;
  return std::sqrt(outer_m * outer_m + 1.0 - 2.0 * outer_m * std::cos(half_turn)) - 0.3;
}

TEST_CASE(
    "A torus takes no more spheres than evenly spaced ones inside it would, and twice "
    "the spheres are four times nearer",
    "[decomposition]") {
  const mesh::TriangleMesh mesh = mesh::torus_mesh(1.0, 0.3, 48, 16);
  const double tolerances_m[] = {0.08, 0.02};
  Decomposition results[2];
  for (std::size_t i = 0; i < 2; ++i) {
    results[i] = decompose(mesh, tolerances_m[i]);
    check_decomposition(mesh, results[i], tolerances_m[i]);
    int least = 3;
    while (ring_error_m(least) > tolerances_m[i]) ++least;
    CHECK(results[i].balls.size() <= static_cast<std::size_t>(least));
  }
  const double fell = slope(results[0].hausdorff_m, static_cast<double>(results[0].balls.size()),
                            results[1].hausdorff_m, static_cast<double>(results[1].balls.size()));
  CHECK(fell == Approx(-2.0).margin(0.4));
}

TEST_CASE(
    "A rod takes no more spheres than a row inside it would, and with half the gaps between "
    "them they are four times nearer",
    "[decomposition]") {
  const double length_m = 1.0, radius_m = 0.2;
  const mesh::TriangleMesh mesh = mesh::capsule_mesh(length_m, radius_m, 36, 8);
  const double tolerances_m[] = {0.02, 0.005};
  Decomposition results[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const double e_m = tolerances_m[i];
    results[i] = decompose(mesh, e_m);
    check_decomposition(mesh, results[i], e_m);
    const double widest_m =
        2.0 * std::sqrt((radius_m + e_m) * (radius_m + e_m) - radius_m * radius_m);
    CHECK(static_cast<double>(results[i].balls.size()) <= std::ceil(length_m / widest_m) + 1.0);
  }
  const double fell =
      slope(results[0].hausdorff_m, static_cast<double>(results[0].balls.size() - 1),
            results[1].hausdorff_m, static_cast<double>(results[1].balls.size() - 1));
  CHECK(fell == Approx(-2.0).margin(0.5));
}

TEST_CASE("A slab's spheres are twice as near when they are twice as many", "[decomposition]") {
  // A disc with a round rim: nothing but a slab's middle plane lies deepest.
  const double half_m = 0.2;
  std::vector<Eigen::Vector2d> profile_m;
  for (int i = 0; i <= 8; ++i) {
    const double angle = std::numbers::pi * (i / 8.0 - 0.5);
    profile_m.push_back({1.0 + half_m * std::cos(angle), half_m * std::sin(angle)});
  }
  const mesh::TriangleMesh mesh = mesh::turned_mesh(profile_m, 30, -half_m, half_m);
  const Decomposition coarse = decompose(mesh, 0.1), fine = decompose(mesh, 0.05);
  CHECK(slope(coarse.hausdorff_m, static_cast<double>(coarse.balls.size()), fine.hausdorff_m,
              static_cast<double>(fine.balls.size())) == Approx(-1.0).margin(0.35));
}

}  // namespace
}  // namespace stillgrid::spheres::decomposition_count_test
