
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "tests/sim_server/contact/all_contacts.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::contact::detection_test {
namespace {

constexpr double kStep_s = 0.03;
using Pairs = std::multiset<std::pair<int, int>>;

/// Moving and still balls, nodes of a thread and a plane, some crowded and some far away.
bodies::World random_world(unsigned seed, int balls) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.2, 0.2), radius(0.005, 0.02), speed(-2.0, 2.0);
  std::vector<bodies::BodyDescription> bodies;
  for (int i = 0; i < balls; ++i) {
    const double far = i % 10 == 0 ? 50.0 : 1.0, size = i % 17 == 0 ? 12.0 : 1.0;
    const Eigen::Vector3d position_m(far * place(random), place(random), place(random));
    bodies.push_back(sim_server::moving(sim_server::sphere(position_m, size * radius(random), 0.1),
                                        {speed(random), speed(random), speed(random)}));
    if (i % 4 == 0) bodies.back().motion = bodies::Motion::kStatic;
    if (i % 7 == 1) {
      bodies.back().motion = bodies::Motion::kPrescribed;
      bodies.back().prescribed = {.velocity_m_s = speed(random) * Eigen::Vector3d::UnitX()};
    }
  }
  bodies.push_back(sim_server::thread(20, {-0.2, 0, 0}, {0.2, 0.1, 0}, 0.01, 10.0));
  bodies.push_back(sim_server::floor_at(-0.15));
  return scene::build_world(
      sim_server::scene_of(bodies, sim_server::material_of(100.0), {0, 0, -9.81}));
}

bool is_free(const bodies::World& world, const bodies::SphereBinding& sphere) {
  return sphere.rigid < 0 ||
         world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)].unknown != bodies::kNoUnknown;
}

/// Least distance of two points that move steadily for a step.
double nearest_m(const bodies::SphereMotion& a, const bodies::SphereMotion& b) {
  const Eigen::Vector3d from_m = a.position_m - b.position_m;
  const Eigen::Vector3d move_m = kStep_s * (a.velocity_m_s - b.velocity_m_s);
  const double t =
      std::clamp(-from_m.dot(move_m) / std::max(move_m.squaredNorm(), 1e-30), 0.0, 1.0);
  return (from_m + t * move_m).norm();
}

/// Whether the balls round two paths of a step, of spheres grown by a tenth and a little, meet.
bool paths_meet(const bodies::World& world, const bodies::SphereBinding& a,
                const bodies::SphereBinding& b) {
  const auto path_of = [&](const bodies::SphereBinding& sphere) {
    const bodies::SphereMotion motion = bodies::sphere_motion(world, sphere);
    const Eigen::Vector3d end_m = motion.position_m + kStep_s * motion.velocity_m_s;
    const Eigen::Vector3d fallen_m =
        end_m + (is_free(world, sphere) ? 1.0 : 0.0) * kStep_s * kStep_s * world.gravity_m_s2;
    const double length_m =
        std::max({(end_m - motion.position_m).norm(), (fallen_m - motion.position_m).norm(),
                  (fallen_m - end_m).norm()});
    return std::pair(motion.position_m, length_m + 1.1 * sphere.radius_m);
  };
  const auto [from_a_m, bounding_radius_a_m] = path_of(a);
  const auto [from_b_m, bounding_radius_b_m] = path_of(b);
  return (from_a_m - from_b_m).norm() <= bounding_radius_a_m + bounding_radius_b_m + 1e-5;
}

Pairs found_pairs(const std::vector<Contact>& contacts) {
  Pairs pairs;
  for (const Contact& contact : contacts)
    if (contact.b >= 0) pairs.insert(std::minmax(contact.a, contact.b));
  return pairs;
}

TEST_CASE("Every pair of moving spheres that may touch within the step is found, once",
          "[detection]") {
  const bodies::World world = random_world(GENERATE(1U, 2U, 3U, 4U, 5U), GENERATE(5, 60, 300));
  const std::vector<Contact> contacts = contacts_within(world, kStep_s);
  const Pairs found = found_pairs(contacts);
  const SelfCollision self_collision(world);

  int touching = 0;
  for (int i = 0; i < static_cast<int>(world.spheres.size()); ++i)
    for (int j = i + 1; j < static_cast<int>(world.spheres.size()); ++j) {
      const bodies::SphereBinding& a = world.spheres[static_cast<std::size_t>(i)];
      const bodies::SphereBinding& b = world.spheres[static_cast<std::size_t>(j)];
      const bodies::SphereMotion motion_a = bodies::sphere_motion(world, a),
                                 motion_b = bodies::sphere_motion(world, b);
      const bool may = self_collision.may_collide(a, b) && (is_free(world, a) || is_free(world, b));
      const bool touch = nearest_m(motion_a, motion_b) < a.radius_m + b.radius_m;
      touching += may && touch;
      const auto times = found.count({i, j});
      if (may && touch && times != 1) FAIL_CHECK("missed or repeated: " << i << ", " << j);
      const bool meet = paths_meet(world, a, b);
      if (times != 0 && !(may && meet)) FAIL_CHECK("needless: " << i << ", " << j);
    }
  CHECK(found.size() >= static_cast<std::size_t>(touching));
}

TEST_CASE("Every static sphere and plane that may be touched within the step is found, once",
          "[detection]") {
  const bodies::World world = random_world(GENERATE(11U, 12U, 13U), GENERATE(60, 300));
  const std::vector<Contact> contacts = contacts_within(world, kStep_s);

  for (int i = 0; i < static_cast<int>(world.spheres.size()); ++i) {
    const bodies::SphereBinding& a = world.spheres[static_cast<std::size_t>(i)];
    const bodies::SphereMotion motion = bodies::sphere_motion(world, a);
    const auto count_where = [&](auto&& is_it) {
      return std::count_if(contacts.begin(), contacts.end(),
                           [&](const Contact& c) { return c.a == i && c.b < 0 && is_it(c); });
    };
    for (const bodies::StaticSphere& b : world.static_spheres) {
      const auto times = count_where(
          [&](const Contact& c) { return !c.is_plane && c.position_b_m == b.position_m; });
      const bool touch =
          nearest_m(motion, {b.position_m, Eigen::Vector3d::Zero()}) < a.radius_m + b.radius_m;
      if (times > 1 || (is_free(world, a) && touch && times == 0)) FAIL_CHECK("sphere " << i);
      if (times > 0 && !is_free(world, a)) FAIL_CHECK("prescribed " << i);
    }
    const double lowest_m =
        motion.position_m.z() + std::min(0.0, kStep_s * motion.velocity_m_s.z()) - a.radius_m;
    const auto times = count_where([](const Contact& c) { return c.is_plane; });
    if (times > 1 || (is_free(world, a) && lowest_m < -0.15 && times == 0))
      FAIL_CHECK("plane " << i);
    if (times > 0 && lowest_m > -0.15 + 0.1 * a.radius_m + 0.01) FAIL_CHECK("far plane " << i);
  }
}

TEST_CASE("A contact knows how deep it was when the step began", "[detection]") {
  const bodies::World world = random_world(21, 100);
  const std::vector<Contact> contacts = contacts_within(world, kStep_s);
  REQUIRE_FALSE(contacts.empty());

  for (const Contact& contact : contacts) {
    const auto centre_m = [&](int i) {
      return bodies::sphere_motion(world, world.spheres[static_cast<std::size_t>(i)]).position_m;
    };
    const Eigen::Vector3d a_m = centre_m(contact.a);
    const double gap_m =
        contact.is_plane
            ? contact.plane_normal.dot(a_m) - contact.plane_offset_m
            : (a_m - (contact.b >= 0 ? centre_m(contact.b) : contact.position_b_m)).norm();
    CHECK(contact.depth_before_m ==
          Approx(contact.radius_a_m + contact.radius_b_m - gap_m).margin(1e-15));
    CHECK(contact.material.stiffness_N_per_m == 100.0);
  }
}

TEST_CASE("Neighbours on a deformable body do not collide, distant parts of it do", "[detection]") {
  // A strip folded so that its far end lies on its beginning.
  bodies::BodyDescription strip = sim_server::sheet({21, 2}, 0.02, 0.002, 500.0);
  bodies::World world =
      scene::build_world(sim_server::scene_of({strip}, sim_server::material_of(100.0)));
  for (bodies::Node& node : world.nodes)
    if (node.position_m.x() > 0.0) {
      node.position_m.x() *= -1.0;
      node.position_m.z() = 0.01;
    }
  const std::vector<Contact> contacts = contacts_within(world, kStep_s);

  const double near_m = 2.5 * world.spheres[0].radius_m;
  CHECK_FALSE(contacts.empty());
  for (const Contact& contact : contacts) {
    const bodies::SphereBinding& a = world.spheres[static_cast<std::size_t>(contact.a)];
    const bodies::SphereBinding& b = world.spheres[static_cast<std::size_t>(contact.b)];
    CHECK((a.rest_position_m - b.rest_position_m).norm() > near_m);
  }
  const auto ends = found_pairs(contacts);
  CHECK(ends.count({0, 20}) == 1);  // the corners that the fold brings together
}

TEST_CASE("A flat sheet does not touch itself, a rigid body never does", "[detection]") {
  bodies::BodyDescription cloth = sim_server::sheet({8, 8}, 0.02, 0.002, 500.0);
  sim_server::packing(cloth) = {0.01, 0.0065};
  const bodies::World world = scene::build_world(sim_server::scene_of(
      {cloth,
       sim_server::moving(sim_server::box({0, 0, 1}, {0.03, 0.03, 0.02}, 0.02, {0.005, 0.005}),
                          {0, 0, 0}, {100, 0, 0})},
      sim_server::material_of(100.0)));
  const std::vector<Contact> contacts = contacts_within(world, kStep_s);

  CHECK(std::none_of(contacts.begin(), contacts.end(),
                     [](const Contact& contact) { return contact.depth_before_m > 0.0; }));
  for (const auto& [i, j] : found_pairs(contacts))
    CHECK(world.spheres[static_cast<std::size_t>(i)].rigid < 0);
}

}  // namespace
/// A cube of n x n x n spheres that fills 5 cm, its centre at x_m, along x at speed_m_s.
bodies::BodyDescription cube_of(int n, double x_m, double speed_m_s) {
  const double spacing_m = 0.05 / n;
  return sim_server::moving(
      sim_server::box({x_m, 0, 0}, {0.05, 0.05, 0.05}, 0.1, {spacing_m, 0.5 * spacing_m}),
      {speed_m_s, 0, 0});
}

TEST_CASE("However fast a rigid body moves, its spheres are no pairs", "[detection]") {
  const int n = GENERATE(6, 12, 24);
  const double speed_m_s = GENERATE(0.0, 2.0, 20.0);
  const bodies::World world = scene::build_world(
      sim_server::scene_of({cube_of(n, 0.0, speed_m_s)}, sim_server::material_of(100.0)));
  REQUIRE(world.spheres.size() == static_cast<std::size_t>(n * n * n));
  CHECK(contacts_within(world, kStep_s).empty());
}

TEST_CASE("Two fast cubes of many spheres that meet have all contacts between them",
          "[detection]") {
  const double speed_m_s = GENERATE(0.1, 0.5);
  const bodies::World world = scene::build_world(sim_server::scene_of(
      {cube_of(9, 0.0, speed_m_s), cube_of(9, 0.052, -speed_m_s)}, sim_server::material_of(100.0)));
  const std::vector<Contact> contacts = contacts_within(world, kStep_s);
  Pairs expected;
  const int half = static_cast<int>(world.spheres.size() / 2);
  for (int i = 0; i < half; ++i)
    for (int j = half; j < 2 * half; ++j) {
      const auto at = [&](int k) -> const bodies::SphereBinding& {
        return world.spheres[static_cast<std::size_t>(k)];
      };
      if (nearest_m(bodies::sphere_motion(world, at(i)), bodies::sphere_motion(world, at(j))) <
          at(i).radius_m + at(j).radius_m)
        expected.insert({i, j});
    }
  REQUIRE(expected.size() > 80);
  const Pairs found = found_pairs(contacts);
  CHECK(std::includes(found.begin(), found.end(), expected.begin(), expected.end()));
}

TEST_CASE("A swing that turns within the step is bounded by its turning point", "[detection]") {
  // At its turn it has no velocity, and before it one that leads beyond.
  const double phase = GENERATE(0.18, 0.2, 0.22, 0.24, 0.25, 0.7);
  bodies::BodyDescription hammer = sim_server::sphere({0, 0, 0}, 0.009, 0.0);
  hammer.motion = bodies::Motion::kPrescribed;
  hammer.prescribed = {
      .direction = Eigen::Vector3d::UnitX(), .amplitude_m = 0.1, .frequency_hz = 5.0};
  std::vector<bodies::BodyDescription> bodies{hammer};
  for (int i = -12; i <= 12; ++i)
    bodies.push_back(sim_server::sphere({0.01 * i, 0.012, 0}, 0.004, 0.02));
  bodies::World world = scene::build_world(sim_server::scene_of(bodies));
  world.time_s = phase / 5.0;
  const auto place_at = [&](double time_s) {
    return bodies::prescribed_state(world.rigid_bodies[0], time_s);
  };
  world.rigid_bodies[0].position_m = place_at(world.time_s).position_m;
  world.rigid_bodies[0].velocity_m_s = place_at(world.time_s).velocity_m_s;
  const std::vector<Contact> contacts = contacts_within(world, kStep_s);
  const Pairs found = found_pairs(contacts);
  for (int i = 1; i <= 25; ++i) {
    double nearest_m = 1.0;
    for (int k = 0; k <= 300; ++k) {
      const Eigen::Vector3d hammer_m = place_at(world.time_s + kStep_s * k / 300.0).position_m;
      nearest_m =
          std::min(nearest_m,
                   (hammer_m - world.rigid_bodies[static_cast<std::size_t>(i)].position_m).norm());
    }
    if (nearest_m < 0.013) CHECK(found.count({0, i}) == 1);
  }
  CHECK(found.size() < 20);
}

}  // namespace stillgrid::contact::detection_test
