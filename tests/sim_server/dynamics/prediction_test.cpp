// What a snapshot tells of the next step: docs/algorithms/predict.md.

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <random>

#include "shared/collision/sphere_history.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::prediction_test {
namespace {

constexpr double kStep_s = 0.01;
constexpr double kStiffness_N_per_m = 200.0;

const scene::Method kImplicit{.integrator = scene::IntegratorKind::kImplicitEuler,
                              .tolerance_m_s = 1e-12};

scene::SceneDescription touched_scene(
    std::vector<bodies::BodyDescription> bodies,
    const Eigen::Vector3d& gravity_m_s2 = Eigen::Vector3d::Zero()) {
  scene::SceneDescription scene = sim_server::scene_of(
      std::move(bodies), sim_server::material_of(kStiffness_N_per_m), gravity_m_s2);
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}};
  scene.method = kImplicit;
  return scene;
}

/// A step with the tool at x_m at its end, at that speed along x.
void step_with_tool(Simulation& simulation, double x_m, double speed_m_s = 0.0) {
  const auto now_ns = static_cast<std::uint64_t>((simulation.world().time_s + kStep_s) * 1e9);
  REQUIRE(simulation
              .step(kStep_s,
                    [&]() -> std::optional<ToolSample> {
                      return ToolSample{.time_ns = now_ns,
                                        .position_m = {x_m, 0, 0},
                                        .velocity_m_s = {speed_m_s, 0, 0}};
                    })
              .solve.converged);
}

Eigen::Vector3d vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data()).cast<double>();
}
const proto::SphereRecord& record(const Simulation& simulation, std::size_t sphere) {
  return simulation.snapshot().records()[sphere];
}
Eigen::Vector3d position_m(const Simulation& simulation, std::size_t sphere) {
  return bodies::sphere_motion(simulation.world(), simulation.world().spheres[sphere]).position_m;
}

TEST_CASE("A free body is predicted the end of its next step, and is not compliant without a tool",
          "[prediction]") {
  Simulation simulation(touched_scene({sim_server::sphere({0, 0, 1}, 0.01, 0.1)}, {0, 0, -9.81}));
  REQUIRE(simulation.step(kStep_s, [] { return std::nullopt; }).solve.converged);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);

  CHECK(prediction.period_ns == 10'000'000);
  CHECK(prediction.modes.empty());
  CHECK(record(simulation, 0).response == 0);
  CHECK(record(simulation, 0).predicted_velocity_m_s[2] ==
        Approx(-2.0 * 9.81 * kStep_s).epsilon(1e-6));
}

/// How far forces at spheres' centres move a sphere over a step, by what a snapshot tells.
Eigen::Matrix3d compliance_m_per_N(const Simulation& simulation,
                                   const publication::SnapshotPrediction& prediction,
                                   std::size_t moved, std::size_t pushed) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  const std::uint32_t a = record(simulation, moved).response,
                      b = record(simulation, pushed).response;
  if (a == 0 || b == 0) return sum;
  for (std::size_t mode = 0; mode < prediction.modes.size(); ++mode)
    sum += vector(prediction.responses[a - 1].modes[mode]) *
           vector(prediction.responses[b - 1].modes[mode]).transpose();
  return sum;
}

TEST_CASE("A free body gives way to a newton by P^2 over its mass, whichever way it is pushed",
          "[prediction]") {
  // The tool touches it, or is near.
  const double x_m = GENERATE(0.019, 0.0201);
  Simulation simulation(touched_scene({sim_server::sphere({x_m, 0, 0}, 0.01, 0.1)}));
  step_with_tool(simulation, 0.0);
  const double depth_m = std::max(0.0, 0.02 - position_m(simulation, 0).x());
  const double speed_m_s = simulation.world().rigid_bodies[0].velocity_m_s.x();
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);

  const double alone_m_per_N = kStep_s * kStep_s / 0.1;
  CHECK((compliance_m_per_N(simulation, prediction, 0, 0) -
         alone_m_per_N * Eigen::Matrix3d::Identity())
            .norm() < 1e-5 * alone_m_per_N);
  REQUIRE(prediction.modes.size() == 6);
  double push2_J = 0.0;
  for (const proto::ResponseMode& mode : prediction.modes) {
    CHECK(mode.inertia_share == Approx(1.0F).epsilon(1e-5));
    push2_J += double{mode.push} * double{mode.push};
  }
  const double force_N = kStiffness_N_per_m * depth_m;
  CHECK(std::sqrt(push2_J) ==
        Approx(force_N * std::sqrt(alone_m_per_N)).epsilon(1e-4).margin(1e-9));
  CHECK(record(simulation, 0).predicted_velocity_m_s[0] ==
        Approx(speed_m_s + kStep_s * force_N / 0.1).epsilon(1e-6).margin(1e-9));
  REQUIRE(prediction.turning.size() == 1);
}

TEST_CASE("What the tool may come to while a snapshot is shown gives way", "[prediction]") {
  const double speed_m_s = 1.0, farthest_m = proto::kPredictionPeriods * kStep_s * speed_m_s;
  const double gap_m = GENERATE(0.001, 0.01, 0.019, 0.03);
  Simulation simulation(touched_scene({sim_server::sphere({0.02 + gap_m, 0, 0}, 0.01, 0.1)}));
  step_with_tool(simulation, 0.0, speed_m_s);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  CHECK((record(simulation, 0).response != 0) == (gap_m < farthest_m));
  CHECK(prediction.modes.empty() == (gap_m > farthest_m));
  CHECK(vector(record(simulation, 0).predicted_velocity_m_s).isZero());
}

TEST_CASE("Where an impact is not predicted, all moves on at its velocity and gives way",
          "[prediction]") {
  // Light balls that fly at one another aslant, by a step in which they would pass one another.
  std::vector<bodies::BodyDescription> bodies = {sim_server::sphere({0.0199, 0, 0}, 0.01, 1e-3)};
  for (int i = 1; i < 8; ++i) {
    bodies.push_back(
        sim_server::sphere({0.0199 + 0.0201 * i, 0.004 * i, 0.003 * i * i}, 0.01, 1e-3));
    bodies.back().velocity_m_s = {-3.0 * i, 0.5, 0.0};
  }
  scene::SceneDescription scene = touched_scene(bodies);
  scene.materials.front().contact_stiffness_N_per_m = 1e5;
  Simulation simulation(scene);
  step_with_tool(simulation, 0.0);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Vector3d now_m_s = simulation.world().rigid_bodies[i].velocity_m_s;
    CHECK((vector(record(simulation, i).predicted_velocity_m_s) - now_m_s).norm() <
          1e-5 * now_m_s.norm());
  }
  CHECK(!prediction.modes.empty());
  CHECK(!prediction.responses.empty());
}

/// How far the next step leads from where predicted velocity and response say, for the forces that
/// it finds, as a share of how far it leads at all. Each sphere is 10 mm, as is the tool.
double prediction_error(Simulation& simulation, double& tool_was_m, double tool_x_m,
                        std::size_t sphere) {
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  const std::size_t spheres = simulation.world().spheres.size();
  std::vector<Eigen::Vector3d> before_m, led_m, before_N;
  const auto push_N = [&](std::size_t i, double x_m) -> Eigen::Vector3d {
    const Eigen::Vector3d line_m = position_m(simulation, i) - Eigen::Vector3d(x_m, 0, 0);
    const double radius_m = simulation.world().spheres[i].radius_m;
    return kStiffness_N_per_m * std::max(0.0, 0.01 + radius_m - line_m.norm()) *
           line_m.normalized();
  };
  std::vector<Eigen::Matrix3d> compliances;
  for (std::size_t i = 0; i < spheres; ++i) {
    before_m.push_back(position_m(simulation, i));
    led_m.push_back(before_m.back() +
                    kStep_s * vector(record(simulation, i).predicted_velocity_m_s));
    before_N.push_back(push_N(i, tool_was_m));
    compliances.push_back(compliance_m_per_N(simulation, prediction, sphere, i));
  }
  step_with_tool(simulation, tool_x_m);
  tool_was_m = tool_x_m;
  Eigen::Vector3d expected_m = led_m[sphere];
  for (std::size_t i = 0; i < spheres; ++i)
    expected_m += compliances[i] * (push_N(i, tool_x_m) - before_N[i]);
  const Eigen::Vector3d after_m = position_m(simulation, sphere);
  return (after_m - expected_m).norm() / (after_m - before_m[sphere]).norm();
}

TEST_CASE(
    "The next implicit step leads where predicted velocity and response say, whatever the tool "
    "does",
    "[prediction]") {
  SECTION("of a free body") {
    Simulation simulation(touched_scene({sim_server::sphere({0.019, 0, 0}, 0.01, 0.1)}));
    step_with_tool(simulation, 0.0);
    double tool_m = 0.0;
    for (const double tool_x_m : {0.0002, 0.001, 0.003, 0.0})
      CHECK(prediction_error(simulation, tool_m, tool_x_m, 0) < 1e-5);
  }
  SECTION("of a chain that is pinned at its end, within what bends it") {
    bodies::BodyDescription chain =
        sim_server::thread(10, {0.0115, 0, 0}, {0.2, 0, 0}, 0.01, 300.0, {9});
    Simulation simulation(touched_scene({chain}));
    step_with_tool(simulation, 0.0);
    double tool_m = 0.0;
    for (const double tool_x_m : {0.0001, 0.0003, 0.0002})
      CHECK(prediction_error(simulation, tool_m, tool_x_m, 0) < 2e-2);
  }
  SECTION("of a body with another behind it, which is pushed too") {
    Simulation simulation(touched_scene({sim_server::sphere({0.019, 0, 0}, 0.01, 0.1),
                                         sim_server::sphere({0.0385, 0, 0}, 0.01, 0.1)}));
    step_with_tool(simulation, 0.0);
    double tool_m = 0.0;
    for (const double tool_x_m : {0.0002, 0.0005})
      CHECK(prediction_error(simulation, tool_m, tool_x_m, 0) < 1e-2);
    const double alone_m_per_N = kStep_s * kStep_s / 0.1;
    const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
    CHECK(compliance_m_per_N(simulation, prediction, 0, 0)(0, 0) < 0.95 * alone_m_per_N);
    CHECK(compliance_m_per_N(simulation, prediction, 1, 0)(0, 0) > 0.01 * alone_m_per_N);
  }
}

TEST_CASE("However a tool is pinched, each body gives way to a newton as it does alone",
          "[prediction]") {
  const double alone_m_per_N = kStep_s * kStep_s / 0.1;
  const double ahead_m = GENERATE(1e-3, 1e-4, 1e-6, 1e-9, 0.0);  // deeper in one than in the other
  const double across_m = GENERATE(0.0, 1e-6, 2e-3);             // out of the line between them
  Simulation simulation(
      touched_scene({sim_server::sphere({0.019 - ahead_m, across_m, 0}, 0.01, 0.1),
                     sim_server::sphere({-0.019, across_m, 0}, 0.01, 0.1)}));
  step_with_tool(simulation, 0.0);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK((compliance_m_per_N(simulation, prediction, i, i) -
           alone_m_per_N * Eigen::Matrix3d::Identity())
              .norm() < 1e-5 * alone_m_per_N);
    CHECK(compliance_m_per_N(simulation, prediction, i, 1 - i).norm() < 1e-5 * alone_m_per_N);
  }
}

TEST_CASE("A tool between a free body and a prescribed one: only the free one gives way",
          "[prediction]") {
  bodies::BodyDescription piston = sim_server::sphere({-0.0185, 0, 0}, 0.01, 0.1);
  piston.motion = bodies::Motion::kPrescribed;
  Simulation pinched(touched_scene({sim_server::sphere({0.019, 0, 0}, 0.01, 0.1), piston}));
  Simulation alone(touched_scene({sim_server::sphere({0.019, 0, 0}, 0.01, 0.1)}));
  step_with_tool(pinched, 0.0);
  step_with_tool(alone, 0.0);
  const publication::SnapshotPrediction of_pinched = pinched.predict_next(kStep_s),
                                        of_alone = alone.predict_next(kStep_s);
  CHECK(of_pinched.modes.size() == of_alone.modes.size());
  CHECK((compliance_m_per_N(pinched, of_pinched, 0, 0) - compliance_m_per_N(alone, of_alone, 0, 0))
            .norm() < 1e-9);
  CHECK(record(pinched, 1).response == 0);
}

TEST_CASE("No response gives way more than an implicit step, and none is negative",
          "[prediction]") {
  // Over soft and rigid bodies pressed against one another and drawn apart.
  std::mt19937 random(GENERATE(range(1U, 9U)));
  std::uniform_real_distribution<double> any(0.0, 1.0);
  bodies::BodyDescription chain =
      sim_server::thread(7, {0.015 + 0.004 * any(random), 0, 0}, {0.1, 0.01, 0}, 0.01, 300.0, {6});
  Simulation simulation(
      touched_scene({chain, sim_server::sphere({-0.0185, 0.003 * any(random), 0}, 0.01, 0.05),
                     sim_server::sphere({-0.037, 0.0, 0.002 * any(random)}, 0.01, 0.2)}));
  step_with_tool(simulation, 0.0);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  REQUIRE(!prediction.modes.empty());
  const std::size_t spheres = simulation.world().spheres.size();
  Eigen::MatrixXd all(3 * spheres, 3 * spheres);
  for (std::size_t i = 0; i < spheres; ++i)
    for (std::size_t j = 0; j < spheres; ++j)
      all.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) =
          compliance_m_per_N(simulation, prediction, i, j);
  CHECK((all - all.transpose()).norm() < 1e-6 * all.norm());
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(all).eigenvalues();
  CHECK(values.minCoeff() > -1e-6 * values.maxCoeff());
  // The lightest that moves at all: a node of the chain.
  const double lightest_kg = 0.01;
  for (const proto::ResponseMode& mode : prediction.modes) {
    CHECK(mode.inertia_share >= 0.0F);
    CHECK(mode.inertia_share <= 1.0F);
  }
  for (std::size_t i = 0; i < spheres; ++i)
    CHECK(compliance_m_per_N(simulation, prediction, i, i)(0, 0) <=
          kStep_s * kStep_s / lightest_kg * (1.0 + 1e-5));
}

TEST_CASE("A prescribed body is predicted where it will be and is not compliant", "[prediction]") {
  bodies::BodyDescription shaker = sim_server::sphere({0.015, 0, 0}, 0.01, 0.1);
  shaker.motion = bodies::Motion::kPrescribed;
  shaker.prescribed.amplitude_m = 0.02;
  shaker.prescribed.frequency_hz = 3.0;
  Simulation simulation(touched_scene({shaker}));
  for (int i = 0; i < 7; ++i) step_with_tool(simulation, 0.0);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);
  const Eigen::Vector3d predicted_m =
      position_m(simulation, 0) + kStep_s * vector(record(simulation, 0).predicted_velocity_m_s);
  CHECK(prediction.modes.empty());
  step_with_tool(simulation, 0.0);
  CHECK((position_m(simulation, 0) - predicted_m).norm() < 1e-7);
}

TEST_CASE("Looking ahead leaves the world itself as it is", "[prediction]") {
  Simulation simulation(touched_scene({sim_server::sphere({0.019, 0, 0}, 0.01, 0.1),
                                       sim_server::sphere({0.0385, 0.001, 0}, 0.01, 0.1)}));
  for (int i = 0; i < 20; ++i) {
    step_with_tool(simulation, 1e-4 * i);
    const bodies::World before = simulation.world();
    static_cast<void>(simulation.predict_next(kStep_s));
    for (std::size_t k = 0; k < 2; ++k) {
      const bodies::RigidBody &was = before.rigid_bodies[k],
                              &is = simulation.world().rigid_bodies[k];
      CHECK(is.position_m == was.position_m);
      CHECK(is.velocity_m_s == was.velocity_m_s);
      CHECK(is.orientation.coeffs() == was.orientation.coeffs());
      CHECK(is.angular_velocity_rad_s == was.angular_velocity_rad_s);
    }
  }
}

TEST_CASE("Covers hold what moves on for two periods", "[prediction]") {
  Simulation simulation(touched_scene({sim_server::sphere({0.019, 0, 0}, 0.01, 0.001)}));
  step_with_tool(simulation, 0.0);
  static_cast<void>(simulation.predict_next(kStep_s));
  const auto& sphere = record(simulation, 0);
  const collision::SweptBound& swept_bound = simulation.snapshot().swept_bound(0);
  const Eigen::Vector3d far_m =
      vector(sphere.newest.position_m) +
      proto::kPredictionPeriods * kStep_s * vector(sphere.predicted_velocity_m_s);
  REQUIRE(vector(sphere.predicted_velocity_m_s).norm() * kStep_s > 0.001);
  CHECK((far_m - vector(swept_bound.centre_m)).norm() + 0.01 <=
        double{swept_bound.bounding_radius_m});
}

TEST_CASE("Covers hold the whole history after looking ahead, though the grid was entered anew",
          "[prediction]") {
  std::vector<bodies::BodyDescription> bodies{sim_server::floor_at(0.0)};
  for (int i = 0; i < 8; ++i)
    bodies.push_back(
        sim_server::moving(sim_server::sphere({0.05 * i, 0, 0.03 + 0.01 * i}, 0.01, 0.05),
                           {0.1 * (i - 4), 0.05 * i, 0}));
  Simulation simulation(touched_scene(std::move(bodies), {0, 0, -9.81}));
  int outside = 0;
  for (int step = 0; step < 80; ++step) {
    static_cast<void>(simulation.step(kStep_s, [] { return std::nullopt; }));
    static_cast<void>(simulation.predict_next(kStep_s));
    const collision::VoxelGrid& snapshot = simulation.snapshot();
    for (std::size_t i = 0; i < snapshot.records().size(); ++i)
      for (std::size_t age = 0; age < proto::kHistoryLength; ++age) {
        const auto& centre_m = snapshot.swept_bound(i).centre_m;
        const double far_m =
            (vector(collision::position_m(snapshot.records()[i], age)) - vector(centre_m)).norm();
        if (far_m + 0.01 > double{snapshot.swept_bound(i).bounding_radius_m}) ++outside;
      }
  }
  CHECK(outside == 0);
}

TEST_CASE("Of a large scene what is near the tool is predicted as it would be alone",
          "[prediction]") {
  // A pair that the tool presses, and behind it far more balls than are predicted.
  const std::vector<bodies::BodyDescription> near{sim_server::sphere({0.019, 0, 0}, 0.01, 0.1),
                                                  sim_server::sphere({0.0385, 0, 0}, 0.01, 0.1)};
  std::vector<bodies::BodyDescription> all{near[0]};
  for (int i = 0; i < 3000; ++i)
    all.push_back(sim_server::moving(
        sim_server::sphere({1.0 + 0.03 * (i % 50), 0.03 * (i / 50), 0}, 0.01, 0.1), {0, 0, 0.5}));
  all.push_back(near[1]);
  scene::SceneDescription near_scene = touched_scene(near), large_scene = touched_scene(all);
  if (GENERATE(false, true))  // with a sphere of the tool, the first, among those that are far
    for (scene::SceneDescription* scene : {&near_scene, &large_scene})
      scene->tool.insert(scene->tool.begin(), {{1.7, 0.9, 0.1}, 0.001});
  Simulation alone(near_scene), large(large_scene);
  publication::SnapshotPrediction of[2];
  for (Simulation* simulation : {&alone, &large}) {
    step_with_tool(*simulation, 0.0);
    of[simulation == &large] = simulation->predict_next(kStep_s);
  }

  REQUIRE(!of[0].modes.empty());
  CHECK(of[1].modes.size() == of[0].modes.size());
  const std::size_t places[2] = {0, 3001};
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      CHECK(record(large, places[i]).predicted_velocity_m_s[axis] ==
            Approx(record(alone, i).predicted_velocity_m_s[axis]).margin(1e-5));
    CHECK((compliance_m_per_N(large, of[1], places[i], 0) - compliance_m_per_N(alone, of[0], i, 0))
              .norm() < 1e-7);
  }
  CHECK(record(large, 3000).predicted_velocity_m_s[2] == Approx(0.5));
  const collision::SweptBound& bound = large.snapshot().swept_bound(3000);
  const Eigen::Vector3d far_m =
      vector(record(large, 3000).newest.position_m) +
      proto::kPredictionPeriods * kStep_s * Eigen::Vector3d(0.0, 0.0, 0.5);
  CHECK((far_m - vector(bound.centre_m)).norm() + 0.01 <= double{bound.bounding_radius_m});
}

TEST_CASE("Of a large scene a body that turns is told by its number in the scene", "[prediction]") {
  std::vector<bodies::BodyDescription> all;
  for (int i = 0; i < 1700; ++i)
    all.push_back(sim_server::sphere({1.0 + 0.03 * (i % 50), 0.03 * (i / 50), 0}, 0.01, 0.1));
  all.push_back(sim_server::sphere({0.0385, 0, 0}, 0.01, 0.1));
  all.push_back(sim_server::sphere({0.019, 0, 0}, 0.01, 0.1));
  Simulation simulation(touched_scene(all));
  step_with_tool(simulation, 0.0);

  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s);

  REQUIRE(prediction.turning.size() == 1);
  CHECK(prediction.turning[0].body == 1701);
}

TEST_CASE("Without time to look ahead a body moves on at its velocity and is not compliant",
          "[prediction]") {
  Simulation simulation(touched_scene({sim_server::sphere({0.019, 0, 0}, 0.01, 0.1)}));
  step_with_tool(simulation, 0.0);
  Budget late{.iterations = 1000};
  late.end_within(0);
  const publication::SnapshotPrediction prediction = simulation.predict_next(kStep_s, late);
  CHECK(prediction.period_ns == 0);
  CHECK(record(simulation, 0).predicted_velocity_m_s == record(simulation, 0).newest.velocity_m_s);
}

}  // namespace
}  // namespace stillgrid::dynamics::prediction_test
