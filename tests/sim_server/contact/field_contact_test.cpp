#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "sim_server/contact/field_touch.hpp"
#include "tests/sim_server/contact/all_contacts.hpp"
#include "tests/sim_server/field_worlds.hpp"

namespace stillgrid::contact::field_contact_test {
namespace {

using Eigen::Vector3d;

const Vector3d kSize_m(0.061, 0.047, 0.033);

struct Draw {
  std::mt19937 random;
  explicit Draw(unsigned seed) : random(seed) {}
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  Vector3d vector(double most) {
    return {number(-most, most), number(-most, most), number(-most, most)};
  }
  Eigen::Quaterniond turn() {
    return Eigen::Quaterniond(number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1))
        .normalized();
  }
};

TEST_CASE("The tangent sphere overlaps a sphere as deep as the solid does, along its normal",
          "[field]") {
  Draw draw(GENERATE(1U, 2U, 3U));
  bodies::World world;
  sim_server::add_static_field(world, sim_server::ball_field(0.031, 0.001, 0.012), draw.vector(0.2),
                               draw.turn());
  const bodies::FieldBody& field = world.fields[0];
  const FieldPose pose = pose_of(field, {});
  for (int i = 0; i < 200; ++i) {
    const double radius_m = draw.number(0.001, 0.011);
    const Vector3d away = draw.vector(1.0).normalized();
    const double far_m = draw.number(0.02, 0.04);
    const Vector3d centre_m = field.position_m + far_m * away;

    const FieldTouch touch = touch_of(field, pose, centre_m, radius_m);

    CHECK(touch.depth_m == Approx(0.031 + radius_m - far_m).margin(2e-5));
    CHECK((touch.normal - away).norm() < 0.01);
    CHECK(touch.stiffness_scale == Approx(1.0).epsilon(0.01));
    const double overlap_m =
        radius_m + tangent_radius_m(field) - (centre_m - touch.centre_m).norm();
    CHECK(overlap_m == Approx(touch.depth_m).margin(1e-12));
    CHECK(((centre_m - touch.centre_m).normalized() - touch.normal).norm() < 1e-9);
  }
}

TEST_CASE("A sphere off a field's bricks is apart from it by no more than it is", "[field]") {
  Draw draw(GENERATE(4U, 5U));
  bodies::World world;
  sim_server::add_static_field(world, sim_server::box_field(kSize_m, 0.0021, 0.012),
                               draw.vector(0.2), draw.turn());
  const bodies::FieldBody& field = world.fields[0];
  const FieldPose pose = pose_of(field, {});
  for (int i = 0; i < 200; ++i) {
    const Vector3d centre_m = field.position_m + draw.vector(0.4);
    const double truth_m = sim_server::box_distance_m(kSize_m, pose.into(centre_m));
    const double radius_m = draw.number(0.0, 0.01);
    if (truth_m < 0.05) continue;
    const FieldTouch touch = touch_of(field, pose, centre_m, radius_m);
    CHECK(touch.depth_m < 0.0);
    CHECK(-touch.depth_m < truth_m);
  }
}

/// Balls and bodies of fields, free and static, that fly about; a tool among them.
struct Crowd {
  bodies::World world;
  std::vector<ToolSphereMotion> tool;
};
Crowd crowd(unsigned seed, double step_s) {
  Draw draw(seed);
  std::vector<bodies::BodyDescription> bodies;
  for (int i = 0; i < 3; ++i) {
    bodies.push_back(
        sim_server::moving(sim_server::points_body(sim_server::box_points(kSize_m, 4, 0.0011),
                                                   kSize_m, 0.1, draw.vector(0.08)),
                           draw.vector(0.6), draw.vector(6.0)));
    bodies.back().orientation = draw.turn();
  }
  for (int i = 0; i < 25; ++i)
    bodies.push_back(sim_server::moving(
        sim_server::sphere(draw.vector(0.09), draw.number(0.002, 0.011), 0.01), draw.vector(2.0)));
  for (int i = 0; i < 5; ++i) {
    bodies.push_back(sim_server::sphere(draw.vector(0.09), 0.009, 0.0));
    bodies.back().motion = bodies::Motion::kStatic;
  }
  Crowd crowd{scene::build_world(
                  sim_server::scene_of(bodies, sim_server::material_of(500.0), {0, 0, -9.81})),
              {}};
  for (const int i : {0, 1, 2})
    sim_server::meet_by_field(crowd.world, i, sim_server::box_field(kSize_m, 0.0021, 0.012));
  sim_server::add_static_field(crowd.world, sim_server::ball_field(0.031, 0.0021, 0.012),
                               draw.vector(0.1), draw.turn());
  const Vector3d at_m = draw.vector(0.05), move_m = draw.vector(0.03);
  crowd.tool = {{at_m + move_m, move_m / step_s, at_m, 0.007}};
  return crowd;
}

/// Every pair (who is met, the field) that overlaps at some moment of the way.
using Pairs = std::set<std::pair<int, int>>;
constexpr int kTool = -2, kStatic = -100;  // and their numbers

Pairs overlapping(const Crowd& crowd, double step_s) {
  Pairs pairs;
  const bodies::World& world = crowd.world;
  constexpr int kMoments = 40;
  for (int moment = 0; moment <= kMoments; ++moment) {
    const double share = double{1.0} * moment / kMoments, time_s = share * step_s;
    for (std::size_t f = 0; f < world.fields.size(); ++f) {
      const bodies::FieldBody& field = world.fields[f];
      FieldPose pose = pose_of(field, world.rigid_bodies);
      if (field.rigid >= 0) {
        const bodies::RigidBody& body = world.rigid_bodies[static_cast<std::size_t>(field.rigid)];
        pose.position_m += time_s * body.velocity_m_s;
        const double turn_rad = time_s * body.angular_velocity_rad_s.norm();
        pose.rotation =
            Eigen::AngleAxisd(turn_rad, body.angular_velocity_rad_s.normalized()) * pose.rotation;
      }
      const int number = bodies::number_of_field(world, f);
      const auto look = [&](int who, const Vector3d& at_m, double radius_m) {
        if (touch_of(field, pose, at_m, radius_m).depth_m > 0.0) pairs.insert({who, number});
      };
      for (std::size_t i = 0; i < world.spheres.size(); ++i) {
        const bodies::SphereMotion motion = bodies::sphere_motion(world, world.spheres[i]);
        if (world.spheres[i].body != field.body)
          look(static_cast<int>(i), motion.position_m + time_s * motion.velocity_m_s,
               world.spheres[i].radius_m);
      }
      if (field.rigid < 0) continue;
      for (std::size_t i = 0; i < world.static_spheres.size(); ++i)
        look(kStatic - static_cast<int>(i), world.static_spheres[i].position_m,
             world.static_spheres[i].radius_m);
      const ToolSphereMotion& tool = crowd.tool[0];
      look(kTool, tool.position_before_m + share * (tool.position_m - tool.position_before_m),
           tool.radius_m);
    }
  }
  return pairs;
}

TEST_CASE("All that meets a field on its way is a contact, once, and points meet fields only",
          "[field]") {
  const auto seed = GENERATE(range(1U, 13U));
  const double step_s = GENERATE(0.0031, 0.013);
  const Crowd own = crowd(seed, step_s);
  const std::vector<Contact> contacts = contacts_within(own.world, step_s, own.tool);

  Pairs found;
  for (const Contact& contact : contacts) {
    const bool is_first = bodies::is_field(own.world, contact.a);
    const bool is_of_field = is_first || bodies::is_field(own.world, contact.b);
    if (!is_of_field) {
      for (const int sphere : {contact.a, contact.b})
        if (sphere >= 0)
          CHECK_FALSE(own.world.spheres[static_cast<std::size_t>(sphere)].is_field_point);
      continue;
    }
    const int who = !is_first ? contact.a : contact.is_tool ? kTool : kStatic - contact.other;
    CHECK(found.insert({who, is_first ? contact.a : contact.b}).second);
  }
  const Pairs met = overlapping(own, step_s);
  REQUIRE(!met.empty());
  for (const auto& pair : met) {
    CAPTURE(pair.first, pair.second);
    CHECK(found.count(pair) == 1);
  }
}

}  // namespace
}  // namespace stillgrid::contact::field_contact_test
