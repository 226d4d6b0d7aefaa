#include "sim_server/dynamics/forces/spring_forces.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "tests/sim_server/every_target.hpp"
#include "tests/sim_server/scene_builders.hpp"
#include "tests/sim_server/unkind_heap.hpp"

namespace stillgrid::dynamics::spring_forces_test {
namespace {

bodies::BodyDescription cloth(const Eigen::Vector2i& nodes, double damping_N_s_per_m) {
  bodies::BodyDescription body = sim_server::sheet(nodes, 0.02, 0.002, 500.0);
  sim_server::shear_stiffness_N_per_m(body) = 250.0;
  sim_server::springs(body).bend_stiffness_N_per_m = 50.0;
  sim_server::springs(body).spring_damping_N_s_per_m = damping_N_s_per_m;
  sim_server::packing(body) = {0.02, 0.009};
  return body;
}

/// Moved and turned about at random, nodes apart.
bodies::World shaken(bodies::BodyDescription body, double shake_m) {
  sim_server::springs(body).pinned_nodes = {0};
  body.orientation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  bodies::World world = scene::build_world(sim_server::scene_of({body}));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake(-shake_m, shake_m), speed(-1.0, 1.0);
  for (bodies::Node& node : world.nodes) {
    if (node.pinned) continue;
    node.position_m += Eigen::Vector3d(shake(random), shake(random), shake(random));
    node.velocity_m_s = {speed(random), speed(random), speed(random)};
  }
  return world;
}

ExplicitState state_of(const bodies::World& world) {
  ExplicitState state;
  for (const bodies::Node& node : world.nodes) {
    state.position_m.emplace_back().map() = node.position_m;
    state.velocity_m_s.emplace_back().map() = node.velocity_m_s;
    state.force_N.push_back({7.0, 7.0, 7.0});
    state.inverse_mass_per_kg.push_back(node.unknown == bodies::kNoUnknown ? 0.0
                                                                           : 1.0 / node.mass_kg);
  }
  return state;
}

/// Of all instruction sets, the largest difference to MechanicalSystem's forces, over the largest
/// push of a spring.
double worst_difference(const bodies::World& world) {
  MechanicalSystem system(world, {});
  system.place(Eigen::VectorXd::Zero(world.unknown_count), system.velocity(), 0.0);
  Eigen::VectorXd force(world.unknown_count);
  system.force(1.0, force);
  double worst_N = 0.0, push_N = 0.0;
  sim_server::on_every_target([&] {
    ExplicitState state = state_of(world);
    SpringForces springs(world);
    (void)springs.evaluate(world, state);
    for (std::size_t i = 0; i < world.nodes.size(); ++i) {
      const int unknown = world.nodes[i].unknown;
      if (unknown == bodies::kNoUnknown) continue;
      worst_N = std::max(worst_N, (force.segment<3>(unknown) - state.force_N[i].map()).norm());
    }
  });
  for (const bodies::Spring& spring : world.springs)
    push_N = std::max(push_N, spring.stiffness_N_per_m * spring.rest_length_m);
  return worst_N / push_N;
}

TEST_CASE("Forces of a sheet's springs are those of the mechanical system", "[spring_forces]") {
  const double damping_N_s_per_m = GENERATE(0.0, 0.3);
  const double shake_m = GENERATE(0.0, 1e-6, 0.008);
  const sim_server::UnkindHeap heap(GENERATE(0U, 16U, 32U, 48U));
  const Eigen::Vector2i nodes = GENERATE(
      Eigen::Vector2i(1, 7), Eigen::Vector2i(7, 1), Eigen::Vector2i(2, 2), Eigen::Vector2i(3, 5),
      Eigen::Vector2i(8, 8), Eigen::Vector2i(9, 17), Eigen::Vector2i(17, 9));
  CAPTURE(nodes.transpose());
  CHECK(worst_difference(shaken(cloth(nodes, damping_N_s_per_m), shake_m)) < 1e-12);
}

TEST_CASE("Springs that are no regular sheet have the same forces", "[spring_forces]") {
  const double damping_N_s_per_m = GENERATE(0.0, 0.3);
  const sim_server::UnkindHeap heap(GENERATE(0U, 16U, 32U, 48U));
  bodies::BodyDescription rope = sim_server::thread(11, {0, 0, 0}, {0.3, 0.1, 0}, 0.001, 200.0);
  sim_server::springs(rope).bend_stiffness_N_per_m = 20.0;
  bodies::BodyDescription block =
      sim_server::soft_block({3, 4, 3}, 0.02, 0.002, 400.0, {0.02, 0.009});
  sim_server::springs(rope).spring_damping_N_s_per_m =
      sim_server::springs(block).spring_damping_N_s_per_m = damping_N_s_per_m;
  CHECK(worst_difference(shaken(rope, 0.005)) < 1e-12);
  CHECK(worst_difference(shaken(block, 0.005)) < 1e-12);

  bodies::World uneven = shaken(cloth({6, 5}, damping_N_s_per_m), 0.005);
  uneven.springs[17].stiffness_N_per_m *= 1.5;
  CHECK(worst_difference(uneven) < 1e-12);
  uneven.springs[3].rest_length_m *= 0.9;
  CHECK(worst_difference(uneven) < 1e-12);
  uneven.springs.pop_back();
  uneven.bodies[0].spring_count -= 1;
  CHECK(worst_difference(uneven) < 1e-12);
}

TEST_CASE("Inner forces of a free body sum to nothing", "[spring_forces]") {
  const Eigen::Vector2i nodes = GENERATE(Eigen::Vector2i(6, 7), Eigen::Vector2i(13, 4));
  const bodies::World world = shaken(cloth(nodes, 0.2), 0.005);
  SpringForces springs(world);
  sim_server::on_every_target([&] {
    ExplicitState state = state_of(world);
    (void)springs.evaluate(world, state);
    Eigen::Vector3d sum_N = Eigen::Vector3d::Zero();
    double most_N = 0.0;
    for (const PackedVector& force_N : state.force_N) {
      sum_N += force_N.map();
      most_N = std::max(most_N, force_N.map().norm());
    }
    CHECK(sum_N.norm() < 1e-13 * most_N * static_cast<double>(world.nodes.size()));
  });
}

TEST_CASE("The power of dampers is the work of their forces", "[spring_forces]") {
  const bool regular = GENERATE(true, false);
  bodies::World world = shaken(cloth({9, 6}, 0.3), 0.005);
  if (!regular) world.bodies[0].sheet_nodes.setZero();
  ExplicitState damped = state_of(world);
  SpringForces springs(world);
  const double power_W = springs.evaluate(world, damped);
  for (bodies::Spring& spring : world.springs) spring.damping_N_s_per_m = 0.0;
  ExplicitState undamped = state_of(world);
  SpringForces without(world);
  CHECK(without.evaluate(world, undamped) == 0.0);
  double work_W = 0.0;
  for (std::size_t i = 0; i < world.nodes.size(); ++i)
    work_W +=
        (undamped.force_N[i].map() - damped.force_N[i].map()).dot(world.nodes[i].velocity_m_s);
  CHECK(power_W > 0.0);
  CHECK(power_W == Approx(work_W).epsilon(1e-12));
}

TEST_CASE("Forces of a body sleeping are left alone, others' are as they were", "[spring_forces]") {
  bodies::BodyDescription other = cloth({5, 4}, 0.1);
  other.position_m = {1.0, 0.0, 0.0};
  bodies::BodyDescription rope = sim_server::thread(6, {2, 0, 0}, {2, 1, 0}, 0.001, 200.0);
  bodies::World world = scene::build_world(sim_server::scene_of({cloth({5, 4}, 0.1), other, rope}));
  for (bodies::Node& node : world.nodes) node.position_m *= 1.01;
  ExplicitState awake = state_of(world);
  SpringForces springs(world);
  (void)springs.evaluate(world, awake);
  const int sleeper = GENERATE(0, 1, 2);
  world.bodies[static_cast<std::size_t>(sleeper)].is_sleeping = true;
  ExplicitState state = state_of(world);
  (void)springs.evaluate(world, state);
  for (const bodies::BodyRange& body : world.bodies)
    for (int i = body.first_node; i < body.first_node + body.node_count; ++i) {
      const auto node = static_cast<std::size_t>(i);
      const Eigen::Vector3d expected_N =
          body.is_sleeping ? Eigen::Vector3d(7, 7, 7) : Eigen::Vector3d(awake.force_N[node].map());
      CHECK(state.force_N[node].map() == expected_N);
    }
}

TEST_CASE("Nodes in one place are pushed nowhere", "[spring_forces]") {
  bodies::World world = scene::build_world(sim_server::scene_of({cloth({4, 4}, 0.1)}));
  for (bodies::Node& node : world.nodes) node.position_m.setZero();
  SpringForces springs(world);
  sim_server::on_every_target([&] {
    ExplicitState state = state_of(world);
    (void)springs.evaluate(world, state);
    for (const PackedVector& force_N : state.force_N) CHECK(force_N.map().norm() == 0.0);
  });
}

TEST_CASE("1 / length is exact to 1e-13 at every length, on every instruction set",
          "[spring_forces]") {
  constexpr int kSprings = 4096;
  constexpr double kRest_m = 0.01, kStiffness_N_per_m = 200.0;
  bodies::World world = scene::build_world(sim_server::scene_of(
      {sim_server::thread(2 * kSprings, {0, 0, 0}, {20, 0, 0}, 0.001, kStiffness_N_per_m)}));
  // One spring for every two nodes, of lengths over four octaves about its rest.
  world.springs.clear();
  std::vector<double> lengths_m;
  for (int i = 0; i < kSprings; ++i) {
    world.springs.push_back({2 * i, 2 * i + 1, kRest_m, kStiffness_N_per_m, 0.0});
    lengths_m.push_back(kRest_m * std::exp2(4.0 * i / kSprings - 2.0));
    world.nodes[static_cast<std::size_t>(2 * i)].position_m.setZero();
    world.nodes[static_cast<std::size_t>(2 * i + 1)].position_m = {lengths_m.back(), 0.0, 0.0};
  }
  world.bodies[0].first_spring = 0;
  world.bodies[0].spring_count = kSprings;
  SpringForces springs(world);
  sim_server::on_every_target([&] {
    ExplicitState state = state_of(world);
    (void)springs.evaluate(world, state);
    double worst = 0.0;
    for (std::size_t i = 0; i < lengths_m.size(); ++i) {
      // The force is k (length - rest length * unit), where the unit is length * (1 / length).
      const double unit = (lengths_m[i] - state.force_N[2 * i].x / kStiffness_N_per_m) / kRest_m;
      worst = std::max(worst, std::abs(unit - 1.0));
    }
    CHECK(worst < 1e-13);
  });
}

TEST_CASE("A spring longer than a float can square pulls by its length alone", "[spring_forces]") {
  bodies::World world = scene::build_world(
      sim_server::scene_of({sim_server::thread(2, {0, 0, 0}, {1, 0, 0}, 0.1, 1000.0)}));
  world.nodes[1].position_m.x() = 1e30;
  SpringForces springs(world);
  sim_server::on_every_target([&] {
    ExplicitState state = state_of(world);
    (void)springs.evaluate(world, state);
    CHECK(state.force_N[0].x == Approx(1e33));
  });
}

TEST_CASE("Rows of a sheet take the widest vector wherever the heap puts them, in copies too",
          "[spring_forces]") {
  const sim_server::UnkindHeap heap(GENERATE(0U, 16U, 32U, 48U));
  const auto check = [](SpringSheet& sheet) {
    const SheetRows rows(sheet);
    for (std::size_t row = 0; row < SheetRows::count(sheet.rows); ++row) {
      CHECK(contact::is_aligned_lanes(rows[row].at(0)));
      (void)rows[row].at(sheet.columns + 1);  // in assertion builds: with room for the widest
    }
  };
  for (int columns = 1; columns <= 18; ++columns) {
    const bodies::World world =
        scene::build_world(sim_server::scene_of({cloth({columns, 3}, 0.1)}));
    std::optional<SpringSheet> sheet = sheet_of(world, 0);
    REQUIRE(sheet);
    check(*sheet);
    SpringSheet copy = *sheet, assigned;
    check(copy);
    assigned = copy;
    check(assigned);
    std::vector<SpringSheet> grown;
    for (int i = 0; i < 5; ++i) grown.push_back(*sheet);
    grown.push_back(std::move(copy));
    for (SpringSheet& one : grown) check(one);
  }
}

TEST_CASE("Copies of springs and states pull to the bit as they do, on every instruction set",
          "[spring_forces]") {
  const sim_server::UnkindHeap heap(GENERATE(0U, 16U, 32U, 48U));
  const bool regular = GENERATE(true, false);
  bodies::World world = shaken(cloth({9, 6}, 0.3), 0.005);
  if (!regular) world.bodies[0].sheet_nodes.setZero();
  sim_server::on_every_target([&] {
    SpringForces springs(world);
    ExplicitState state = state_of(world), copied = state;
    SpringForces copied_springs = springs;
    const std::vector<double> between(3);  // what follows on the heap lies elsewhere
    ExplicitState moved = std::move(copied);
    SpringForces moved_springs = std::move(copied_springs);
    CHECK(springs.evaluate(world, state) == moved_springs.evaluate(world, moved));
    for (std::size_t i = 0; i < state.force_N.size(); ++i)
      CHECK(state.force_N[i].map() == moved.force_N[i].map());
  });
}

TEST_CASE("Nodes move by their forces alike on every instruction set", "[spring_forces]") {
  const sim_server::UnkindHeap heap(GENERATE(0U, 16U, 32U, 48U));
  const Move move{.kick_s = 0.003, .drift_s = 0.002};
  const Eigen::Vector3d gravity_m_s2(0.1, 0.2, -9.8);
  const bodies::World world = shaken(cloth({5, 3}, 0.1), 0.005);
  sim_server::on_every_target([&] {
    const ExplicitState before = state_of(world);
    ExplicitState state = before;
    move_nodes(move, gravity_m_s2, state);
    for (std::size_t i = 0; i < world.nodes.size(); ++i) {
      const Eigen::Vector3d x_m = before.position_m[i].map(), v_m_s = before.velocity_m_s[i].map();
      const double inverse_mass_per_kg = before.inverse_mass_per_kg[i];
      const Eigen::Vector3d faster_m_s =
          inverse_mass_per_kg == 0.0
              ? v_m_s
              : Eigen::Vector3d(v_m_s +
                                move.kick_s *
                                    (inverse_mass_per_kg * before.force_N[i].map() + gravity_m_s2));
      const Eigen::Vector3d drift_m = move.drift_s * faster_m_s;
      const Eigen::Vector3d farther_m =
          inverse_mass_per_kg == 0.0 ? x_m : Eigen::Vector3d(x_m + drift_m);
      CHECK((state.velocity_m_s[i].map() - faster_m_s).norm() <= 1e-15 * (1.0 + faster_m_s.norm()));
      CHECK((state.position_m[i].map() - farther_m).norm() <= 1e-15 * (1.0 + farther_m.norm()));
    }
  });
}

TEST_CASE("Nodes that are moved as their forces are known move to the bit as those moved after",
          "[spring_forces]") {
  const sim_server::UnkindHeap heap(GENERATE(0U, 16U, 32U, 48U));
  const double damping_N_s_per_m = GENERATE(0.0, 0.3);
  const Eigen::Vector2i nodes = GENERATE(Eigen::Vector2i(1, 7), Eigen::Vector2i(7, 1),
                                         Eigen::Vector2i(8, 2), Eigen::Vector2i(17, 9));
  const int regular = GENERATE(1, 0);
  const Move move{.kick_s = 3e-4, .drift_s = 2e-4};
  bodies::World world = shaken(cloth(nodes, damping_N_s_per_m), 0.005);
  world.bodies[0].sheet_nodes *= regular;
  sim_server::on_every_target([&] {
    SpringForces springs(world);
    ExplicitState state = state_of(world), moved = state;
    double power_W = 0.0, moved_power_W = 0.0;
    springs.take(world, moved);
    for (int substep = 0; substep < 3; ++substep) moved_power_W += springs.move(world, move, moved);
    springs.give(world, moved);
    for (int substep = 0; substep < 3; ++substep) {
      power_W += springs.evaluate(world, state);
      move_nodes({.kick_s = move.kick_s}, world.gravity_m_s2, state);
      move_nodes({.drift_s = move.drift_s}, world.gravity_m_s2, state);
    }
    CHECK(power_W == moved_power_W);
    for (std::size_t i = 0; i < world.nodes.size(); ++i) {
      CHECK(state.position_m[i].map() == moved.position_m[i].map());
      CHECK(state.velocity_m_s[i].map() == moved.velocity_m_s[i].map());
    }
  });
}

}  // namespace
}  // namespace stillgrid::dynamics::spring_forces_test
