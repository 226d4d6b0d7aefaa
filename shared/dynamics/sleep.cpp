#include "shared/dynamics/sleep.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/field_geometry.hpp"
#include "shared/dynamics/sphere_ways.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kLook_s = 0.016;  // after which islands are looked for again
constexpr double kJoined = 0.01;   // of the smaller radius: a gap that still joins bodies

/// Gap of the sides of a listed contact of two spheres in the last substep.
double gap_m(const RowPlace& place, const ContactBodies& bodies, std::size_t lane) {
  const SpherePlace& a = bodies.places[at(place.sphere_a[lane])];
  const SpherePlace& b = bodies.places[at(place.sphere_b[lane])];
  double square = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double apart = static_cast<double>(place.apart_m[k][lane] + a.moved_m[k] - b.moved_m[k]);
    square += apart * apart;
  }
  return std::sqrt(square) - static_cast<double>(place.radii_m[lane]);
}

/// Whether two spheres touch within a tick in which one of them falls as well.
bool may_touch(const Description::Sphere& a, const Description::Sphere& b, const SceneState& state,
               const Eigen::Vector3d& falls_m, double tick_s) {
  const SpherePath path_a = sphere_path(a, state, tick_s), path_b = sphere_path(b, state, tick_s);
  return least_distance_m(path_a.from_m - path_b.from_m, path_a.path_m - path_b.path_m + falls_m) <=
         a.radius_m + b.radius_m;
}
bool may_touch(const Description::Sphere& sphere, const Description::Field& field,
               const SceneState& state, double falls_m, double tick_s) {
  const SpherePath path = sphere_path(sphere, state, tick_s);
  return may_touch(field, field_pose(field, state).into(path.from_m), sphere.radius_m,
                   path.path_m.norm() + tick_s * field_speed_m_s(field, state) + falls_m);
}

}  // namespace

Sleep::Sleep(const Description& description)
    : description_(description),
      body_of_node_(description.nodes.size(), -1),
      body_of_rigid_(description.rigid_bodies.size(), -1),
      spheres_of_body_(description.bodies.size()),
      saved_{std::vector<double>(description.bodies.size()),
             std::vector<std::int32_t>(description.bodies.size(), -1)},
      parent_(description.bodies.size()),
      is_restless_(description.bodies.size()),
      node_sleeps_(description.nodes.size()),
      rigid_sleeps_(description.rigid_bodies.size()),
      sphere_sleeps_(description.spheres.size()) {
  for (std::size_t b = 0; b < description.bodies.size(); ++b) {
    const Description::Body& body = description.bodies[b];
    for (int i = 0; i < body.node_count; ++i)
      body_of_node_[at(body.first_node + i)] = static_cast<std::int32_t>(b);
    if (body.rigid >= 0) body_of_rigid_[at(body.rigid)] = static_cast<std::int32_t>(b);
  }
  for (std::size_t s = 0; s < description.spheres.size(); ++s) {
    const Description::Sphere& sphere = description.spheres[s];
    body_of_sphere_.push_back(sphere.rigid >= 0 ? body_of_rigid_[at(sphere.rigid)]
                                                : body_of_node_[at(sphere.nodes[0])]);
    if (body_of_sphere_.back() >= 0)
      spheres_of_body_[at(body_of_sphere_.back())].push_back(static_cast<std::int32_t>(s));
  }
  for (const Description::Spring& spring : description.springs)
    if (body_of_node_[at(spring.a)] != body_of_node_[at(spring.b)])
      sprung_.emplace_back(body_of_node_[at(spring.a)], body_of_node_[at(spring.b)]);
  for (std::size_t i = 0; i < body_of_node_.size(); ++i)
    has_restless_ = has_restless_ || (body_of_node_[i] < 0 && !description.nodes[i].is_pinned);
  for (std::size_t r = 0; r < body_of_rigid_.size(); ++r)
    has_restless_ =
        has_restless_ || (body_of_rigid_[r] < 0 && !description.rigid_bodies[r].is_driven);
}

void Sleep::check(const Saved& saved) const {
  const auto bodies = static_cast<std::int32_t>(description_.bodies.size());
  const auto is_island = [&](std::int32_t island) { return island >= -1 && island < bodies; };
  if (saved.rested_s.size() != description_.bodies.size() ||
      saved.island.size() != description_.bodies.size() ||
      !std::ranges::all_of(saved.island, is_island))
    throw std::invalid_argument("the block has other bodies that sleep");
}

void Sleep::load(const Saved& saved) {
  saved_.rested_s = saved.rested_s;
  saved_.island = saved.island;
  sleeping_ = 0;
  for (std::size_t body = 0; body < description_.bodies.size(); ++body) {
    mark(body, is_sleeping(body) ? 1 : 0);
    if (is_sleeping(body)) ++sleeping_;
  }
}

bool Sleep::settle(SceneState& state, const ContactListing& listing, const ContactBodies& bodies,
                   double tick_s) {
  loss_J_ = 0.0;
  const double ticks = std::clamp(std::round(kLook_s / tick_s), 1.0, 1e6);
  if (!note_speeds(state, tick_s) || state.tick % static_cast<std::uint64_t>(ticks) != 0)
    return false;
  std::iota(parent_.begin(), parent_.end(), 0);
  for (std::size_t body = 0; body < parent_.size(); ++body)
    is_restless_[body] = saved_.rested_s[body] < kRest_s ? 1 : 0;
  join_joints();
  join_contacts(listing, bodies);
  bool slept = false;
  for (std::size_t body = 0; body < parent_.size(); ++body) {
    const std::int32_t island = root(static_cast<std::int32_t>(body));
    if (is_sleeping(body) || is_restless_[at(island)] != 0) continue;
    saved_.island[body] = island;
    lay_down(body, state);
    slept = true;
  }
  return slept;
}

/// Returns whether some body has been at rest for long enough.
bool Sleep::note_speeds(const SceneState& state, double tick_s) {
  bool one_rests = false;
  for (std::size_t b = 0; b < description_.bodies.size(); ++b) {
    if (is_sleeping(b)) continue;
    const Description::Body& body = description_.bodies[b];
    double square = 0.0;
    for (int i = 0; i < body.node_count; ++i)
      square =
          std::max(square, state.node_velocity_m_s[at(body.first_node + i)].vector().squaredNorm());
    if (body.rigid >= 0) {
      const double speed =
          state.rigid_velocity_m_s[at(body.rigid)].vector().norm() +
          body.bounding_radius_m * state.angular_velocity_rad_s[at(body.rigid)].vector().norm();
      square = std::max(square, speed * speed);
    }
    const bool is_slow = square < body.rest_speed_m_s * body.rest_speed_m_s;
    saved_.rested_s[b] = is_slow ? saved_.rested_s[b] + tick_s : 0.0;
    one_rests = one_rests || saved_.rested_s[b] >= kRest_s;
  }
  return one_rests;
}

/// Joins two bodies; -1 stands for one that never rests.
void Sleep::join(std::int32_t body, std::int32_t other) {
  if (body < 0) std::swap(body, other);
  if (body < 0) return;
  if (other < 0) return disturb(body);
  const std::int32_t a = root(body), b = root(other);
  is_restless_[at(a)] |= is_restless_[at(b)];
  parent_[at(b)] = a;
}

void Sleep::join_joints() {
  for (const Description::Joint& joint : description_.joints) {
    const auto is_still = [&](const Description::JointEnd& end) {
      return end.node < 0 && (end.rigid < 0 || description_.is_fixture(end.rigid));
    };
    if (is_still(joint.a) || is_still(joint.b)) continue;
    const auto body_of = [&](const Description::JointEnd& end) {
      return end.node >= 0 ? body_of_node_[at(end.node)] : body_of_rigid_[at(end.rigid)];
    };
    join(body_of(joint.a), body_of(joint.b));
  }
  for (const auto& [a, b] : sprung_) join(a, b);
}

void Sleep::join_contacts(const ContactListing& listing, const ContactBodies& bodies) {
  const RowList& list = listing.rows();
  for (const RowGroup& group : list.groups) {
    if (group.b == SideKind::kPlane) continue;
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
        const RowPlace& place = list.places[row];
        if (place.stiffness_N_per_m[lane] == 0.0F) continue;  // an unused lane
        const std::size_t a = at(listing.order()[at(place.sphere_a[lane])]);
        const std::int32_t b = place.sphere_b[lane], other = other_body(listing, b);
        if (description_.is_fixture(description_.spheres[a].rigid) ||
            description_.is_fixture(listing.rigid_of(b)))
          continue;
        if (body_of_sphere_[a] == other) continue;
        const std::span<const double> lengths_m = listing.lengths_m();
        const std::size_t other_sphere = listing.is_field(b) ? a : at(listing.order()[at(b)]);
        if (gap_m(place, bodies, lane) <= kJoined * std::min(lengths_m[a], lengths_m[other_sphere]))
          join(body_of_sphere_[a], other);
      }
  }
}

std::int32_t Sleep::root(std::int32_t body) {
  while (parent_[at(body)] != body) body = parent_[at(body)] = parent_[at(parent_[at(body)])];
  return body;
}

void Sleep::mark(std::size_t b, std::uint8_t sleeps) {
  const Description::Body& body = description_.bodies[b];
  for (int i = 0; i < body.node_count; ++i) node_sleeps_[at(body.first_node + i)] = sleeps;
  if (body.rigid >= 0) rigid_sleeps_[at(body.rigid)] = sleeps;
  for (const std::int32_t sphere : spheres_of_body_[b]) sphere_sleeps_[at(sphere)] = sleeps;
}

double Sleep::kinetic_energy_J(std::size_t b, const SceneState& state) const {
  const Description::Body& body = description_.bodies[b];
  double sum_J = 0.0;
  for (int i = 0; i < body.node_count; ++i) {
    const Description::Node& node = description_.nodes[at(body.first_node + i)];
    if (!node.is_pinned)
      sum_J += 0.5 * node.mass_kg *
               state.node_velocity_m_s[at(body.first_node + i)].vector().squaredNorm();
  }
  if (body.rigid < 0) return sum_J;
  const Description::Rigid& rigid = description_.rigid_bodies[at(body.rigid)];
  const Eigen::Vector3d spin = state.orientation[at(body.rigid)].quaternion().conjugate() *
                               state.angular_velocity_rad_s[at(body.rigid)].vector();
  return sum_J + 0.5 * spin.dot(rigid.inertia_kg_m2.cwiseProduct(spin)) +
         0.5 * rigid.mass_kg * state.rigid_velocity_m_s[at(body.rigid)].vector().squaredNorm();
}

void Sleep::lay_down(std::size_t b, SceneState& state) {
  const Description::Body& body = description_.bodies[b];
  loss_J_ += kinetic_energy_J(b, state);
  ++sleeping_;
  mark(b, 1);
  for (int i = 0; i < body.node_count; ++i) state.node_velocity_m_s[at(body.first_node + i)] = {};
  if (body.rigid < 0) return;
  state.rigid_velocity_m_s[at(body.rigid)] = {};
  state.angular_velocity_rad_s[at(body.rigid)] = {};
}

std::int32_t Sleep::other_body(const ContactListing& listing, std::int32_t sphere_b) const {
  if (listing.is_field(sphere_b)) return body_of_rigid_[at(listing.field_of(sphere_b).rigid)];
  return body_of_sphere_[at(listing.order()[at(sphere_b)])];
}

bool Sleep::wake(std::int32_t sleeper) {
  if (sleeper < 0 || !is_sleeping(at(sleeper))) return false;
  const std::int32_t island = saved_.island[at(sleeper)];
  for (std::size_t body = 0; body < saved_.island.size(); ++body) {
    if (saved_.island[body] != island) continue;
    saved_.island[body] = -1;
    saved_.rested_s[body] = 0.0;
    --sleeping_;
    mark(body, 0);
  }
  return true;
}

void Sleep::wake_all() {
  Saved awake{std::vector<double>(saved_.rested_s.size()),
              std::vector<std::int32_t>(saved_.island.size(), -1)};
  load(awake);
}

bool Sleep::wake_touched(const SceneState& state, const ContactListing& listing, double tick_s) {
  bool woke = false;
  for (const ContactListing::Lane& lane : listing.sleeper_lanes()) {
    const RowPlace& place = listing.rows().places[lane.row];
    const std::int32_t a = listing.order()[at(place.sphere_a[lane.lane])];
    const std::int32_t b = place.sphere_b[lane.lane];
    const Description::Sphere& sphere = description_.spheres[at(a)];
    const bool a_sleeps = sphere_sleeps_[at(a)] != 0;
    const int awake = a_sleeps ? listing.rigid_of(b) : sphere.rigid;
    const bool falls = awake < 0 || !description_.rigid_bodies[at(awake)].is_driven;
    const Eigen::Vector3d falls_m = (!falls     ? 0.0
                                     : a_sleeps ? -1.0
                                                : 1.0) *
                                    tick_s * tick_s * description_.gravity_m_s2;
    const bool touches = listing.is_field(b)
                             ? may_touch(sphere, listing.field_of(b), state, falls_m.norm(), tick_s)
                             : may_touch(sphere, description_.spheres[at(listing.order()[at(b)])],
                                         state, falls_m, tick_s);
    if (!touches) continue;
    woke = wake(body_of_sphere_[at(a)]) || woke;
    woke = wake(other_body(listing, b)) || woke;
  }
  return woke;
}

void find_awake_joints(const Description& description, const Sleep& sleep,
                       std::vector<Description::Joint>& joints) {
  joints.clear();
  const auto sleeps = [&](const Description::JointEnd& end) {
    return end.node >= 0
               ? sleep.nodes()[static_cast<std::size_t>(end.node)] != 0
               : end.rigid >= 0 && sleep.rigid_bodies()[static_cast<std::size_t>(end.rigid)] != 0;
  };
  for (const Description::Joint& joint : description.joints)
    if (!sleeps(joint.a) && !sleeps(joint.b)) joints.push_back(joint);
}

}  // namespace stillgrid::dynamics
