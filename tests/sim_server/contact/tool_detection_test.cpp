#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "sim_server/snapshot/sphere_records.hpp"
#include "tests/sim_server/contact/all_contacts.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::contact::tool_detection_test {
namespace {

constexpr double kStep_s = 0.03;

bodies::World crowd(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.1, 0.1);
  std::vector<bodies::BodyDescription> bodies;
  for (int i = 0; i < 200; ++i)
    bodies.push_back(sim_server::sphere({place(random), place(random), place(random)}, 0.01, 0.1));
  for (std::size_t i = 0; i < bodies.size(); i += 5) bodies[i].motion = bodies::Motion::kStatic;
  for (std::size_t i = 1; i < bodies.size(); i += 5) {
    bodies[i].motion = bodies::Motion::kPrescribed;
    bodies[i].prescribed.velocity_m_s.setZero();
  }
  return scene::build_world(sim_server::scene_of(bodies, sim_server::material_of(100.0)));
}

std::vector<ToolSphereMotion> tool_at(const Eigen::Vector3d& position_m) {
  return {{position_m, {0.1, 0.2, 0.3}, position_m - Eigen::Vector3d(0.003, 0, 0), 0.02},
          {position_m + Eigen::Vector3d(0, 0.05, 0), {0, 0, 0}, position_m, 0.015}};
}

TEST_CASE("The tool meets every free sphere that it touches, once, and nothing else",
          "[detection]") {
  const bodies::World world = crowd(GENERATE(1U, 2U, 3U));
  const auto tool = tool_at({0.01, -0.02, 0.03});
  std::vector<Contact> found = contacts_within(world, kStep_s, tool);
  std::erase_if(found, [](const Contact& contact) { return !contact.is_tool; });

  for (const ToolSphereMotion& b : tool)
    for (std::size_t i = 0; i < world.spheres.size(); ++i) {
      const bodies::SphereBinding& a = world.spheres[i];
      const bool is_free =
          world.rigid_bodies[static_cast<std::size_t>(a.rigid)].unknown != bodies::kNoUnknown;
      const Eigen::Vector3d apart_m = bodies::sphere_motion(world, a).position_m - b.position_m;
      const auto times = std::count_if(found.begin(), found.end(), [&](const Contact& c) {
        return c.a == static_cast<int>(i) && c.position_b_m == b.position_m;
      });
      if (is_free && apart_m.norm() < a.radius_m + b.radius_m) CHECK(times == 1);
      CHECK(times <= (is_free ? 1 : 0));
    }
  for (const Contact& contact : found) {
    CHECK(contact.b == -1);
    CHECK_FALSE(contact.is_plane);
  }
}

TEST_CASE("A contact with the tool has the touched body's material and the tool's motion",
          "[detection]") {
  // Below the tool's slip speed friction is viscous, unless the material says so from a higher one.
  const double slip_speed_m_s = GENERATE(1e-3, 0.2);
  const scene::SceneDescription scene =
      sim_server::scene_of({sim_server::sphere({0, 0, 0}, 0.01, 0.1)},
                           sim_server::material_of(123.0, 4.0, 0.5, slip_speed_m_s));
  const bodies::World world = scene::build_world(scene);
  const ToolSphereMotion sphere{.position_m = {0, 0, 0.02},
                                .velocity_m_s = {0, 0, -1},
                                .position_before_m = {0, 0, 0.05},
                                .radius_m = 0.015,
                                .slip_speed_m_s = 0.04,
                                .hand = 2};
  const std::vector<Contact> contacts = contacts_within(world, kStep_s, {sphere});

  REQUIRE(contacts.size() == 1);
  const Contact& contact = contacts[0];
  CHECK(contact.material.stiffness_N_per_m == 123.0);
  CHECK(contact.material.damping_N_s_per_m == 4.0);
  CHECK(contact.material.friction == 0.5);
  CHECK(contact.material.slip_speed_m_s == std::max(slip_speed_m_s, 0.04));
  CHECK(contact.velocity_b_m_s == Eigen::Vector3d(0, 0, -1));
  CHECK(contact.radius_b_m == 0.015);
  CHECK(contact.hand == 2);
  CHECK(contact.depth_before_m == Approx(0.025 - 0.05));  // from where the tool was a step ago
}

TEST_CASE("The records of static spheres follow the world's order", "[detection]") {
  const bodies::World world = crowd(5);
  const auto records = snapshot::static_records(world);

  REQUIRE(records.size() == world.static_spheres.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Eigen::Vector3f p(records[i].newest.position_m.data());
    CHECK((p.cast<double>() - world.static_spheres[i].position_m).norm() < 1e-8);
    CHECK(records[i].oldest_position_m == records[i].newest.position_m);
    CHECK(records[i].body == static_cast<std::uint32_t>(world.static_spheres[i].body));
    CHECK(records[i].radius_m == 0.01F);
  }
}

}  // namespace
}  // namespace stillgrid::contact::tool_detection_test
