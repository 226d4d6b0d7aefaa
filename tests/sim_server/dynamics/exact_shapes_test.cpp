// Bodies of exact shapes hold each other, and hold spheres.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/sim_server/dynamics/field_bodies.hpp"

namespace stillgrid::dynamics::exact_shapes_test {
namespace {

using Eigen::Vector3d;
using Kind = bodies::SolidShape::Kind;
using sim_server::exact_box;

constexpr double kStiffness_N_per_m = 2000.0;

bodies::BodyDescription still(bodies::BodyDescription body) {
  body.motion = bodies::Motion::kStatic;
  return body;
}

/// Both defaults of a scene: explicit at 1 kHz, implicit at 100 Hz.
Way default_way() {
  return GENERATE(Way{scene::IntegratorKind::kVelocityVerlet, 0.001},
                  Way{scene::IntegratorKind::kImplicitEuler, 0.01});
}

Simulation simulation_of(const Way& way, std::vector<bodies::BodyDescription> bodies) {
  return Simulation(
      scene_by(way, std::move(bodies), sim_server::material_of(kStiffness_N_per_m, 3.0, 0.5)));
}

bool run(Simulation& simulation, const Way& way, double time_s) {
  return advance(simulation, way.step_s, static_cast<int>(time_s / way.step_s));
}

}  // namespace

TEST_CASE("A ball does not fall through a box wherever it is dropped", "[exact_shapes]") {
  const Way way = default_way();
  const Vector3d size_m(0.1, 0.06, 0.02);
  std::mt19937 engine(GENERATE(1U, 2U, 3U));
  std::uniform_real_distribution<double> draw(-0.46, 0.46);
  std::vector<bodies::BodyDescription> bodies{still(exact_box({0, 0, 0}, size_m, 0.0))};
  for (int i = 0; i < 12; ++i) {
    const double x_m = draw(engine) * size_m.x(), y_m = draw(engine) * size_m.y();
    bodies.push_back(sim_server::sphere({x_m, y_m, 0.02 + 0.012 * i}, 0.005, 0.02));
  }
  Simulation simulation = simulation_of(way, bodies);
  for (int i = 0; i < 100; ++i) {
    REQUIRE(run(simulation, way, 0.01));
    for (std::size_t k = 0; k < 12; ++k) {
      const Vector3d at_m = body(simulation, k).position_m;
      CAPTURE(k, at_m.transpose());
      REQUIRE_FALSE((at_m.cwiseAbs().array() < 0.5 * size_m.array()).all());
    }
  }
}

TEST_CASE("A stack of five boxes stands for ten seconds", "[exact_shapes]") {
  const Way way = default_way();
  const double side_m = 0.04;
  std::vector<bodies::BodyDescription> bodies{sim_server::floor_at(0.0)};
  for (int i = 0; i < 5; ++i)
    bodies.push_back(exact_box({0.0007 * (i % 3 - 1), 0.0005 * (i % 2), side_m * (i + 0.5)},
                               Vector3d::Constant(side_m), 0.05));
  Simulation simulation = simulation_of(way, bodies);
  REQUIRE(run(simulation, way, 1.0));
  std::vector<Vector3d> at_m;
  for (std::size_t i = 0; i < 5; ++i) at_m.push_back(body(simulation, i).position_m);
  REQUIRE(run(simulation, way, 9.0));
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK((body(simulation, i).position_m - at_m[i]).norm() < 2e-4);
    CHECK(at_m[i].z() == Approx(side_m * (static_cast<double>(i) + 0.5)).margin(0.002));
  }
  CHECK(fastest_m_s(simulation) < 1e-3);
}

TEST_CASE("A small box rests on a large one and a large one on a small one", "[exact_shapes]") {
  const Way way = default_way();
  const Vector3d small_m(0.02, 0.02, 0.02), large_m(0.12, 0.12, 0.02);
  const bool is_large_above = GENERATE(false, true);
  const Vector3d& above_m = is_large_above ? large_m : small_m;
  Simulation simulation =
      simulation_of(way, {still(exact_box({0, 0, 0}, is_large_above ? small_m : large_m, 0.0)),
                          exact_box({0.001, 0.002, 0.021}, above_m, 0.05)});
  REQUIRE(run(simulation, way, 3.0));
  CHECK(body(simulation).position_m.z() == Approx(0.02).margin(3e-4));
  CHECK(body(simulation).orientation.angularDistance(Eigen::Quaterniond::Identity()) < 0.02);
  CHECK(fastest_m_s(simulation) < 1e-3);
}

TEST_CASE("Two beams that cross bear each other wherever they cross", "[exact_shapes]") {
  const Way way = default_way();
  const double x_m = GENERATE(-0.013, 0.0021, 0.0077, 0.0119), turn_rad = GENERATE(0.7, 1.5708);
  auto lower = still(exact_box({0, 0, 0}, {0.1, 0.01, 0.01}, 0.0));
  auto upper = exact_box({x_m, 0.0, 0.0101}, {0.1, 0.01, 0.01}, 0.03);
  upper.orientation = Eigen::AngleAxisd(turn_rad, Vector3d::UnitZ());
  Simulation simulation = simulation_of(way, {lower, upper});
  REQUIRE(run(simulation, way, 1.0));
  CHECK(body(simulation).position_m.z() == Approx(0.01).margin(0.001));
}

TEST_CASE("Capsules and cylinders rest on a box and on a plane", "[exact_shapes]") {
  const Way way = default_way();
  const auto kind = GENERATE(Kind::kCapsule, Kind::kCylinder);
  const bool lies = GENERATE(true, false), is_plane = GENERATE(true, false);
  if (kind == Kind::kCapsule && !lies) return;  // it would fall over
  auto upper = sim_server::compound({0, 0, lies ? 0.0105 : 0.0305},
                                    {sim_server::solid(kind, {0.02, 0.02, 0.06})}, 0.05);
  if (lies) upper.orientation = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX());
  const auto ground =
      is_plane ? sim_server::floor_at(0.0) : still(exact_box({0, 0, -0.01}, {0.2, 0.2, 0.02}, 0.0));
  Simulation simulation = simulation_of(way, {upper, ground});
  REQUIRE(run(simulation, way, 3.0));
  CHECK(body(simulation).position_m.z() == Approx(lies ? 0.01 : 0.03).margin(3e-4));
}

}  // namespace stillgrid::dynamics::exact_shapes_test
