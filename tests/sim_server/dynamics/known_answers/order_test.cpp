#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_server/dynamics/integrators/integrator.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::order_test {
namespace {

constexpr int kMasses = 10;

/// A chain of ten masses of 10 g and springs of 1000 N/m, one end pinned, along x.
bodies::World chain() {
  return scene::build_world(sim_server::scene_of(
      {sim_server::thread(kMasses + 1, {0, 0, 0}, {1, 0, 0}, 0.01, 1000.0, {0})}));
}

/// The largest error over half a second against the first mode, let go at rest.
double error_m(scene::IntegratorKind kind, double step_s) {
  bodies::World world = chain();
  const double x = std::numbers::pi / (2 * kMasses + 1);
  const double rate_rad_s = 2.0 * std::sqrt(1000.0 / 0.01) * std::sin(0.5 * x);
  const auto stretch_m = [&](int mass, double time_s) {
    return 1e-3 * std::sin(mass * x) * std::cos(rate_rad_s * time_s);
  };
  for (int i = 1; i <= kMasses; ++i)
    world.nodes[static_cast<std::size_t>(i)].position_m.x() += stretch_m(i, 0.0);
  const auto integrator = make_integrator({.integrator = kind, .tolerance_m_s = 1e-11});
  double worst_m = 0.0;
  for (int step = 1; step <= std::lround(0.5 / step_s); ++step) {
    Budget budget;
    REQUIRE(integrator->advance(world, {}, step_s, budget).converged);
    integrator->commit(world, step_s);
    for (int i = 1; i <= kMasses; ++i)
      worst_m = std::max(worst_m, std::abs(world.nodes[static_cast<std::size_t>(i)].position_m.x() -
                                           0.1 * i - stretch_m(i, step * step_s)));
  }
  return worst_m;
}

TEST_CASE("Implicit Euler's error falls as the step, the trapezoid's and BDF2's as its square",
          "[known_answers]") {
  struct Case {
    scene::IntegratorKind kind;
    double order, margin;
  };
  const Case known = GENERATE(Case{scene::IntegratorKind::kImplicitEuler, 1.0, 0.06},
                              Case{scene::IntegratorKind::kTrapezoid, 2.0, 0.01},
                              Case{scene::IntegratorKind::kBdf2, 2.0, 0.02});

  const double coarse_m = error_m(known.kind, 1e-4), fine_m = error_m(known.kind, 5e-5);

  CHECK(std::log2(coarse_m / fine_m) == Approx(known.order).margin(known.margin));
}

/// The largest root of an oscillator's motion from eight of its velocities (Prony's method: two
/// steps' memory of place and velocity make four roots).
double largest_root(scene::IntegratorKind kind, double wh) {
  bodies::World world = scene::build_world(
      sim_server::scene_of({sim_server::thread(2, {0, 0, 0}, {0.1, 0, 0}, 0.1, 1000.0, {0})}));
  world.nodes[1].velocity_m_s.x() = 0.1;
  const auto integrator = make_integrator({.integrator = kind, .tolerance_m_s = 1e-13});
  constexpr int kRoots = 4;
  Eigen::VectorXd speed_m_s(2 * kRoots);
  for (Eigen::Index i = -1; i < speed_m_s.size(); ++i) {  // the first step is another method's
    Budget budget;
    REQUIRE(integrator->advance(world, {}, wh / 100.0, budget).converged);
    integrator->commit(world, wh / 100.0);
    if (i >= 0) speed_m_s[i] = world.nodes[1].velocity_m_s.x();
  }
  const int roots = kind == scene::IntegratorKind::kBdf2 ? kRoots : 2;
  Eigen::MatrixXd past(roots, roots);
  for (int i = 0; i < roots; ++i) past.row(i) = speed_m_s.segment(i, roots).transpose();
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(roots, roots);
  companion.diagonal(1).setOnes();
  companion.row(roots - 1) = past.fullPivLu().solve(speed_m_s.segment(roots, roots)).transpose();
  return Eigen::EigenSolver<Eigen::MatrixXd>(companion).eigenvalues().cwiseAbs().maxCoeff();
}

TEST_CASE(
    "An oscillator shrinks by .933321 a BDF2 step of wh = 1 and .300750 of wh = 10, by none "
    "of the trapezoid's",
    "[known_answers]") {
  CHECK(std::abs(largest_root(scene::IntegratorKind::kBdf2, 1.0) - 0.933321) < 1e-6);
  CHECK(std::abs(largest_root(scene::IntegratorKind::kBdf2, 10.0) - 0.300750) < 1e-6);
  CHECK(std::abs(largest_root(scene::IntegratorKind::kTrapezoid, 1.0) - 1.0) < 1e-9);
  CHECK(std::abs(largest_root(scene::IntegratorKind::kTrapezoid, 10.0) - 1.0) < 1e-9);
}

}  // namespace
}  // namespace stillgrid::dynamics::order_test
