#include <bit>
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <random>

#include "proto/segment_header.hpp"
#include "shared/local/given_scene.hpp"
#include "tests/shared/local/given_scene.hpp"

namespace stillgrid::local::given_state_test {
namespace {

using Eigen::Vector3d;
constexpr std::size_t kMaterials = 2;

/// A model that the states are of.
GivenModel model_of_states() {
  GivenModel model = ball_model(500.0);
  model.materials.resize(kMaterials, model.materials[0]);
  return model;
}

/// Two bodies of three spheres.
GivenState sound_state() {
  GivenState state = one_ball(0.1, 0.02);
  state.bodies[0].twist << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  state.bodies[0].acceleration << 6.0, 5.0, 4.0, 3.0, 2.0, 1.0;
  Twist motion;
  motion << 0.1, 0.2, 0.0, 0.0, 0.0, 1.0;
  state.bodies.push_back({.number = 8,
                          .centre_m = Vector3d(1.0, 2.0, 3.0),
                          .inverse_inertia = 5000.0 * motion * motion.transpose()});
  state.spheres.push_back(
      {.body = 1, .number = 0, .material = 1, .radius_m = 0.01, .arm_m = Vector3d(1.0, 0.0, 0.0)});
  state.spheres.push_back({.body = 1, .number = 1, .material = 0, .radius_m = 0.02});
  state.proxies = {{.is_here = true,
                    .position_m = Vector3d(0.0, 0.0, 0.025),
                    .stretch_m = Vector3d(1e-4, 0.0, 0.0),
                    .device_m = Vector3d(0.0, 0.0, 0.024)}};
  return state;
}
std::vector<std::byte> block_of(const GivenState& state) {
  std::vector<std::byte> bytes;
  encode(state, bytes);
  return bytes;
}
bool is_refused(std::span<const std::byte> bytes) {
  GivenState state = sound_state();
  const bool is_taken = decode(bytes, model_of_states(), state);
  CHECK((is_taken || (state.bodies.empty() && state.spheres.empty() && state.proxies.empty())));
  return !is_taken;
}
template <class Change>
bool is_refused_with(Change&& change) {
  GivenState state = sound_state();
  change(state);
  return is_refused(block_of(state));
}

TEST_CASE("A state is decoded as it was, to the bit", "[given_state]") {
  const std::vector<std::byte> bytes = block_of(sound_state());
  CHECK(bytes.size() <= given_state_capacity(3));
  GivenState state;
  REQUIRE(decode(bytes, model_of_states(), state));
  CHECK(block_of(state) == bytes);
  CHECK(state.bodies[1].centre_m == Vector3d(1.0, 2.0, 3.0));
  CHECK(state.spheres[1].material == 1);
}

TEST_CASE("A state that no publisher writes is refused whole", "[given_state]") {
  const double bad = GENERATE(std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(), -1e13, 1e300);
  CHECK_FALSE(is_refused_with([](GivenState&) {}));
  CHECK(is_refused_with([&](GivenState& s) { s.bodies[1].centre_m.y() = bad; }));
  CHECK(is_refused_with([&](GivenState& s) { s.bodies[0].twist[5] = bad; }));
  CHECK(is_refused_with([&](GivenState& s) { s.bodies[0].acceleration[0] = bad; }));
  CHECK(is_refused_with([&](GivenState& s) { s.bodies[0].inverse_inertia(2, 2) = bad; }));
  CHECK(is_refused_with([&](GivenState& s) {
    s.bodies[0].inverse_inertia(0, 5) = s.bodies[0].inverse_inertia(5, 0) = bad;
  }));
  CHECK(is_refused_with([&](GivenState& s) { s.spheres[2].arm_m.x() = bad; }));
  CHECK(is_refused_with([&](GivenState& s) { s.spheres[2].radius_m = bad; }));
  // Asymmetric, and with an eigenvalue below 0.
  CHECK(is_refused_with([](GivenState& s) { s.bodies[0].inverse_inertia(0, 1) = 0.1; }));
  CHECK(is_refused_with([](GivenState& s) { s.bodies[0].inverse_inertia(3, 3) = -1.0; }));
  CHECK(is_refused_with([](GivenState& s) {
    s.bodies[0].inverse_inertia.topLeftCorner<3, 3>() << 1.0, 0.9, -0.9, 0.9, 1.0, 0.9, -0.9, 0.9,
        1.0;
  }));
  CHECK(is_refused_with([](GivenState& s) { s.bodies[0].number = 8; }));  // twice the same
  CHECK(is_refused_with([](GivenState& s) { s.bodies[0].number = 9; }));  // not in order
  CHECK(is_refused_with([](GivenState& s) { s.spheres[2].body = 2; }));   // no such body
  CHECK(is_refused_with([](GivenState& s) { s.spheres[0].body = 1, s.spheres[1].body = 0; }));
  CHECK(is_refused_with([](GivenState& s) { s.spheres[1].material = kMaterials; }));
  CHECK(is_refused_with([](GivenState& s) { s.spheres[1].radius_m = 0.0; }));
  CHECK(is_refused_with([&](GivenState& s) { s.proxies[0].position_m.x() = bad; }));
  CHECK(is_refused_with([&](GivenState& s) { s.proxies[0].stretch_m.y() = bad; }));
  CHECK(is_refused_with([&](GivenState& s) { s.proxies[0].device_m.z() = bad; }));
  CHECK(is_refused_with([](GivenState& s) { s.proxies.resize(2); }));  // one tool sphere
  CHECK_FALSE(is_refused_with([](GivenState& s) { s.proxies.clear(); }));
  std::vector<std::byte> bytes = block_of(sound_state());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    REQUIRE(is_refused(std::span(bytes).first(size)));
  bytes.push_back({});
  CHECK(is_refused(bytes));
}

TEST_CASE("A state of any bytes is refused, or moves on to plausible places", "[given_state]") {
  std::mt19937_64 random(GENERATE(range(1U, 5U)));
  const std::vector<std::byte> sound = block_of(sound_state());
  const GivenModel model = model_of_states();
  GivenBodies bodies(model);
  GivenState state;
  for (int round = 0; round < 3000; ++round) {
    std::vector<std::byte> bytes = sound;
    for (int change = 0; change < 2; ++change) {
      const std::uint64_t word = random() % 3 == 0 ? random() : random() % 4;
      std::memcpy(bytes.data() + random() % (bytes.size() / 8) * 8, &word, 8);
    }
    if (!decode(bytes, model, state)) continue;
    bodies.begin(state);
    for (int tick = 0; tick < 5; ++tick) bodies.step(Tools{tool_at({0.0, 0.0, 0.0})});
    for (const GivenSphere& sphere : bodies.spheres())
      if (bodies.is_plausible()) REQUIRE(bodies.position_m(sphere).allFinite());
  }
}

TEST_CASE("A model is decoded as it was; another's is none", "[given_state]") {
  GivenModel model = ball_model(500.0, 2);
  model.tools[1].spheres.push_back({Vector3d(0.1, 0.0, 0.0), 0.01});
  const std::vector<std::byte> bytes = encode(model);
  REQUIRE(is_given_model(bytes));
  CHECK(encode(decode_given_model(bytes)) == bytes);
  for (std::size_t word = 0; word < bytes.size() / 8; ++word)
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -1.0, 1e300}) {
      std::vector<std::byte> hostile = bytes;
      std::memcpy(hostile.data() + 8 * word, &bad, 8);
      try {
        const GivenModel taken = decode_given_model(hostile);
        for (const auto& tool : taken.tools)
          for (const auto& sphere : tool.spheres)
            REQUIRE(sphere.centre_m.cwiseAbs().maxCoeff() <= proto::kLargestNumber);
      } catch (const std::invalid_argument&) {
      }
    }
  for (std::size_t size = 0; size < bytes.size(); ++size)
    REQUIRE_THROWS_AS(decode_given_model(std::span(bytes).first(size)), std::invalid_argument);
  CHECK_FALSE(is_given_model(std::span(bytes).first(7)));
  CHECK_THROWS_AS(GivenScene(bytes, 1, 0), std::invalid_argument);
  CHECK_THROWS_AS(GivenScene(bytes, 2, 2), std::invalid_argument);
}

/// A tool that comes down onto the ball.
dynamics::PathPose path_at(std::uint64_t tick) {
  const double height_m = 0.026 - 2e-4 * static_cast<double>(tick);
  return {{{0.0, 0.0, height_m}, Eigen::Quaterniond::Identity(), {0.0, 0.0, -0.2}}, tick};
}

TEST_CASE("A copy catches up along the path, then stands two periods after its state",
          "[given_scene]") {
  const GivenModel model = ball_model(500.0, 1, 40);
  const GivenState start = one_ball(0.1, 0.02);
  GivenScene scene(encode(model), 1, 0);
  for (std::uint64_t tick = 0; tick <= 30; ++tick) {
    scene.add_to_path(path_at(tick));
    CHECK_FALSE(scene.advance_to(tick).is_known);
  }
  REQUIRE(scene.begin_at(0, block_of(start)));
  CHECK(scene.confirms(40));  // on its way
  std::uint64_t tick = 30;
  bool is_known = false;
  while (!is_known && tick < 60) {
    scene.add_to_path(path_at(++tick));
    is_known = scene.advance_to(tick).is_known;
  }
  CHECK(tick == 45);  // by three ticks in each
  CHECK(scene.confirms(0));
  CHECK_FALSE(scene.confirms(40));
  GivenBodies bodies(model);
  bodies.begin(start, Tools{path_at(0)});
  for (std::uint64_t n = 1; n <= tick; ++n) bodies.step(Tools{path_at(n)});
  CHECK(scene.bodies().bodies()[0].centre_m == bodies.bodies()[0].centre_m);
  CHECK(scene.bodies().bodies()[0].twist == bodies.bodies()[0].twist);
  CHECK(bodies.bodies()[0].twist[2] < -0.1);
  // A hostile state changes nothing; a sound one of now replaces the copy.
  CHECK_FALSE(scene.begin_at(tick, {}));
  REQUIRE(scene.advance_to(tick).is_known);
  CHECK(scene.bodies().bodies()[0].centre_m == bodies.bodies()[0].centre_m);
  while (tick < 85) {
    scene.add_to_path(path_at(++tick));
    REQUIRE(scene.advance_to(tick).is_known);
    CHECK((scene.bodies().bodies()[0].twist.norm() == 0.0) == (tick > 80));
  }
  REQUIRE(scene.begin_at(85, block_of(start)));
  const Vector3d shown_m = scene.position_m(0);
  const Advance advance = scene.advance_to(85);
  REQUIRE((advance.is_known && advance.is_swap && advance.ticks == 0));
  CHECK(scene.bodies().bodies()[0].centre_m.norm() == 0.0);
  CHECK((scene.position_m(0) - shown_m).norm() < 1e-12);  // where it was, but not for long
  CHECK(shown_m.norm() > 1e-3);
  for (std::uint64_t later = 1; later <= 20; ++later) {
    scene.add_to_path(
        {{{0.0, 0.0, 1.0}, Eigen::Quaterniond::Identity(), Vector3d::Zero()}, 85 + later});
    REQUIRE(scene.advance_to(85 + later).is_known);
    CHECK((scene.position_m(0) - (1.0 - 0.05 * static_cast<double>(later)) * shown_m).norm() <
          1e-12);
  }
}

TEST_CASE("At a swap the own proxy and its stretch stay where they are shown", "[given_scene]") {
  GivenModel model = ball_model(500.0, 1, 40);
  model.materials[0].friction = 0.5;
  GivenState start = one_ball(0.1, 0.02);
  GivenScene scene(encode(model), 1, 0);
  const auto across_at = [](std::uint64_t tick) {
    dynamics::PathPose pose = path_at(std::min<std::uint64_t>(tick, 15));
    pose.number = tick;
    pose.position_m.x() = 2e-5 * static_cast<double>(tick);
    return pose;
  };
  scene.add_to_path(across_at(0));
  REQUIRE(scene.begin_at(0, block_of(start)));
  for (std::uint64_t tick = 1; tick <= 30; ++tick) {
    scene.add_to_path(across_at(tick));
    REQUIRE(scene.advance_to(tick).is_known);
  }
  const Vector3d proxy_m = scene.own_proxies_m()[0].vector();
  const Vector3d stretch_m = scene.own_stretches_m()[0].vector();
  REQUIRE(stretch_m.norm() > 1e-5);
  // The publisher's ball went elsewhere, and so did its proxy.
  start.bodies[0].centre_m = Vector3d(1e-4, 0.0, -2e-4);
  start.proxies = {{.is_here = true,
                    .position_m = proxy_m + Vector3d(1e-4, 0.0, -2e-4),
                    .device_m = across_at(30).position_m}};
  REQUIRE(scene.begin_at(30, block_of(start)));
  REQUIRE(scene.advance_to(30).is_swap);
  CHECK((scene.own_proxies_m()[0].vector() - proxy_m).norm() < 1e-12);
  CHECK((scene.own_stretches_m()[0].vector() - stretch_m).norm() < 1e-12);
  for (std::uint64_t tick = 31; tick <= 50; ++tick) {
    scene.add_to_path(across_at(tick));
    REQUIRE(scene.advance_to(tick).is_known);
  }
  // After half a period the copy's own alone are left.
  CHECK(scene.own_stretches_m()[0].vector().norm() < 5e-4);
  CHECK((scene.own_proxies_m()[0].vector() - scene.bodies().tools().proxies(0)[0].position_m)
            .norm() == 0.0);
}

}  // namespace
}  // namespace stillgrid::local::given_state_test
