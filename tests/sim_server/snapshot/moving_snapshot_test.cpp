#include "sim_server/snapshot/moving_snapshot.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "shared/collision/grid_query.hpp"
#include "shared/collision/sphere_history.hpp"
#include "sim_server/snapshot/sphere_records.hpp"
#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/sim_server/contact/sphere_clouds.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::snapshot::moving_snapshot_test {
namespace {

using contact::Cloud, contact::Drift, contact::DriftingCloud;

std::vector<proto::SphereState> states_of(std::span<const collision::SweptBound> balls) {
  std::vector<proto::SphereState> states;
  for (const collision::SweptBound& ball : balls) states.push_back({ball.centre_m, {}});
  return states;
}

/// Each sphere at a node of its own.
bodies::World world_of(std::span<const collision::SweptBound> balls) {
  bodies::World world;
  world.bodies.emplace_back().name = "cloud";
  for (const collision::SweptBound& ball : balls) {
    bodies::SphereBinding& sphere = world.spheres.emplace_back();
    sphere.radius_m = double{ball.bounding_radius_m};
    sphere.node_count = 1;
    sphere.nodes[0] = static_cast<int>(world.nodes.size());
    sphere.weights[0] = 1.0;
    world.nodes.emplace_back().position_m =
        Eigen::Map<const Eigen::Vector3f>(ball.centre_m.data()).cast<double>();
  }
  return world;
}

TEST_CASE("The published grid holds every sphere in all its snapshots", "[moving_snapshot]") {
  const auto drift = GENERATE(Drift::kSlow, Drift::kFast, Drift::kMixed, Drift::kTeleport);
  DriftingCloud spheres(GENERATE(Cloud::kEqual, Cloud::kTwoDecades), drift, 300, 9);
  MovingSnapshot snapshot(world_of(spheres.balls()), 0.0);
  for (int step = 0; step < 40; ++step) {
    spheres.step();
    snapshot.show(states_of(spheres.balls()));

    const collision::VoxelGrid& grid = snapshot.grid();
    REQUIRE(collision::is_consistent(grid.view().shape, grid.layout()));
    for (std::size_t i = 0; i < 300; ++i) {
      const proto::SphereRecord& record = grid.records()[i];
      const collision::SweptBound& swept_bound = grid.swept_bound(i);
      for (const proto::SphereState& state : {record.newest, record.before}) {
        const Eigen::Vector3d apart_m =
            Eigen::Map<const Eigen::Vector3f>(state.position_m.data()).cast<double>() -
            Eigen::Map<const Eigen::Vector3f>(swept_bound.centre_m.data()).cast<double>();
        if (!(apart_m.norm() + double{record.radius_m} <= double{swept_bound.bounding_radius_m}))
          FAIL("sphere " << i << " at step " << step);
      }
    }
    CHECK(grid.records()[0].newest.position_m == spheres.balls()[0].centre_m);
  }
}

TEST_CASE("Swept bounds are as narrow after a long way as at its start", "[moving_snapshot]") {
  DriftingCloud spheres(Cloud::kEqual, Drift::kNone, 100, 5);
  std::vector<proto::SphereState> states = states_of(spheres.balls());
  MovingSnapshot snapshot(world_of(spheres.balls()), 0.0);
  const float radius_m = spheres.balls()[0].bounding_radius_m;
  for (int step = 0; step < 1000; ++step) {
    for (proto::SphereState& state : states) state.position_m[0] += 0.1F * radius_m;
    snapshot.show(states);
    for (std::size_t i = 0; i < states.size(); ++i)
      REQUIRE(snapshot.grid().swept_bound(i).bounding_radius_m < 10.0F * radius_m);
  }
}

TEST_CASE("A query is not cut short because one sphere far from it was fast", "[moving_snapshot]") {
  constexpr std::size_t kCount = 20'000;
  constexpr std::uint32_t kMaxVisits = 8192;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<float> place(-0.4F, 0.4F);
  std::vector<collision::SweptBound> balls(kCount);
  for (collision::SweptBound& ball : balls)
    ball = {{place(random), place(random), place(random)}, 0.005F};
  balls[0].centre_m = {-1.5F, 0.0F, 0.0F};
  MovingSnapshot snapshot(world_of(balls), 0.0);
  const collision::SweptBound probe = collision::bound_sphere({0.1, 0.1, 0.1}, 0.01);
  for (int step = 0; step < 12; ++step) {
    snapshot.show(states_of(balls));
    CHECK_FALSE(collision::for_each_candidate(snapshot.grid().view(), probe, kMaxVisits,
                                              [](std::uint32_t) {}));
    if (step < 6) balls[0].centre_m[0] += 0.3F;  // then it stands still
    for (std::size_t i = 1; i < kCount; ++i) balls[i].centre_m[1] += 0.0002F;
  }
}

TEST_CASE("Nothing is allocated to show a snapshot", "[moving_snapshot]") {
  if (!devices::allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  DriftingCloud spheres(Cloud::kEqual, GENERATE(Drift::kSlow, Drift::kFast), 3000, 10);
  MovingSnapshot snapshot(world_of(spheres.balls()), 0.0);
  std::uint64_t allocated = 0;
  for (int step = 0; step < 200; ++step, spheres.step()) {
    const std::vector<proto::SphereState> states = states_of(spheres.balls());
    const std::uint64_t before = *devices::allocation_count();
    snapshot.show(states);
    if (step >= 100) allocated += *devices::allocation_count() - before;
  }
  CHECK(allocated == 0);
}

TEST_CASE("A sphere whose place is no number is refused by its body and its number there",
          "[moving_snapshot]") {
  DriftingCloud spheres(Cloud::kEqual, Drift::kNone, 20, 11);
  bodies::World world = world_of(spheres.balls());
  MovingSnapshot snapshot(world, 0.0);
  world.nodes[17].position_m.y() = GENERATE(std::numeric_limits<double>::quiet_NaN(), 1e60);
  CHECK_THROWS_WITH(snapshot.show(world), Catch::Contains("body 'cloud': sphere 17: position"));
}

TEST_CASE("The records of static spheres follow the world's order", "[moving_snapshot]") {
  std::vector<bodies::BodyDescription> bodies;
  for (int i = 0; i < 20; ++i) {
    bodies.push_back(sim_server::sphere({0.017 * i, -0.03 * i, 0.2}, 0.01, 0.1));
    if (i % 3 == 0) bodies.back().motion = bodies::Motion::kStatic;
  }
  const bodies::World world =
      scene::build_world(sim_server::scene_of(bodies, sim_server::material_of(100.0)));
  const auto records = static_records(world);

  REQUIRE(records.size() == 7);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Eigen::Vector3f p(records[i].newest.position_m.data());
    CHECK((p.cast<double>() - world.static_spheres[i].position_m).norm() < 1e-7);
    CHECK(records[i].before.position_m == records[i].newest.position_m);
    CHECK(records[i].body == static_cast<std::uint32_t>(world.static_spheres[i].body));
    CHECK(records[i].radius_m == 0.01F);
  }
}

}  // namespace
}  // namespace stillgrid::snapshot::moving_snapshot_test
