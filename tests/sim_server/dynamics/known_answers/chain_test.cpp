#include <Eigen/Eigenvalues>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/sim_server/dynamics/spring_matrix.hpp"
#include "tests/sim_server/dynamics/stepping.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::chain_test {
namespace {

/// Eigenfrequencies at rest, ascending.
Eigen::VectorXd frequencies_rad_s(const bodies::BodyDescription& body) {
  const bodies::World world = scene::build_world(sim_server::scene_of({body}));
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(spring_matrix_per_s2(world),
                                                        Eigen::EigenvaluesOnly)
      .eigenvalues()
      .cwiseMax(0.0)
      .cwiseSqrt();
}

/// Frequencies above a thousandth of the highest: the others are zero but for rounding.
Eigen::VectorXd nonzero(const Eigen::VectorXd& frequencies) {
  const auto first = std::find_if(frequencies.begin(), frequencies.end(),
                                  [&](double w) { return w > 1e-3 * frequencies.maxCoeff(); });
  return frequencies.tail(frequencies.end() - first);
}

bodies::BodyDescription chain(int free_nodes, int pinned_ends) {
  const int nodes = free_nodes + pinned_ends;
  bodies::BodyDescription body =
      sim_server::thread(nodes, {0, 0, 0}, {0.1 * (nodes - 1), 0, 0}, 0.01, 1000.0);
  if (pinned_ends > 0) sim_server::springs(body).pinned_nodes = {0};
  if (pinned_ends > 1) sim_server::springs(body).pinned_nodes = {0, nodes - 1};
  return body;
}

TEST_CASE("A chain rings at 2 sqrt(k/m) sin(x)", "[known_answers]") {
  constexpr int kMasses = 10;
  const double pi = std::numbers::pi, scale_rad_s = 2.0 * std::sqrt(1000.0 / 0.01);
  const int pinned_ends = GENERATE(0, 1, 2);
  const int modes = pinned_ends == 0 ? kMasses - 1 : kMasses;  // a free chain may drift

  const Eigen::VectorXd frequencies = nonzero(frequencies_rad_s(chain(kMasses, pinned_ends)));

  REQUIRE(frequencies.size() == modes);
  for (int j = 1; j <= modes; ++j) {
    const double x = pinned_ends == 2   ? j * pi / (2.0 * (kMasses + 1))
                     : pinned_ends == 1 ? (2 * j - 1) * pi / (2.0 * (2 * kMasses + 1))
                                        : j * pi / (2.0 * kMasses);
    CHECK(frequencies[j - 1] == Approx(scale_rad_s * std::sin(x)).epsilon(1e-11));
  }
  const std::array<double, 3> highest_rad_s{624.6690, 625.3915, 626.0180};
  CHECK(std::abs(frequencies[modes - 1] - highest_rad_s[static_cast<std::size_t>(pinned_ends)]) <
        5e-5);
  if (pinned_ends == 1) CHECK(std::abs(frequencies[0] - 47.2635) < 5e-5);
  if (pinned_ends == 2) CHECK(std::abs(frequencies[0] - 90.0078) < 5e-5);
}

TEST_CASE("An 8x8 sheet rings at 980.7853 rad/s at most, with shear and bend at 1201.838",
          "[known_answers]") {
  bodies::BodyDescription body = sim_server::sheet({8, 8}, 0.02, 0.002, 500.0);
  CHECK(scene::build_world(sim_server::scene_of({body})).springs.size() == 112);
  const Eigen::VectorXd structural = frequencies_rad_s(body);
  CHECK(structural.maxCoeff() ==
        Approx(2.0 * std::sqrt(500.0 / 0.002) * std::sin(7.0 * std::numbers::pi / 16.0))
            .epsilon(1e-11));
  CHECK(std::abs(structural.maxCoeff() - 980.7853) < 5e-5);

  sim_server::shear_stiffness_N_per_m(body) = 250.0;
  sim_server::springs(body).bend_stiffness_N_per_m = 100.0;
  CHECK(scene::build_world(sim_server::scene_of({body})).springs.size() == 306);
  const Eigen::VectorXd full = frequencies_rad_s(body);

  CHECK(std::abs(full.maxCoeff() - 1201.838) < 5e-4);
  // Flat it resists neither bending out of its plane (64) nor moving within it (3).
  CHECK(full.size() - nonzero(full).size() == 67);
}

TEST_CASE("A hanging chain's link i stretches by (N - i + 1) m g / k", "[known_answers]") {
  constexpr int kMasses = 10;
  Simulation simulation(sim_server::scene_of(
      {sim_server::thread(kMasses + 1, {0, 0, 0}, {0, 0, -1.0}, 0.01, 100.0, {0})}, {},
      {0, 0, -9.81}));

  REQUIRE(advance(simulation, 10.0, 10));  // steps so long that little but statics is left

  const auto& nodes = simulation.world().nodes;
  for (int i = 1; i <= kMasses; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double elongation_m =
        (nodes[at].position_m - nodes[at - 1].position_m).norm() - 1.0 / kMasses;
    CHECK(elongation_m == Approx((kMasses - i + 1) * 0.01 * 9.81 / 100.0).epsilon(1e-9));
  }
  CHECK(-nodes.back().position_m.z() - 1.0 == Approx(0.053955).epsilon(1e-9));
}

constexpr int kLinks = 10;
constexpr double kLength_m = 1.2, kLinkWeight_N = 0.01 * 9.81;

/// Sag of an elastic chain of 1.2 m between supports 1 m apart: one unknown, the horizontal force.
double exact_sag_m(double stiffness_N_per_m) {
  const auto sum = [&](double horizontal_N, bool of_drop, int links) {
    double total_m = 0.0;
    for (int i = 0; i < links; ++i) {
      const double vertical_N = (0.5 * (kLinks - 1) - i) * kLinkWeight_N;
      const double tension_N = std::hypot(horizontal_N, vertical_N);
      total_m += (kLength_m / kLinks + tension_N / stiffness_N_per_m) *
                 (of_drop ? vertical_N : horizontal_N) / tension_N;
    }
    return total_m;
  };
  double low_N = 0.0, high_N = 100.0;
  for (int i = 0; i < 200; ++i) {
    const double middle_N = 0.5 * (low_N + high_N);
    (sum(middle_N, false, kLinks) > 1.0 ? high_N : low_N) = middle_N;
  }
  return sum(low_N, true, kLinks / 2);
}

double simulated_sag_m(double stiffness_N_per_m) {
  Simulation simulation(
      sim_server::scene_of({sim_server::thread(kLinks + 1, {-0.6, 0, 0}, {0.6, 0, 0}, 0.01,
                                               stiffness_N_per_m, {0, kLinks})},
                           {}, {0, 0, -9.81}));
  // Begin as a taut V between the supports.
  auto& nodes = simulation.world().nodes;
  for (bodies::Node& node : nodes) {
    node.position_m.z() = -std::sqrt(0.36 - 0.25) * (1.0 - std::abs(node.position_m.x()) / 0.6);
    node.position_m.x() *= 1.0 / kLength_m;
  }
  CHECK(advance(simulation, 0.05, 200));
  CHECK(advance(simulation, 1.0, 20));
  return -nodes[kLinks / 2].position_m.z();
}

TEST_CASE("An elastic chain of ten links of 200 N/m sags by 312.149 mm", "[known_answers]") {
  const double sag_m = simulated_sag_m(200.0);

  CHECK(sag_m == Approx(exact_sag_m(200.0)).epsilon(1e-8));
  CHECK(std::abs(sag_m - 0.312149) < 5e-7);
}

TEST_CASE("A stiff chain of ten links sags by 293.864 mm", "[known_answers]") {
  // What is left of the elasticity halves with the compliance: it is extrapolated away.
  const double stiff_m = simulated_sag_m(1e5), stiffer_m = simulated_sag_m(2e5);

  CHECK(stiff_m == Approx(exact_sag_m(1e5)).epsilon(1e-8));
  CHECK(std::abs(2.0 * stiffer_m - stiff_m - 0.293864) < 5e-7);
}

}  // namespace
}  // namespace stillgrid::dynamics::chain_test
