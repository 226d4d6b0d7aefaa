#include "sim_server/dynamics/choice/memory_need.hpp"

#include <malloc.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::memory_need_test {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
const scene::Method kExplicit{.integrator = scene::IntegratorKind::kVelocityVerlet};

double private_bytes(int side, const scene::Method& method) {
  return memory_need(sim_server::sheet({side, side}, 0.01, 1e-4, 100.0), method).private_bytes;
}

std::string refusal_of(const scene::SceneDescription& scene, const Memory& available) {
  try {
    require_room(scene, "a.toml", available);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("Memory grows with a sheet's nodes", "[memory_need]") {
  for (const scene::Method& method : {kExplicit, scene::Method{}})
    CHECK(private_bytes(400, method) == Approx(16.0 * private_bytes(100, method)).epsilon(0.01));
  CHECK(private_bytes(100, {}) > private_bytes(100, kExplicit));
}

TEST_CASE("What is reckoned is what a world takes at least", "[memory_need]") {
  const bodies::BodyDescription body = sim_server::sheet({60, 60}, 0.01, 1e-4, 100.0);
  const bodies::World world = scene::build_world(sim_server::scene_of({body}));
  const auto bytes = static_cast<double>(world.nodes.size() * sizeof(bodies::Node) +
                                         world.springs.size() * sizeof(bodies::Spring) +
                                         world.spheres.size() * sizeof(bodies::SphereBinding));
  CHECK(memory_need(body, kExplicit).private_bytes > bytes);
  CHECK(memory_need(body, kExplicit).private_bytes < 10.0 * bytes);
}

TEST_CASE("What is reckoned is what a pile takes at most", "[memory_need]") {
  if (tests::kIsSanitized) return;  // with an allocator of its own
  std::vector<bodies::BodyDescription> bodies;
  for (int i = 0; i < 10 * 10 * 20; ++i)
    bodies.push_back(sim_server::sphere(
        0.0101 * Eigen::Vector3d(i % 10 + 0.01 * (i / 7 % 5), i / 10 % 10, i / 100), 0.005, 0.001));
  const auto wall = [&](const Eigen::Vector3d& normal, double from_m) {
    bodies.push_back(
        sim_server::body_of(bodies::PlaneBody{normal}, 1.0, Eigen::Vector3d(from_m * normal)));
    bodies.back().motion = bodies::Motion::kStatic;
  };
  wall({0.0, 0.0, 1.0}, -0.0052);
  for (const Eigen::Vector3d& normal :
       {Eigen::Vector3d(1.0, 0.0, 0.0), Eigen::Vector3d(0.0, 1.0, 0.0)}) {
    wall(normal, -0.0052);
    wall(-normal, -0.0965);
  }
  scene::SceneDescription scene =
      sim_server::scene_of(bodies, sim_server::material_of(2000.0, 1.0, 0.5), {0.0, 0.0, -9.81});
  scene.method = kExplicit;
  double reckoned = 0.0;
  for (const bodies::BodyDescription& body : bodies)
    reckoned += memory_need(body, kExplicit).private_bytes;
  const auto allocated = [] { return mallinfo2().uordblks + mallinfo2().hblkhd; };
  const std::size_t before = allocated();
  Simulation simulation(scene);
  int contacts = 0;
  for (int i = 0; i < 15; ++i)
    contacts = std::max(contacts, simulation.step(0.01, [] { return std::nullopt; }).contacts);
  CHECK(contacts > 3000);
  const auto taken = static_cast<double>(allocated() - before);
  CHECK(taken < reckoned);
  CHECK(taken > 0.3 * reckoned);
}

TEST_CASE("A scene that does not fit is refused at the body that takes most", "[memory_need]") {
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::sphere({0, 0, 0}, 0.01, 1.0), sim_server::sheet({900, 900}, 0.01, 1e-4, 100.0)});
  scene.bodies[0].line = 7;
  scene.bodies[1].line = 12;
  scene.bodies[1].name = "cloth";
  const double explicit_bytes = 1.1 * private_bytes(900, kExplicit);
  const std::string refusal = refusal_of(scene, {explicit_bytes, kUnlimited});
  CHECK(refusal.find("a.toml:12: body 'cloth': memory: value ") == 0);
  CHECK(refusal.find("GB, what this machine has left") != std::string::npos);
  CHECK(refusal.find('\n') == std::string::npos);

  scene.method = kExplicit;
  CHECK(refusal_of(scene, {explicit_bytes, kUnlimited}).empty());
  CHECK(refusal_of(scene, {explicit_bytes, 64e6})
            .find("expected at most 64 MB, what /dev/shm has left") != std::string::npos);
}

TEST_CASE("A scene of more than a million spheres is refused, whatever there is", "[memory_need]") {
  scene::SceneDescription scene =
      sim_server::scene_of({sim_server::box({0, 0, 0}, {1.0, 1.0, 1e-6}, 1.0, {1e-9, 1e-9}),
                            sim_server::sphere({0, 0, 1}, 0.01, 1.0)});
  scene.bodies[0].line = 3;
  scene.bodies[0].name = "plate";
  CHECK(
      refusal_of(scene, {kUnlimited, kUnlimited}).find("a.toml:3: body 'plate': spheres: value ") ==
      0);
}

}  // namespace
}  // namespace stillgrid::dynamics::memory_need_test
