// Contacts with distance fields: docs/algorithms/distance_fields.md.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "tests/sanitizer_cut.hpp"
#include "tests/shared/dynamics/field_scenes.hpp"
#include "tests/shared/dynamics/implicit_scenes.hpp"
#include "tests/sim_server/every_target.hpp"

namespace stillgrid::dynamics::field_contact_test {
namespace {

constexpr double kGravity_m_s2 = 9.81;
const Eigen::Vector3d kBox_m(0.061, 0.047, 0.033);

/// Ticks with all driven bodies where they are at the start.
void run(Engine& engine, double duration_s) {
  std::vector<DrivenPose> poses;
  const SceneState& state = engine.state();
  for (std::size_t r = 0; r < state.rigid_position_m.size(); ++r)
    if (engine.description().rigid_bodies[r].is_driven)
      poses.push_back({.position_m = state.rigid_position_m[r].vector(),
                       .orientation = state.orientation[r].quaternion()});
  for (int k = 0; k < std::lround(duration_s / kTick_s); ++k) engine.step(poses);
}
Eigen::Vector3d position_of(const Engine& engine, int rigid) {
  return engine.state().rigid_position_m[static_cast<std::size_t>(rigid)].vector();
}
Eigen::Vector3d velocity_of(const Engine& engine, int rigid) {
  return engine.state().rigid_velocity_m_s[static_cast<std::size_t>(rigid)].vector();
}

TEST_CASE("A ball at rest on a field is as deep as its weight over the stiffness there",
          "[dynamics][field]") {
  const double map = GENERATE(1.0, 2.5);
  const EngineMethod method = each_method();
  EngineScene scene;
  scene.with_gravity();
  collision::ScalarField stiffness;
  if (map != 1.0) stiffness = [map](const Eigen::Vector3d&) { return map; };
  add_static_field(scene, box_field(kBox_m, stiffness), Eigen::Vector3d::Zero());
  const double radius_m = 0.0087, top_m = 0.5 * kBox_m.z();
  const int ball = scene.add_ball(radius_m, {0.003, 0.001, top_m + radius_m + 0.001});
  Engine engine = scene.engine(method);

  run(engine, 3.0);

  const double weight_N = scene.description.rigid_bodies.back().mass_kg * kGravity_m_s2;
  const double pair_N_per_m =
      map * collision::pair_material(scene.description.materials[0], scene.description.materials[0])
                .stiffness_N_per_m;
  const double depth_m = top_m + radius_m - position_of(engine, ball).z();
  CHECK(depth_m == Approx(weight_N / pair_N_per_m).epsilon(3e-4));
  CHECK(velocity_of(engine, ball).norm() < 1e-6);
  CHECK(engine.contact_energy_J() ==
        Approx(0.5 * weight_N * weight_N / pair_N_per_m).epsilon(1e-3));
}

TEST_CASE("A ball rolls over the field of a ball as over a sphere", "[dynamics][field]") {
  const EngineMethod method = each_method();
  const auto rolled = [&](bool by_field) {
    EngineScene scene;
    scene.with_gravity();
    const double round_m = 0.03, radius_m = 0.008;
    if (by_field) {
      add_static_field(scene, ball_field(round_m), {0.0, 0.0, 0.0});
    } else {
      const int rigid = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), {0.0, 0.0, 0.0}, true);
      scene.add_sphere(rigid, round_m);
    }
    const int ball = scene.add_ball(radius_m, {0.004, 0.001, 0.0375});
    Engine engine = scene.engine(method);
    run(engine, 0.25);
    std::vector<Eigen::Vector3d> motion{position_of(engine, ball), velocity_of(engine, ball)};
    motion.push_back(
        engine.state().angular_velocity_rad_s[static_cast<std::size_t>(ball)].vector());
    return motion;
  };
  const auto on_field = rolled(true), on_sphere = rolled(false);
  REQUIRE(on_sphere[1].norm() > 0.03);
  REQUIRE(on_sphere[2].norm() > 2.0);
  INFO(on_sphere[0].transpose() << " field " << on_field[0].transpose());
  CHECK((on_field[0] - on_sphere[0]).norm() < 2e-5);
  CHECK((on_field[1] - on_sphere[1]).norm() < 0.005 * on_sphere[1].norm());
  CHECK((on_field[2] - on_sphere[2]).norm() < 0.005 * on_sphere[2].norm());
}

struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double kinetic_J = 0.0;
};
Momenta momenta_of(const Engine& engine) {
  Momenta sum;
  const SceneState& state = engine.state();
  for (std::size_t r = 0; r < state.rigid_position_m.size(); ++r) {
    const Description::Rigid& body = engine.description().rigid_bodies[r];
    const Eigen::Vector3d v = state.rigid_velocity_m_s[r].vector();
    const Eigen::Vector3d w = state.angular_velocity_rad_s[r].vector();
    const Eigen::Matrix3d axes = state.orientation[r].quaternion().toRotationMatrix();
    const Eigen::Vector3d spin = axes * body.inertia_kg_m2.asDiagonal() * axes.transpose() * w;
    sum.linear += body.mass_kg * v;
    sum.angular += body.mass_kg * state.rigid_position_m[r].vector().cross(v) + spin;
    sum.kinetic_J += 0.5 * body.mass_kg * v.squaredNorm() + 0.5 * w.dot(spin);
  }
  return sum;
}

/// A box and a ball with fields that fly at each other, as drawn.
EngineScene flight(unsigned seed, const collision::ContactMaterial& material) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return Eigen::Vector3d(unit(random), unit(random), unit(random)); };
  EngineScene scene;
  scene.description.materials = {material};
  static const SharedField box = box_field(kBox_m), ball = ball_field(0.0232);
  add_field_box(scene, kBox_m, 0.137, 0.004 * vector(), box);
  scene.state.orientation[0] =
      Vector4(Eigen::Quaterniond(1.0, unit(random), unit(random), unit(random)).normalized());
  add_field_ball(scene, 0.0232, Eigen::Vector3d(0.085, 0.0, 0.0) + 0.006 * vector(), ball);
  scene.state.rigid_velocity_m_s[0] = Vector4(Eigen::Vector3d(0.02 * vector()));
  scene.state.angular_velocity_rad_s[0] = Vector4(Eigen::Vector3d(3.0 * vector()));
  scene.state.rigid_velocity_m_s[1] =
      Vector4(Eigen::Vector3d(Eigen::Vector3d(-0.41, 0.0, 0.0) + 0.05 * vector()));
  scene.state.angular_velocity_rad_s[1] = Vector4(Eigen::Vector3d(5.0 * vector()));
  return scene;
}

TEST_CASE("Two bodies with fields collide by their surface points and keep their momenta",
          "[dynamics][field]") {
  const auto seed = GENERATE(range(1U, tests::seeds_end(9)));
  const EngineMethod method = each_method();
  Engine engine = flight(seed, {870.0, 0.7, 0.35}).engine(method);
  const Momenta start = momenta_of(engine);
  int most = 0;
  for (int k = 0; k < 350; ++k) {
    engine.step();
    most = std::max(most, engine.touching());
  }
  const Momenta end = momenta_of(engine);
  REQUIRE(most > 0);
  CHECK((end.linear - start.linear).norm() < 1e-6 * start.linear.norm());
  // Implicit steps have levers of their middle.
  const double lost = method.make == nullptr ? 1e-3 : 0.02;
  CHECK((end.angular - start.angular).norm() < lost * start.angular.norm());
  CHECK(end.kinetic_J < start.kinetic_J);
}

TEST_CASE("A collision of fields makes no energy", "[dynamics][field]") {
  const auto seed = GENERATE(range(1U, tests::seeds_end(9)));
  const double friction = GENERATE(0.0, 0.35);
  const EngineMethod method = each_method();
  Engine engine = flight(seed, {870.0, 0.0, friction}).engine(method);
  const double start_J = momenta_of(engine).kinetic_J;
  int most = 0;
  for (int k = 0; k < 350; ++k) {
    engine.step();
    most = std::max(most, engine.touching());
  }
  REQUIRE(most > 0);
  REQUIRE(engine.contact_energy_J() == 0.0);
  CHECK(momenta_of(engine).kinetic_J < 1.01 * start_J);
  if (friction == 0.0 && method.make == nullptr)
    CHECK(momenta_of(engine).kinetic_J > 0.95 * start_J);
}

TEST_CASE("A box with a field lies on another, held by friction, without creep",
          "[dynamics][field]") {
  EngineScene scene;
  scene.with_gravity();
  scene.description.gravity_m_s2 = {kGravity_m_s2 * std::sin(0.2), 0.0,
                                    -kGravity_m_s2 * std::cos(0.2)};
  scene.description.materials = {{2100.0, 2.0, 0.6}};
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  const SharedField box = box_field(kBox_m);
  add_field_box(scene, kBox_m, 0.137, {0.0, 0.0, 0.5 * kBox_m.z()}, box);
  add_field_box(scene, kBox_m, 0.137, {0.0043, -0.0029, 1.5 * kBox_m.z()}, box);
  Engine engine = scene.engine(each_method());
  run(engine, 2.0);
  const Eigen::Vector3d rested_m = position_of(engine, 1);
  REQUIRE(rested_m.z() > 1.4 * kBox_m.z());
  run(engine, 3.0 / tests::kCut);
  CHECK((position_of(engine, 1) - rested_m).norm() < 2e-7);
}

TEST_CASE("A soft sphere and a tool are held up by a field", "[dynamics][field]") {
  EngineScene scene;
  scene.with_gravity();
  const double top_m = 0.5 * kBox_m.z();
  add_static_field(scene, box_field(kBox_m), Eigen::Vector3d::Zero());
  const int node = scene.add_node(0.01, {0.002, 0.003, top_m + 0.0065});
  scene.cover({node}, 0.006, 7);
  Engine engine = scene.engine();
  run(engine, 3.0);
  const double depth_m = top_m + 0.006 - engine.state().node_position_m[0].z;
  const double k_N_per_m =
      collision::pair_material(scene.description.materials[0], scene.description.materials[0])
          .stiffness_N_per_m;
  CHECK(depth_m == Approx(0.01 * kGravity_m_s2 / k_N_per_m).epsilon(3e-4));
}

TEST_CASE("A tool that presses a free body with a field feels the body's weight",
          "[dynamics][field]") {
  EngineScene scene;
  scene.with_gravity();
  scene.description.materials = {{2100.0, 2.0, 0.6}};
  add_field_box(scene, kBox_m, 0.137, {0.0, 0.0, 0.5 * kBox_m.z() + 0.0075}, box_field(kBox_m));
  // Three spheres of a tool carry the box.
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true);
  for (const double turn_rad : {0.3, 2.4, 4.5}) {
    scene.add_sphere(tool, 0.008, {0.015 * std::cos(turn_rad), 0.015 * std::sin(turn_rad), 0.0});
    scene.description.spheres.back().is_tool = true;
  }
  Engine engine = scene.engine(each_method());
  run(engine, 2.0);
  const Eigen::Vector3d force_N = engine.reactions().front().impulse_N_s / kTick_s;
  CHECK(force_N.z() == Approx(-0.137 * kGravity_m_s2).epsilon(1e-3));
}

TEST_CASE("A fast ball does not pass through a plate that is a field", "[dynamics][field]") {
  const auto seed = GENERATE(range(1U, tests::seeds_end(13)));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Eigen::Vector3d plate_m(0.11, 0.09, 0.006);
  static const SharedField plate = box_field(plate_m);
  EngineScene scene;
  scene.description.materials = {{41000.0, 0.0, 0.0}};
  add_static_field(scene, plate, Eigen::Vector3d::Zero());
  const int ball = scene.add_ball(
      0.0043, {0.01 * unit(random), 0.01 * unit(random), 0.03 + 0.005 * unit(random)});
  scene.state.rigid_velocity_m_s[static_cast<std::size_t>(ball)] = {0.2 * unit(random), 0.0,
                                                                    -3.0 - 2.0 * unit(random)};
  Engine engine = scene.engine(each_method());
  run(engine, 0.1);
  CHECK(position_of(engine, ball).z() > 0.0);
}

/// Boxes, balls with and without fields, a thread and a static field, all drawn, close together.
EngineScene crowd(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto place = [&] {
    return Eigen::Vector3d(0.04 * unit(random), 0.04 * unit(random), 0.05 + 0.04 * unit(random));
  };
  static const SharedField box = box_field(
      {0.03, 0.024, 0.02}, [](const Eigen::Vector3d& x) { return 1.0 + 20.0 * std::abs(x.x()); });
  static const SharedField ball = ball_field(0.012), ground = box_field({0.2, 0.2, 0.02});
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d(0.6, 0.0, 0.8), -0.02);
  add_static_field(scene, ground, {0.0, 0.0, -0.01});
  for (int k = 0; k < 4; ++k) scene.add_ball(0.008 + 0.003 * unit(random), place());
  for (int k = 0; k < 3; ++k) {
    const int rigid = add_field_box(scene, {0.03, 0.024, 0.02}, 0.02, place(), box);
    scene.state.angular_velocity_rad_s[static_cast<std::size_t>(rigid)] = {
        9.0 * unit(random), 9.0 * unit(random), 9.0 * unit(random)};
  }
  add_field_ball(scene, 0.012, place(), ball, 40);
  const Eigen::Vector3d from_m = place();
  for (int k = 0; k < 6; ++k) {
    const int node = scene.add_node(0.003, from_m + k * Eigen::Vector3d(0.014, 0.004, 0.0));
    if (k > 0) scene.add_spring(node - 1, node, 300.0, 0.1);
    scene.cover({node}, 0.006, 100);
  }
  return scene;
}
std::vector<std::byte> block_of(const Engine& engine) {
  std::vector<std::byte> block;
  engine.save(block);
  return block;
}

TEST_CASE("A run through a saved block is equal to the bit, with fields", "[dynamics][field]") {
  std::size_t in_contact = 0;
  for (unsigned seed = 0; seed < 60 / tests::kCut; ++seed) {
    const EngineScene scene = crowd(seed);
    Engine whole = scene.engine(), first = scene.engine(), second = scene.engine();
    const double half_s = 0.04 + 0.003 * seed;
    run(whole, 2.0 * half_s);
    run(first, half_s);
    if (seed % 2 == 0) run(second, 0.007);  // it has been somewhere else before
    second.load(block_of(first));
    for (const FieldLane& lane : first.listing().field_lanes())
      if (first.listing().rows().rows[lane.row].push_impulse_N_s[lane.lane] > 0.0F) ++in_contact;
    run(second, half_s);
    INFO("seed " << seed);
    const bool are_equal = block_of(second) == block_of(whole);
    REQUIRE(are_equal);
  }
  CHECK(in_contact > 200 / tests::kCut);  // else little was tried
}

TEST_CASE("Every instruction set computes the same bytes, with fields", "[dynamics][field]") {
  for (unsigned seed = 0; seed < (tests::kIsSanitized ? 1 : 6); ++seed) {
    std::vector<std::byte> before;
    sim_server::on_every_target([&] {
      Engine engine = crowd(seed).engine();
      run(engine, 0.2);
      std::vector<std::byte> block = block_of(engine);
      INFO("seed " << seed);
      const bool are_equal = before.empty() || block == before;
      REQUIRE(are_equal);
      before = std::move(block);
    });
  }
}

TEST_CASE("A block with any byte changed is refused or loaded, with fields", "[dynamics][field]") {
  Engine engine = crowd(3).engine();
  run(engine, 0.1);
  const std::vector<std::byte> block = block_of(engine);
  for (std::size_t k = 0; k < block.size(); k += 17 * tests::kCut) {
    std::vector<std::byte> hostile = block;
    hostile[k] ^= std::byte{0xFF};
    try {
      engine.load(hostile);
      run(engine, 0.002);
    } catch (const std::invalid_argument&) {
    }
  }
  engine.load(block);
  const bool are_equal = block_of(engine) == block;
  CHECK(are_equal);
}

}  // namespace
}  // namespace stillgrid::dynamics::field_contact_test
