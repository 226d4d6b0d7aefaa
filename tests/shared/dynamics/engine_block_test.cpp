// A saved state is all that the future depends on.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "shared/dynamics/rigid_motion.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/shared/dynamics/drawn_scene.hpp"
#include "tests/sim_server/every_target.hpp"

namespace stillgrid::dynamics::engine_block_test {
namespace {

void run(Engine& engine, const DrawnScene& drawn, int ticks) {
  for (int k = 0; k < ticks; ++k) {
    const DrivenPose pose = drawn.tool(engine.state().tick);
    engine.step(std::span(&pose, 1));
  }
}
std::vector<std::byte> block_of(const Engine& engine) {
  std::vector<std::byte> block;
  engine.save(block);
  return block;
}

/// What a user may do between two ticks.
void change(Engine& engine, std::uint64_t kind) {
  const Eigen::Vector3d gravity = engine.description().gravity_m_s2;
  if (kind == 1 || kind == 2) engine.set_gravity({0.0, 1.0, -9.0});
  if (kind == 1) engine.set_gravity(gravity);
  if (kind == 3) {
    SceneState thrown = engine.state();
    for (Vector4& velocity : thrown.rigid_velocity_m_s) velocity.z += 0.1;
    engine.set_state(std::move(thrown));
  }
}

constexpr std::uint64_t kScenes = tests::kIsSanitized ? 20 : 1000;
constexpr std::size_t kNone = ~std::size_t{0};
/// The first byte in which two blocks differ.
std::size_t first_difference(const std::vector<std::byte>& a, const std::vector<std::byte>& b) {
  const auto [in_a, in_b] = std::ranges::mismatch(a, b);
  if (in_a == a.end() && in_b == b.end()) return kNone;
  return static_cast<std::size_t>(in_a - a.begin());
}

TEST_CASE("A run through a saved block is equal to the bit, of a thousand drawn and changed scenes",
          "[dynamics]") {
  std::size_t in_contact = 0;
  for (std::uint64_t seed = 0; seed < kScenes; ++seed) {
    const DrawnScene drawn(seed);
    Engine whole = drawn.scene.engine(), first = drawn.scene.engine();
    Engine second = drawn.scene.engine();
    const int ticks = seed % 50 == 0 ? 0 : 40 + static_cast<int>(seed % 60);
    for (Engine* engine : {&whole, &first}) {
      run(*engine, drawn, ticks);
      change(*engine, seed % 4);
    }
    run(whole, drawn, ticks);
    if (seed % 2 == 0) run(second, DrawnScene(seed), 7);  // it has been somewhere else before
    if (seed % 4 == 2) change(second, 2);                 // gravity is part of the description
    second.load(block_of(first));
    run(second, drawn, ticks);
    INFO("seed " << seed);
    REQUIRE(first_difference(block_of(second), block_of(whole)) == kNone);
    const auto is_pressed = [](const ContactRow& row) {
      return std::ranges::any_of(row.push_impulse_N_s, [](float push) { return push > 0.0F; });
    };
    if (std::ranges::any_of(whole.listing().rows().rows, is_pressed)) ++in_contact;
  }
  CHECK(in_contact > kScenes * 2 / 3);  // else little was tried
}

TEST_CASE("A pile that is solved in parts runs through a saved block to the bit", "[dynamics]") {
  Engine through = falling_pile(5000).engine(), other = falling_pile(5000).engine();
  for (int k = 0; k < 60; ++k) through.step();
  const auto& groups = through.listing().rows().groups;
  REQUIRE(std::ranges::count_if(groups, [](const RowGroup& group) { return group.part > 0; }) > 4);
  other.load(block_of(through));
  for (int k = 0; k < 20; ++k) {
    through.step();
    other.step();
  }
  CHECK(block_of(other) == block_of(through));
}

TEST_CASE("Every instruction set computes the same bytes", "[dynamics]") {
  for (std::uint64_t seed = 0; seed < 30 / tests::kCut; ++seed) {
    std::vector<std::byte> before;
    sim_server::on_every_target([&] {
      const DrawnScene drawn(seed);
      Engine engine = drawn.scene.engine();
      run(engine, drawn, 150);
      std::vector<std::byte> block = block_of(engine);
      INFO("seed " << seed);
      if (!before.empty()) REQUIRE(first_difference(block, before) == kNone);
      before = std::move(block);
    });
  }
}

TEST_CASE("A block that is none of this scene is refused, and nothing changes", "[dynamics]") {
  const DrawnScene drawn(3), other(4);
  Engine engine = drawn.scene.engine(), stranger = other.scene.engine();
  run(engine, drawn, 50);
  run(stranger, other, 50);
  const std::vector<std::byte> block = block_of(engine);
  CHECK_THROWS_AS(engine.load(block_of(stranger)), std::invalid_argument);
  std::vector<std::byte> shorter = block, longer = block;
  shorter.pop_back();
  longer.push_back({});
  CHECK_THROWS_AS(engine.load(shorter), std::invalid_argument);
  CHECK_THROWS_AS(engine.load(longer), std::invalid_argument);
  CHECK(first_difference(block_of(engine), block) == kNone);
}

TEST_CASE("A turn by an infinite angle is no number and ends", "[engine]") {
  for (const double angle_rad : {1e16, 1e200, std::numeric_limits<double>::infinity()})
    CHECK(std::isnan(rotation_by({0.0, angle_rad, 0.0}).w()));
}

TEST_CASE("A block with any byte changed is refused or loaded, and a step after it ends",
          "[dynamics]") {
  const DrawnScene drawn(3);
  Engine engine = drawn.scene.engine();
  run(engine, drawn, 50);
  const std::vector<std::byte> block = block_of(engine);
  for (std::size_t k = 0; k < block.size(); k += 13) {
    std::vector<std::byte> hostile = block;
    hostile[k] ^= std::byte{0xFF};
    try {
      engine.load(hostile);
      run(engine, drawn, 2);
    } catch (const std::invalid_argument&) {
    }
  }
  engine.load(block);
  CHECK(first_difference(block_of(engine), block) == kNone);
}

}  // namespace
}  // namespace stillgrid::dynamics::engine_block_test
