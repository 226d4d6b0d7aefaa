#include <catch2/catch.hpp>
#include <cmath>

#include "shared/dynamics/rigid_motion.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/shared/dynamics/drawn_scene.hpp"
#include "tests/shared/dynamics/field_scenes.hpp"
#include "tests/shared/dynamics/implicit_scenes.hpp"

namespace stillgrid::dynamics::energy_test {
namespace {

/// Sums over ticks.
struct Account {
  double start_J, given_J = 0.0, turnover_J = 0.0;  // of gifts and their opposites
  EnergyLosses losses;

  explicit Account(const Engine& engine) : start_J(energy_J(engine)) {}

  void note_tick(const Engine& engine) {
    const SceneState& state = engine.state();
    losses += engine.losses();
    std::size_t k = 0;
    for (std::size_t r = 0; r < state.rigid_position_m.size(); ++r) {
      if (!engine.description().rigid_bodies[r].is_driven) continue;
      const DrivenReaction& reaction = engine.reactions()[k++];
      const double work_J = reaction.brought_J + reaction.aimed_J -
                            reaction.impulse_N_s.dot(state.rigid_velocity_m_s[r].vector()) -
                            reaction.moment_N_m_s.dot(state.angular_velocity_rad_s[r].vector());
      given_J += work_J;
      turnover_J += std::abs(work_J);
    }
  }
  [[nodiscard]] double missing_J(const Engine& engine) const {
    return start_J + given_J + losses.unsolved_J - losses.spring_damping_J -
           losses.contact_damping_J - losses.friction_J - energy_J(engine);
  }
  [[nodiscard]] double lost_J() const {
    return losses.spring_damping_J + losses.contact_damping_J + losses.friction_J;
  }
};

TEST_CASE("The energies of a ball that slides, rolls and bounces are accounted for to rounding",
          "[energy]") {
  EngineScene scene;
  scene.description.materials = {{2000.0, GENERATE(0.0, 1.5), 0.3}};
  scene.description.gravity_m_s2 = {1.1, 0.0, -9.7};
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  scene.add_plane(-Eigen::Vector3d::UnitX(), -0.3);
  const auto ball = static_cast<std::size_t>(scene.add_ball(0.01, {-0.3, 0.0, 0.03}));
  scene.state.rigid_velocity_m_s[ball] = {0.4, 0.1, -0.5};
  scene.state.angular_velocity_rad_s[ball] = {0.0, 0.0, 40.0};
  Engine engine = scene.engine();
  engine.count_losses();
  Account account(engine);
  for (int tick = 0; tick < 2000; ++tick) {
    engine.step();
    account.note_tick(engine);
  }
  CHECK(account.losses.friction_J > 1e-5);
  CHECK((account.losses.contact_damping_J > 1e-5) ==
        (scene.description.materials[0].damping_N_s_per_m > 0.0));
  CHECK(std::abs(account.missing_J(engine)) < 2e-6 * account.lost_J());
  // The mean force of a contact's spring is exact, also as the ball comes and goes.
  CHECK(std::abs(account.losses.unsolved_J) < 2e-3 * account.start_J);
}

TEST_CASE("In drawn scenes losses and gifts are all that changes the energy", "[energy]") {
  for (std::uint64_t seed = 0; seed < 100 / tests::kCut; ++seed) {
    CAPTURE(seed);
    const DrawnScene drawn(seed);
    Engine engine = drawn.scene.engine();
    engine.count_losses();
    // Some bodies begin as deep as their radii in each other.
    for (std::uint64_t tick = 0; tick < 30; ++tick) engine.step(std::vector{drawn.tool(tick)});
    Account account(engine);
    for (std::uint64_t tick = 30; tick < 400; ++tick) {
      engine.step(std::vector{drawn.tool(tick)});
      account.note_tick(engine);
    }
    INFO("lost " << account.lost_J() << " given " << account.given_J << " unsolved "
                 << account.losses.unsolved_J << " missing " << account.missing_J(engine));
    CHECK(std::abs(account.missing_J(engine)) <
          0.04 * (account.lost_J() + account.turnover_J) + 1e-6);
  }
}

TEST_CASE("A tool that comes to a field, presses and leaves gives what the account says",
          "[energy]") {
  const auto seed = GENERATE(range(0U, tests::seeds_end(12)));
  CAPTURE(seed);
  const double side_m = 0.02 + 0.002 * seed, from_m = side_m + 0.02;
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  const Eigen::Vector3d size_m = Eigen::Vector3d::Constant(side_m);
  add_field_box(scene, size_m, 0.05, {0.0, 0.0, 0.5 * side_m}, box_field(size_m));
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), {0.0, 0.0, from_m}, true);
  scene.add_sphere(tool, 0.005);
  scene.description.spheres.back().is_tool = true;
  Engine engine = scene.engine(each_method());
  engine.count_losses();
  Account account(engine);
  for (int tick = 1; tick <= 1000; ++tick) {
    DrivenPose pose;
    const double share = 0.5 - 0.5 * std::cos(2.0 * M_PI * tick * kTick_s);
    pose.position_m = {1e-3 * seed, 5e-4 * seed, from_m - 0.019 * share};
    engine.step(std::vector{pose});
    account.note_tick(engine);
    const DrivenReaction& reaction = engine.reactions().front();
    const bool is_away = pose.position_m.z() > side_m + 0.007;
    if (is_away && reaction.impulse_N_s.isZero()) CHECK(reaction.aimed_J == 0.0);
  }
  INFO("given " << account.given_J << " missing " << account.missing_J(engine));
  CHECK(account.turnover_J > 1e-3);
  CHECK(std::abs(account.missing_J(engine)) < 0.01 * account.turnover_J + 1e-6);
}

TEST_CASE("What a driven body gives by a joint, and what damped joints lose, is accounted for",
          "[energy]") {
  // Links that hang on a handle, which swings and turns; the last one rubs along the floor.
  EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitZ(), -0.135);
  int before = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), true);
  Eigen::Vector3d hook(0.0, 0.0, -0.01);
  for (int k = 0; k < 5; ++k) {
    const int link = scene.add_rigid(0.02, {4e-6, 4e-6, 1e-6}, {0.0, 0.0, -0.025 - 0.025 * k});
    scene.add_sphere(link, 0.01);
    scene.description.joints.push_back({{.rigid = before, .point_m = hook},
                                        {.rigid = link, .point_m = {0.0, 0.0, 0.0125}},
                                        0.0,
                                        300.0,
                                        GENERATE(0.0, 0.3)});
    hook = {0.0, 0.0, -0.0125};
    before = link;
  }
  Engine engine = scene.engine();
  engine.count_losses();
  Account account(engine);
  for (int tick = 1; tick <= 1500; ++tick) {
    const double t_s = tick * kTick_s;
    DrivenPose pose;
    pose.position_m = {0.03 * std::sin(8.0 * t_s), 0.02 * std::sin(5.0 * t_s), 0.0};
    pose.orientation = rotation_by({0.4 * std::sin(7.0 * t_s), 0.0, 0.0});
    engine.step(std::vector{pose});
    account.note_tick(engine);
  }
  INFO("lost " << account.lost_J() << " given " << account.given_J << " missing "
               << account.missing_J(engine));
  CHECK(account.turnover_J > 1e-3);
  CHECK(account.losses.friction_J > 1e-5);
  CHECK(std::abs(account.missing_J(engine)) < 0.005 * (account.lost_J() + account.turnover_J));
}

TEST_CASE("Losses are counted without changing a step", "[energy]") {
  const DrawnScene drawn(3);
  Engine one = drawn.scene.engine(), other = drawn.scene.engine();
  one.count_losses();
  for (std::uint64_t tick = 0; tick < 100; ++tick) {
    one.step(std::vector{drawn.tool(tick)});
    other.step(std::vector{drawn.tool(tick)});
  }
  std::vector<std::byte> one_block, other_block;
  one.save(one_block);
  other.save(other_block);
  CHECK(one_block == other_block);
  CHECK(other.losses().friction_J == 0.0);
}

}  // namespace
}  // namespace stillgrid::dynamics::energy_test
