// A model survives its bytes to the bit, and bytes that are none are refused.
#include "shared/dynamics/scene_model.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>

#include "tests/shared/dynamics/drawn_scene.hpp"
#include "tests/shared/dynamics/field_scenes.hpp"

namespace stillgrid::dynamics::scene_model_test {
namespace {

SceneModel model_of(const EngineScene& scene) {
  SceneModel model;
  model.description = scene.description;
  model.start = scene.state;
  model.start.is_here.assign(scene.description.rigid_bodies.size(), 1);
  return model;
}
/// Balls, blocks, threads, planes and a tool.
SceneModel drawn(std::uint64_t seed) {
  SceneModel model = model_of(DrawnScene(seed).scene);
  model.hands = 1;
  model.start.is_here.back() = 0;
  model.description.bodies.push_back({.rigid = 0, .rest_speed_m_s = 1e-3});
  return model;
}
/// Joints of all kinds, a prescribed body, static spheres and bodies that never collide.
SceneModel joined(bool is_implicit) {
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitZ(), -0.05);
  scene.description.planes[0].body = 7;
  const int block = scene.add_block(0.1, {0.05, 0.04, 0.03}, {0, 0, 0.05});
  const int ball = scene.add_ball(0.02, {0.1, 0, 0.05});
  const int a = scene.add_node(0.01, {0, 0, 0.2}), b = scene.add_node(0.02, {0, 0.05, 0.2});
  const int moved = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), {0.1, 0.0, 0.1}, true);
  scene.add_sphere(moved, 0.02);
  const int still = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true);
  scene.description.rigid_bodies.back().is_fixture = true;
  scene.add_sphere(still, 0.03, {0.0, 0.0, -0.02});
  const auto node = [](int index) { return Description::JointEnd{.node = index}; };
  const auto point = [](int rigid) {
    return Description::JointEnd{.rigid = rigid, .point_m = {0.01, 0.02, 0.0}};
  };
  scene.description.joints = {{node(a), node(b), 0.05, 300.0, 0.1},
                              {node(a), point(block), 0.0, 200.0, 0.2},
                              {point(ball), point(block), 0.0, 100.0, 0.0},
                              {point(moved), node(b), 0.0, 50.0, 0.5},
                              {point(block), {.point_m = {0, 0, 0.3}}, 0.0, 80.0, 0.3}};
  scene.description.materials.push_back({2000.0, 1.0, 0.1, 2e-3});
  scene.description.spheres.back().material = 1;
  scene.description.apart = {{-1, ball}, {block, ball}, {ball, 7}};
  SceneModel model = model_of(scene);
  model.prescribed = {
      {.start_m = {0.1, 0.0, 0.1},
       .velocity_m_s = {-0.1, 0.0, 0.0},
       .direction = Eigen::Vector3d::UnitZ(),
       .amplitude_m = 0.01,
       .frequency_hz = 5.0,
       .keyframes = std::make_shared<const PrescribedMotion::Keyframes>(
           PrescribedMotion::Keyframes{{0.05, {0, 0, 0.01}}, {0.3, {0.02, 0, 0}}})}};
  model.has_static_body = true;
  model.is_implicit = is_implicit;
  model.tolerance_m_s = 1e-9;
  return model;
}
/// Balls at rest far from each other, which sleep after half a second.
SceneModel resting() {
  EngineScene scene;
  for (int k = 0; k < 3; ++k) {
    const int ball = scene.add_ball(0.01, {0.1 * k, 0, 0});
    scene.description.bodies.push_back(
        {.rigid = ball, .rest_speed_m_s = 1e-3, .bounding_radius_m = 0.01});
  }
  SceneModel model = model_of(scene);
  model.start.tick = 5;
  model.start.contacts = {3.0, 4.0};
  return model;
}
std::vector<SceneModel> models() {
  return {drawn(3), drawn(4), joined(false), joined(true), resting()};
}

/// Poses of all driven bodies at the end of a tick. The tool of drawn(3) is away in some.
std::vector<DrivenPose> poses_at(const SceneModel& model, std::uint64_t tick) {
  static const DrawnScene path(3);
  std::vector<DrivenPose> poses;
  for (const PrescribedMotion& motion : model.prescribed)
    poses.push_back({.position_m = motion.position_m(kTick_s * static_cast<double>(tick + 1))});
  if (model.has_static_body) poses.emplace_back();
  for (std::size_t hand = 0; hand < model.hands; ++hand) poses.push_back(path.tool(tick));
  return poses;
}
std::vector<std::byte> block_of(const Engine& engine) {
  std::vector<std::byte> block;
  engine.save(block);
  return block;
}

TEST_CASE("A model of bytes is the model, and its engine the same to the bit", "[dynamics]") {
  for (const SceneModel& model : models()) {
    const std::vector<std::byte> bytes = encode(model);
    const SceneModel copy = decode(bytes);
    CHECK(fingerprint(copy.description) == fingerprint(model.description));
    CHECK(hash(copy.start) == hash(model.start));
    CHECK((encode(copy) == bytes));
    CHECK((copy.method().make == nullptr) == !model.is_implicit);
    CHECK((!model.is_implicit || copy.method().tolerance_m_s == model.tolerance_m_s));
    Engine engine(model.description, model.start, model.method());
    Engine other(copy.description, copy.start, copy.method());
    CHECK((block_of(other) == block_of(engine)));
    for (std::uint64_t tick = 0; tick < 600; ++tick) {
      engine.step(poses_at(model, tick));
      other.step(poses_at(copy, tick));
      REQUIRE(hash(other.state()) == hash(engine.state()));
    }
    CHECK((block_of(other) == block_of(engine)));
    if (model.start.tick == 5) CHECK(engine.sleep().all_sleep());
  }
}

/// Whether bytes are a model, with which an engine then steps.
bool steps(std::span<const std::byte> bytes, std::span<const SharedField> distances = {}) {
  try {
    const SceneModel model = decode(bytes, distances);
    Engine engine(model.description, model.start);
    engine.step(poses_at(model, 0), kTick_s, 1);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

TEST_CASE("Bytes that end early or go on are no model", "[dynamics]") {
  std::vector<std::byte> bytes = encode(joined(true));
  REQUIRE(steps(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size)
    REQUIRE_THROWS_AS(decode(std::span(bytes).first(size)), std::invalid_argument);
  bytes.push_back({});
  CHECK_THROWS_AS(decode(bytes), std::invalid_argument);
}

TEST_CASE("Bytes with any one changed are refused, or a model that steps", "[dynamics]") {
  std::mt19937_64 random(11);
  for (const SceneModel& model : {drawn(3), joined(false)}) {
    const std::vector<std::byte> bytes = encode(model);
    int refused = 0;
    constexpr int kChanges = 2000;
    for (int k = 0; k < kChanges; ++k) {
      std::vector<std::byte> hostile = bytes;
      hostile[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
      refused += steps(hostile) ? 0 : 1;
    }
    CHECK(refused > kChanges / 10);
    CHECK(refused < kChanges);
  }
}

/// A box and a ball of one field each fall on a static box, whose field is turned in its body.
SceneModel with_fields() {
  EngineScene scene;
  scene.with_gravity();
  const Eigen::Vector3d size_m(0.02, 0.02, 0.01);
  const SharedField box = box_field(size_m);
  add_field_box(scene, size_m, 0.01, {0, 0, 0.012}, box);
  add_field_ball(scene, 0.008, {0.001, 0, 0.03}, ball_field(0.008));
  add_static_field(scene, box, {0, 0, 0.001});
  scene.description.fields.back().position_m = {0.002, 0.001, -0.001};
  scene.description.fields.back().orientation =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized());
  scene.description.rigid_bodies.back().is_fixture = true;
  SceneModel model = model_of(scene);
  model.has_static_body = true;
  return model;
}
std::vector<SharedField> distances_of(const SceneModel& model) {
  std::vector<SharedField> distances;
  for (const Description::Field& field : model.description.fields)
    distances.push_back(field.distance);
  return distances;
}

TEST_CASE("A model with fields is the model again with their distances", "[dynamics]") {
  const SceneModel model = with_fields();
  const std::vector<std::byte> bytes = encode(model);
  const SceneModel copy = decode(bytes, distances_of(model));
  CHECK(fingerprint(copy.description) == fingerprint(model.description));
  CHECK((encode(copy) == bytes));
  Engine engine(model.description, model.start), other(copy.description, copy.start);
  bool touched = false;
  for (std::uint64_t tick = 0; tick < 100; ++tick) {
    engine.step(poses_at(model, tick));
    other.step(poses_at(copy, tick));
    REQUIRE(hash(other.state()) == hash(engine.state()));
    touched = touched || engine.touching() > 0;
  }
  CHECK(touched);
}

TEST_CASE("Fields and distances that do not fit are no model", "[dynamics]") {
  const SceneModel model = with_fields();
  const std::vector<std::byte> bytes = encode(model);
  std::vector<SharedField> distances = distances_of(model);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    REQUIRE_THROWS_AS(decode(std::span(bytes).first(size), distances), std::invalid_argument);
  CHECK_THROWS_AS(decode(bytes), std::invalid_argument);
  CHECK_THROWS_AS(decode(bytes, std::span(distances).first(2)), std::invalid_argument);
  distances.push_back(distances[0]);
  CHECK_THROWS_AS(decode(bytes, distances), std::invalid_argument);
  distances.pop_back();
  distances[1] = nullptr;
  CHECK_THROWS_AS(decode(bytes, distances), std::invalid_argument);
  using Change = std::function<void(Description::Field&)>;
  const std::vector<Change> changes{[](auto& field) { field.rigid = 3; },
                                    [](auto& field) { field.rigid = -1; },
                                    [](auto& field) { field.material = 9; },
                                    [](auto& field) { field.material = -1; },
                                    [](auto& field) { field.position_m.x() = 2e12; },
                                    [](auto& field) { field.orientation.w() += 0.1; }};
  for (std::size_t k = 0; k < changes.size(); ++k) {
    SceneModel changed = model;
    changes[k](changed.description.fields[2]);
    INFO(k);
    CHECK_THROWS_AS(decode(encode(changed), distances_of(model)), std::invalid_argument);
  }
}

TEST_CASE("Bytes or distances with any one changed are refused, or a model that steps",
          "[dynamics]") {
  std::mt19937_64 random(12);
  const SceneModel model = with_fields();
  const std::vector<std::byte> bytes = encode(model);
  const std::vector<SharedField> distances = distances_of(model);
  int refused = 0;
  constexpr int kChanges = 300;
  for (int k = 0; k < kChanges; ++k) {
    std::vector<std::byte> hostile = bytes;
    hostile[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    refused += steps(hostile, distances) ? 0 : 1;
  }
  CHECK(refused > 0);
  CHECK(refused < kChanges);
  for (int k = 0; k < 20; ++k) {
    std::vector<SharedField> lies = distances;
    for (SharedField& lie : lies) {
      const auto words = lie->words();
      std::vector<std::uint64_t> other(words.begin(), words.end());
      for (std::uint64_t& word : other)
        if (random() % 4 == 0) word = random();
      lie = std::make_shared<const collision::DistanceField>(lie->shape(), std::move(other));
    }
    CHECK(steps(bytes, lies));
  }
}

TEST_CASE("What contradicts its meaning is no model", "[dynamics]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  using Change = std::function<void(SceneModel&)>;
  const std::vector<std::pair<const char*, Change>> changes{
      {"no number", [&](auto& m) { m.start.rigid_velocity_m_s[0].y = kNan; }},
      {"beyond 1e12", [](auto& m) { m.description.gravity_m_s2.x() = 2e12; }},
      {"a sphere of five nodes", [](auto& m) { m.description.spheres[0].node_count = 5; }},
      {"a sphere of a body and nodes", [](auto& m) { m.description.spheres[0].node_count = 1; }},
      {"a sphere of nothing", [](auto& m) { m.description.spheres[0].rigid = -1; }},
      {"a sphere of no such material", [](auto& m) { m.description.spheres[0].material = 2; }},
      {"a joint of two things at an end", [](auto& m) { m.description.joints[0].a.rigid = 0; }},
      {"a joint of no such node", [](auto& m) { m.description.joints[0].a.node = 2; }},
      {"a joint with a length", [](auto& m) { m.description.joints[1].rest_length_m = 0.1; }},
      {"a denormal length", [](auto& m) { m.description.joints[0].rest_length_m = 5e-324; }},
      {"a negative stiffness", [](auto& m) { m.description.joints[1].stiffness_N_per_m = -1; }},
      {"a free fixture", [](auto& m) { m.description.rigid_bodies[0].is_fixture = true; }},
      {"a fixture at a velocity", [](auto& m) { m.description.rigid_bodies[2].is_fixture = true; }},
      {"a fixture that swings",
       [](auto& m) {
         m.description.rigid_bodies[2].is_fixture = true;
         m.prescribed[0].velocity_m_s.setZero();
       }},
      {"a normal that is none", [](auto& m) { m.description.planes[0].normal.x() = 1; }},
      {"no slip speed", [](auto& m) { m.description.materials[1].slip_speed_m_s = 0; }},
      {"negative friction", [](auto& m) { m.description.materials[1].friction = -0.1; }},
      {"pairs in no order",
       [](auto& m) { std::swap(m.description.apart[0], m.description.apart[1]); }},
      {"a pair of one body",
       [](auto& m) {
         m.description.apart[2] = {7, 7};
       }},
      {"no such sphere",
       [](auto& m) {
         m.description.apart_spheres = {{0, 99}};
       }},
      {"a body of no nodes",
       [](auto& m) { m.description.bodies = {{.first_node = 1, .node_count = 2}}; }},
      {"a body of fewer",
       [](auto& m) { m.description.bodies = {{.first_node = 1, .node_count = -1}}; }},
      {"a negative radius",
       [](auto& m) { m.description.bodies = {{.rigid = 0, .bounding_radius_m = -1}}; }},
      {"a node too many", [](auto& m) { m.start.node_position_m.emplace_back(); }},
      {"a body too few", [](auto& m) { m.start.is_here.pop_back(); }},
      {"no rotation", [](auto& m) { m.start.orientation[0] = {}; }},
      {"a free body away", [](auto& m) { m.start.is_here[0] = 0; }},
      {"a body half here", [](auto& m) { m.start.is_here[2] = 2; }},
      {"negative rates", [](auto& m) { m.start.contacts.damping_per_s = -1.0; }},
      {"no direction", [](auto& m) { m.prescribed[0].direction.setZero(); }},
      {"a hand too many", [](auto& m) { m.hands = 1; }},
      {"a motion too few", [](auto& m) { m.prescribed.clear(); }},
      {"no tolerance", [](auto& m) { m.tolerance_m_s = 0.0; }}};
  for (const auto& [what, change] : changes) {
    SceneModel model = joined(false);
    change(model);
    INFO(what);
    CHECK_THROWS_AS(decode(encode(model)), std::invalid_argument);
  }
  SceneModel crowd = joined(false);
  crowd.prescribed.clear();
  crowd.has_static_body = false;
  for (crowd.hands = 2; crowd.hands < 5; ++crowd.hands) {
    CHECK_NOTHROW(decode(encode(crowd)));
    crowd.description.rigid_bodies.push_back({.is_driven = true});
    crowd.start.rigid_position_m.emplace_back();
    crowd.start.rigid_velocity_m_s.emplace_back();
    crowd.start.orientation.emplace_back(0.0, 0.0, 0.0, 1.0);
    crowd.start.angular_velocity_rad_s.emplace_back();
    crowd.start.is_here.push_back(0);
  }
  CHECK_THROWS_AS(decode(encode(crowd)), std::invalid_argument);
}

TEST_CASE("A prescribed motion is steady, and a sine", "[dynamics]") {
  const PrescribedMotion motion{{1, 2, 3}, {0.5, 0, 0}, Eigen::Vector3d::UnitY(), 0.1, 0.25};
  CHECK(motion.position_m(0.0) == Eigen::Vector3d(1, 2, 3));
  CHECK(motion.position_m(1.0).isApprox(Eigen::Vector3d(1.5, 2.1, 3)));
  CHECK(motion.position_m(3.0).isApprox(Eigen::Vector3d(2.5, 1.9, 3)));
}

TEST_CASE(
    "A prescribed motion passes its keyframes, never beyond them, and rests where two are equal",
    "[dynamics]") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> later_s(0.01, 1.0), way_m(-0.1, 0.1);
  for (int repetition = 0; repetition < 50; ++repetition) {
    PrescribedMotion::Keyframes keyframes;
    double time_s = 0.0;
    for (int k = 0; k < 1 + repetition % 7; ++k)
      keyframes.push_back(
          {time_s += later_s(random), {way_m(random), way_m(random), way_m(random)}});
    keyframes.push_back({time_s += later_s(random), keyframes.back().displacement_m});
    PrescribedMotion motion{.start_m = {1, 2, 3}};
    motion.keyframes = std::make_shared<const PrescribedMotion::Keyframes>(keyframes);
    CHECK(motion.position_m(0.0) == motion.start_m);
    CHECK(motion.velocity_at_m_s(0.0).isZero(0.0));
    Keyframe before;
    for (const Keyframe& next : keyframes) {
      CHECK(motion.position_m(next.time_s).isApprox(motion.start_m + next.displacement_m, 1e-12));
      const Eigen::Vector3d low_m = before.displacement_m.cwiseMin(next.displacement_m),
                            high_m = before.displacement_m.cwiseMax(next.displacement_m);
      for (double share = 0.05; share < 1.0; share += 0.1) {
        const double at_s = before.time_s + share * (next.time_s - before.time_s);
        const Eigen::Vector3d moved_m = motion.position_m(at_s) - motion.start_m;
        CHECK(((moved_m - low_m).minCoeff() > -1e-12 && (high_m - moved_m).minCoeff() > -1e-12));
        const double h = 1e-6;
        const Eigen::Vector3d rate_m_s =
            (motion.position_m(at_s + h) - motion.position_m(at_s - h)) / (2.0 * h);
        CHECK((rate_m_s - motion.velocity_at_m_s(at_s)).norm() <
              1e-6 * motion.highest_speed_m_s() + 1e-8);
      }
      before = next;
    }
    CHECK(motion.position_m(time_s + 100.0) == motion.start_m + keyframes.back().displacement_m);
    CHECK(motion.velocity_at_m_s(time_s + 100.0).isZero(0.0));
  }
}

TEST_CASE("Keyframes are carried with a model, and checked", "[dynamics]") {
  SceneModel model = joined(false);
  PrescribedMotion& motion = model.prescribed.back();
  const auto with = [&](PrescribedMotion::Keyframes keyframes) {
    motion.keyframes = std::make_shared<const PrescribedMotion::Keyframes>(std::move(keyframes));
    return encode(model);
  };
  const std::vector<std::byte> bytes = with({{0.5, {0, 0, 0.1}}, {1.5, {0, 0.2, 0.1}}});
  const SceneModel carried = decode(bytes);
  CHECK(encode(carried) == bytes);
  CHECK(carried.prescribed.back().position_m(0.7) == motion.position_m(0.7));
  CHECK_THROWS_AS(decode(with({{1.5, {0, 0, 0.1}}, {0.5, {0, 0.2, 0.1}}})), std::invalid_argument);
  CHECK_THROWS_AS(decode(with({{0.0, {0, 0, 0.1}}})), std::invalid_argument);
  std::vector<std::byte> of_another = with({{0.5, {0, 0, 0.1}}});
  of_another[of_another.size() - 4 * sizeof(double) - sizeof(std::uint32_t)] = std::byte{200};
  CHECK_THROWS_AS(decode(of_another), std::invalid_argument);
}

TEST_CASE("A state's hash changes with each of its numbers, and with two signs", "[dynamics]") {
  SceneModel model = drawn(3);
  SceneState& state = model.start;
  const std::uint64_t before = hash(state);
  CHECK(hash(SceneState(state)) == before);
  const auto differs = [&] { return hash(state) != before; };
  ++state.tick;
  CHECK(differs());
  --state.tick;
  for (auto* array : {&state.node_position_m, &state.node_velocity_m_s, &state.rigid_position_m,
                      &state.rigid_velocity_m_s, &state.orientation, &state.angular_velocity_rad_s})
    for (Vector4& v : *array)
      for (double* number : {&v.x, &v.y, &v.z, &v.w}) {
        const double was = *number;
        *number = std::nextafter(was, 1e9);
        CHECK(differs());
        *number = was;
      }
  for (std::uint8_t& is_here : state.is_here) {
    is_here ^= 1;
    CHECK(differs());
    is_here ^= 1;
  }
  for (Vector4* v : {&state.node_position_m[0], &state.node_position_m[1]}) v->x = -v->x;
  CHECK(differs());
  for (Vector4* v : {&state.node_position_m[0], &state.node_position_m[1]}) v->x = -v->x;
  CHECK(hash(state) == before);
}

}  // namespace
}  // namespace stillgrid::dynamics::scene_model_test
