// What an engine tells of the tick that it computed.
#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/engine.hpp"

namespace stillgrid::dynamics {
namespace {

/// Calls visit(group, row, lane) for all lanes.
template <class Visit>
void each_contact(const RowList& list, const Visit& visit) {
  for (const RowGroup& group : list.groups)
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) visit(group, row, lane);
}

double square_of(double x, double y, double z) {
  return x * x + y * y + z * z;
}

/// Of a depth; of a gap zero.
double square_of(double depth_m) {
  return depth_m > 0.0 ? depth_m * depth_m : 0.0;
}

/// Square of the depth of a SleepingContact. That with a field is scaled by its map.
double square_depth_m2(const Description& description, const SceneState& state, std::int32_t first,
                       std::int32_t second) {
  const Description::Sphere& a = description.spheres[at(first)];
  const Eigen::Vector3d centre = sphere_position_m(a, state).vector();
  const Description::Side b = description.side(at(second));
  if (b.field != nullptr) {
    const TangentSphere tangent =
        tangent_sphere(*b.field, field_pose(*b.field, state), centre, a.radius_m);
    return tangent.map_scale * square_of(tangent.depth_m);
  }
  if (b.plane != nullptr)
    return square_of(a.radius_m - (b.plane->normal.dot(centre) - b.plane->offset_m));
  return square_of(a.radius_m + b.sphere->radius_m -
                   (centre - sphere_position_m(*b.sphere, state).vector()).norm());
}

}  // namespace

int Engine::touching() const {
  int count = 0;
  const RowList& list = listing_.rows();
  each_contact(list, [&](const RowGroup&, std::size_t row, std::size_t lane) {
    if (list.rows[row].push_impulse_N_s[lane] > 0.0F) ++count;
  });
  return count;
}

void Engine::list_contact_forces(std::vector<ContactForce>& forces) const {
  struct Sum {
    ContactForce force;  // its torque is about the origin, its centre weighted by pushes
    double push_N = 0.0;
  };
  std::map<std::pair<int, int>, Sum> sums;
  const RowList& list = listing_.rows();
  each_contact(list, [&](const RowGroup& group, std::size_t index, std::size_t lane) {
    const ContactRow& row = list.rows[index];
    const double push_N = row.push_impulse_N_s[lane] / substep_s_;
    if (!(push_N > 0.0)) return;
    const RowPlace& place = list.places[index];
    const auto sphere_at = [&](std::int32_t number) -> const Description::Sphere& {
      return description_.spheres[at(listing_.order()[at(number)])];
    };
    const Description::Sphere& a = sphere_at(place.sphere_a[lane]);
    const std::int32_t b = place.sphere_b[lane];
    const int other = group.b == SideKind::kPlane ? description_.planes[at(b)].body
                      : listing_.is_field(b)      ? listing_.field_of(b).body
                                                  : sphere_at(b).body;
    if (a.body == other) return;
    const Eigen::Vector3d normal = lane_of(row.normal, lane);
    const Eigen::Vector3d force_N =
        (a.body < other ? 1.0 : -1.0) *
        (push_N * normal + lane_of(row.friction_impulse_N_s, lane) / substep_s_);
    const Eigen::Vector3d at_m = sphere_position_m(a, state_).vector() - a.radius_m * normal;
    Sum& sum = sums[std::minmax(a.body, other)];
    ++sum.force.contacts;
    sum.force.force_N += force_N;
    sum.force.torque_N_m += at_m.cross(force_N);
    sum.force.centre_m += push_N * at_m;
    sum.push_N += push_N;
  });
  forces.clear();
  for (auto& [bodies, sum] : sums) {
    std::tie(sum.force.body_a, sum.force.body_b) = bodies;
    sum.force.centre_m /= sum.push_N;
    sum.force.torque_N_m -= sum.force.centre_m.cross(sum.force.force_N);
    forces.push_back(sum.force);
  }
}

double Engine::contact_energy_J() const {
  // Where all bodies sleep, no listing follows the driven bodies.
  if (!is_stale_ || sleep_.sleeping() > 0) return energy_of_contacts_J(listing_, -1);
  ContactListing listing(description_);
  listing.list(state_, kTick_s);
  return energy_of_contacts_J(listing, -1);
}

/// Of all listed contacts, or of those of one rigid body.
double Engine::energy_of_contacts_J(const ContactListing& listing, int rigid) const {
  double sum_J = fields_.energy_J(listing, state_, rigid);
  const auto spheres = static_cast<std::int32_t>(description_.spheres.size());
  const auto add = [&](std::int32_t first, std::int32_t second, double stiffness_N_per_m,
                       double stretch_square_m2, const ToolLane* tool = nullptr) {
    const int a = description_.spheres[at(first)].rigid;
    const int b = description_.side(at(second)).rigid();
    const auto is_driven = [&](int r) {
      return r >= 0 && description_.rigid_bodies[at(r)].is_driven;
    };
    // No energy of the scene is between two driven bodies.
    if ((rigid >= 0 && a != rigid && b != rigid) || (is_driven(a) && is_driven(b))) return;
    sum_J += 0.5 * stiffness_N_per_m *
             (stretch_square_m2 + (tool != nullptr
                                       ? square_of(listing.tool_depth_m(*tool, state_))
                                       : square_depth_m2(description_, state_, first, second)));
  };
  each_contact(listing.rows(), [&](const RowGroup& group, std::size_t row, std::size_t lane) {
    const RowPlace& place = listing.rows().places[row];
    if (place.stiffness_N_per_m[lane] == 0.0F) return;  // an unused lane
    const bool is_plane = group.b == SideKind::kPlane;
    const std::int32_t b = place.sphere_b[lane];
    if (!is_plane && listing.is_field(b)) return;  // a field
    add(listing.order()[at(place.sphere_a[lane])], is_plane ? spheres + b : listing.order()[at(b)],
        static_cast<double>(place.stiffness_N_per_m[lane]),
        square_of(place.stretch_m[0][lane], place.stretch_m[1][lane], place.stretch_m[2][lane]),
        listing.tool_lane(row, lane));
  });
  for (const ContactListing::SleepingContact& contact : listing.sleeping_contacts()) {
    const auto& stretch = contact.history.stretch_m;
    add(contact.first, contact.second, listing.stiffness_N_per_m(contact.first, contact.second),
        square_of(stretch[0], stretch[1], stretch[2]));
  }
  return sum_J;
}

void Engine::note_reactions(double h) {
  for (std::size_t k = 0; k < driven_.size() && !wrenches_.empty(); ++k) {
    reactions_[k].impulse_N_s += h * wrenches_[driven_[k]].force_N;
    reactions_[k].moment_N_m_s += h * wrenches_[driven_[k]].torque_N_m;
  }
  const RowList& list = listing_.rows();
  const auto note = [&](std::int32_t mover, const RigidSide& side, std::size_t lane, double sign,
                        const ContactRow& row, bool is_rigid) {
    const std::size_t k = at(mover) - forces_N_.size();
    const auto order = listing_.rigid_order();
    if (k >= order.size() || driven_of_rigid_[at(order[k])] < 0) return;
    DrivenReaction& reaction = reactions_[at(driven_of_rigid_[at(order[k])])];
    const Eigen::Vector3d impulse = sign * (row.push_impulse_N_s[lane] * lane_of(row.normal, lane) +
                                            lane_of(row.friction_impulse_N_s, lane));
    const Eigen::Vector3d moment = lane_of(side.arm_m, lane).cross(impulse);
    reaction.impulse_N_s += impulse;
    reaction.moment_N_m_s += moment;
    if (!is_rigid) return;
    reaction.rigid_impulse_N_s += impulse;
    reaction.rigid_moment_N_m_s += moment;
  };
  for (std::size_t g = 0, i = 0; g < list.groups.size(); ++g) {
    const RowGroup& group = list.groups[g];
    for (; i < live_.group_end[g]; ++i) {
      const std::size_t index = live_.rows[i], k = index - group.first;
      const ContactRow& row = list.rows[index];
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
        if (row.push_impulse_N_s[lane] == 0.0F) continue;
        const bool is_rigid = is_between_driven(group, row, bodies_, lane);
        if (group.a == SideKind::kRigid)
          note(row.mover_a[lane], list.rigid_sides[group.first_side_a + k], lane, 1.0, row,
               is_rigid);
        if (group.b == SideKind::kRigid)
          note(row.mover_b[lane], list.rigid_sides[group.first_side_b + k], lane, -1.0, row,
               is_rigid);
      }
    }
  }
}

}  // namespace stillgrid::dynamics
