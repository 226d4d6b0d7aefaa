#include "sim_server/dynamics/workers/workers.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <random>
#include <thread>
#include <vector>

#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::workers_test {
namespace {

using Eigen::Vector3d;

/// Spheres that fall onto each other, beside a cloth that some fall onto and pairs by themselves:
/// one large island with nodes, and small ones.
scene::SceneDescription crowd() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off_m(-2e-4, 2e-4);
  std::vector<bodies::BodyDescription> bodies;
  bodies.push_back(sim_server::body_of(bodies::PlaneBody{Vector3d::UnitZ()}, 1.0, {0, 0, -0.004}));
  bodies.back().motion = bodies::Motion::kStatic;
  bodies.push_back(sim_server::sheet({20, 20}, 0.01, 1e-4, 100.0));
  sim_server::packing(bodies.back()).radius_m = 0.003;
  for (int i = 0; i < 12 * 12 * 40; ++i) {
    const int row = i / 12 % 12, layer = i / 144 + 1;
    bodies.push_back(sim_server::sphere(0.0101 * Vector3d(i % 12, row, layer) +
                                            Vector3d(off_m(random), off_m(random), off_m(random)),
                                        0.005, 0.002));
  }
  for (int i = 0; i < 40; ++i)
    for (int k = 0; k < 2; ++k)
      bodies.push_back(sim_server::sphere({1.0 + 0.03 * i, 0.0, 0.0098 * k}, 0.005, 0.002));
  scene::SceneDescription scene = sim_server::scene_of(
      std::move(bodies), sim_server::material_of(2000.0, 1.0, 0.4), {0.0, 0.3, -9.81});
  scene.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  return scene;
}

void add_bytes(const Vector3d& value, std::vector<unsigned char>& bytes) {
  const auto* first = reinterpret_cast<const unsigned char*>(value.data());
  bytes.insert(bytes.end(), first, first + 3 * sizeof(double));
}

/// Everything that moved, and what the account says of it; how many contacts there were at most.
struct Run {
  std::vector<unsigned char> bytes;
  int contacts = 0;
};

Run run_by(int threads) {
  const Workers workers(threads);
  Simulation simulation(crowd());
  simulation.share_work(workers);
  simulation.account_energy();
  Run run;
  for (int i = 0; i < 12; ++i) {
    const StepReport report = simulation.step(0.005, [] { return std::nullopt; });
    run.contacts = std::max(run.contacts, report.contacts);
  }
  for (const bodies::RigidBody& body : simulation.world().rigid_bodies) {
    add_bytes(body.position_m, run.bytes);
    add_bytes(body.velocity_m_s, run.bytes);
    add_bytes(body.angular_velocity_rad_s, run.bytes);
  }
  for (const bodies::Node& node : simulation.world().nodes) {
    add_bytes(node.position_m, run.bytes);
    add_bytes(node.velocity_m_s, run.bytes);
  }
  const EnergyFlow flow = simulation.energy_account()->flow;
  add_bytes({flow.friction_J, flow.contact_damping_J, flow.unsolved_J}, run.bytes);
  return run;
}

TEST_CASE("Every chunk is done once, by as many threads as there are", "[workers]") {
  for (const int threads : {1, 2, 3, 8}) {
    const Workers workers(threads);
    for (const std::size_t count : {0ul, 1ul, 7ul, 8ul, 9ul, 1000ul}) {
      std::vector<std::atomic<int>> done(count);
      workers.for_each_chunk(count, 8, [&](std::size_t first, std::size_t last) {
        if (first % 8 != 0 || last > count || last - first > 8) return;  // missed below
        for (std::size_t i = first; i < last; ++i) ++done[i];
      });
      for (const std::atomic<int>& times : done) CHECK(times == 1);
    }
  }
}

TEST_CASE("Threads really share: two wait for each other in one call", "[workers]") {
  const Workers workers(2);
  std::atomic<int> here = 0;
  workers.for_each_chunk(2, 1, [&](std::size_t, std::size_t) {
    ++here;
    while (here < 2) std::this_thread::yield();
  });
  CHECK(here == 2);
}

TEST_CASE("A large scene moves by the same bytes whoever shares its work", "[workers]") {
  const Run alone = run_by(1);
  REQUIRE(alone.contacts > 4500);  // or balls would not be solved in parts
  for (const int threads : {2, 8}) {
    const bool is_same = run_by(threads).bytes == alone.bytes;
    CHECK(is_same);
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::workers_test
