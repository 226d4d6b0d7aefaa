#include "sim_server/dynamics/step/sleeping.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim_server/contact/field_touch.hpp"
#include "sim_server/dynamics/step/energy_account.hpp"
#include "sim_server/dynamics/ticks/described_world.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kLongestLook_s = Sleeping::kRest_s / 8;  // so that several steps are looked at
constexpr double kJoined = 0.01;  // of the smaller radius: a gap that still joins an island

bool is_free(const bodies::World& world, const bodies::BodyRange& body) {
  return body.node_count > 0 ||
         (body.rigid >= 0 && world.rigid_bodies[static_cast<std::size_t>(body.rigid)].free);
}

double fastest_m_s(const bodies::World& world, const bodies::BodyRange& body) {
  double squared_m2_s2 = 0.0;
  for (int i = 0; i < body.node_count; ++i)
    squared_m2_s2 = std::max(
        squared_m2_s2,
        world.nodes[static_cast<std::size_t>(body.first_node + i)].velocity_m_s.squaredNorm());
  if (body.rigid < 0) return std::sqrt(squared_m2_s2);
  const bodies::RigidBody& rigid = world.rigid_bodies[static_cast<std::size_t>(body.rigid)];
  return rigid.velocity_m_s.norm() + rigid.bounding_radius_m * rigid.angular_velocity_rad_s.norm();
}

std::size_t place_of_body(const bodies::World& world, int number) {
  return static_cast<std::size_t>(bodies::body_of(world, number));
}

/// How far apart a contact's sides are where the world is now. Negative: they overlap.
double gap_m(const bodies::World& world, const contact::Contact& contact,
             std::span<const bodies::SphereMotion> spheres) {
  const auto at_m = [&](int sphere) -> const Eigen::Vector3d& {
    return sphere < 0 ? contact.position_b_m : spheres[static_cast<std::size_t>(sphere)].position_m;
  };
  for (const bool is_first : {true, false}) {
    const int number = is_first ? contact.a : contact.b;
    if (!bodies::is_field(world, number)) continue;
    const bodies::FieldBody& field = bodies::field_of(world, number);
    return -contact::touch_of(field, contact::pose_of(field, world.rigid_bodies),
                              at_m(is_first ? contact.b : contact.a),
                              is_first ? contact.radius_b_m : contact.radius_a_m)
                .depth_m;
  }
  return (at_m(contact.a) - at_m(contact.b)).norm() - (contact.radius_a_m + contact.radius_b_m);
}

/// Whether a contact is with what never moves: floors and walls keep no one awake.
bool is_with_walls(const bodies::World& world, const contact::Contact& contact) {
  if (contact.b < 0) return !contact.is_tool;
  return bodies::is_field(world, contact.b) && bodies::rigid_of(world, contact.b) < 0;
}

}  // namespace

Sleeping::Sleeping(const bodies::World& world)
    : rest_speed_m_s_(world.bodies.size(), 0.0),
      is_fixture_(world.bodies.size()),
      rested_s_(world.bodies.size(), 0.0),
      parent_(world.bodies.size()),
      is_restless_(world.bodies.size()),
      island_(world.bodies.size()) {
  for (std::size_t body = 0; body < world.bodies.size(); ++body) {
    const bodies::BodyRange& range = world.bodies[body];
    is_fixture_[body] =
        range.rigid >= 0 && !is_free(world, range) &&
        !bodies::is_moved(world.rigid_bodies[static_cast<std::size_t>(range.rigid)]);
    rest_speed_m_s_[body] = dynamics::rest_speed_m_s(world, range);
  }
}

double Sleeping::rest_speed_m_s(int body) const {
  return rest_speed_m_s_[static_cast<std::size_t>(body)];
}

bool Sleeping::wake_touched(bodies::World& world, std::span<const contact::Contact> contacts,
                            const contact::Ways& ways) {
  if (sleeping_spheres_ == 0) return false;
  bool woke = false;
  const auto wake = [&](std::size_t sleeper) {
    const std::size_t island = island_[sleeper];
    for (std::size_t body = 0; body < world.bodies.size(); ++body) {
      bodies::BodyRange& range = world.bodies[body];
      if (!range.is_sleeping || island_[body] != island) continue;
      range.is_sleeping = false;
      rested_s_[body] = 0.0;
      sleeping_spheres_ -= range.sphere_count;
    }
    woke = true;
  };
  for (const contact::Contact& contact : contacts) {
    // What is still among still things has no contacts: a sphere that sleeps here meets what moves.
    const std::size_t a = place_of_body(world, contact.a);
    const std::size_t b = contact.b < 0 ? a : place_of_body(world, contact.b);
    if (!world.bodies[a].is_sleeping && !world.bodies[b].is_sleeping) continue;
    if (!contact::meet(contact, ways)) continue;
    for (const std::size_t body : {a, b})
      if (world.bodies[body].is_sleeping) wake(body);
  }
  if (woke) bodies::number_unknowns(world);
  return woke;
}

std::optional<double> Sleeping::settle(bodies::World& world,
                                       std::span<const contact::Contact> contacts,
                                       std::span<const bodies::SphereMotion> spheres, double step_s,
                                       bool is_sure) {
  if (!note_speeds(world, step_s, is_sure)) return std::nullopt;
  join_islands(world, contacts, spheres);
  std::optional<double> sleep_loss_J;
  for (std::size_t body = 0; body < world.bodies.size(); ++body) {
    if (rest_speed_m_s_[body] == 0.0 || world.bodies[body].is_sleeping || is_restless_[root(body)])
      continue;
    sleep_loss_J = sleep_loss_J.value_or(0.0) + kinetic_energy_J(world, world.bodies[body]);
    lay_down(world, body);
  }
  if (sleep_loss_J) bodies::number_unknowns(world);
  return sleep_loss_J;
}

/// Whether one has been at rest for long enough.
bool Sleeping::note_speeds(const bodies::World& world, double step_s, bool is_sure) {
  bool one_rests = false;
  for (std::size_t body = 0; body < world.bodies.size(); ++body) {
    const bodies::BodyRange& range = world.bodies[body];
    if (range.is_sleeping || rest_speed_m_s_[body] == 0.0) continue;
    const bool is_slow = is_sure && fastest_m_s(world, range) < rest_speed_m_s_[body];
    rested_s_[body] = is_slow ? rested_s_[body] + std::min(step_s, kLongestLook_s) : 0.0;
    one_rests = one_rests || rested_s_[body] >= kRest_s;
  }
  return one_rests;
}

void Sleeping::join_islands(const bodies::World& world, std::span<const contact::Contact> contacts,
                            std::span<const bodies::SphereMotion> spheres) {
  std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  for (std::size_t body = 0; body < parent_.size(); ++body)
    is_restless_[body] = rested_s_[body] < kRest_s;
  const auto join = [&](std::size_t one, std::size_t other) {
    const std::size_t a = root(one), b = root(other);
    is_restless_[a] = is_restless_[a] || is_restless_[b];
    parent_[b] = a;
    return a;
  };
  for (const bodies::Joint& joint : world.joints) {
    if (joint.a.node < 0 && joint.a.rigid < 0) continue;
    if (joint.b.node < 0 && joint.b.rigid < 0) continue;
    const auto a = static_cast<std::size_t>(joint.a.body);
    const auto b = static_cast<std::size_t>(joint.b.body);
    if (!is_fixture_[a] && !is_fixture_[b]) join(a, b);
  }
  for (const contact::Contact& contact : contacts) {
    if (is_with_walls(world, contact)) continue;
    if (is_fixture_[place_of_body(world, contact.a)]) continue;
    if (contact.b >= 0 && is_fixture_[place_of_body(world, contact.b)]) continue;
    const double near_m = kJoined * std::min(contact.radius_a_m, contact.radius_b_m);
    if (gap_m(world, contact, spheres) > near_m) continue;
    const std::size_t own = place_of_body(world, contact.a);
    const std::size_t a = join(own, contact.b < 0 ? own : place_of_body(world, contact.b));
    is_restless_[a] = is_restless_[a] || contact.is_tool;
  }
}

void Sleeping::lay_down(bodies::World& world, std::size_t body) {
  bodies::BodyRange& range = world.bodies[body];
  range.is_sleeping = true;
  island_[body] = root(body);
  sleeping_spheres_ += range.sphere_count;
  for (int i = 0; i < range.node_count; ++i)
    world.nodes[static_cast<std::size_t>(range.first_node + i)].velocity_m_s.setZero();
  if (range.rigid < 0) return;
  bodies::RigidBody& rigid = world.rigid_bodies[static_cast<std::size_t>(range.rigid)];
  rigid.velocity_m_s.setZero();
  rigid.angular_velocity_rad_s.setZero();
}

std::size_t Sleeping::root(std::size_t body) {
  while (parent_[body] != body) body = parent_[body] = parent_[parent_[body]];
  return body;
}

}  // namespace stillgrid::dynamics
