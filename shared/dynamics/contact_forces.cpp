// The forces between bodies.
#include <algorithm>
#include <array>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/engine.hpp"

namespace stillgrid::dynamics {
namespace {

Eigen::Vector3d lane_of(const RowFloats (&columns)[3], std::size_t lane) {
  return {columns[0][lane], columns[1][lane], columns[2][lane]};
}

/// Sums over contacts of two bodies: the torque is about the origin, places are weighted by pushes.
struct PairSum {
  ContactForce force;
  double push_N = 0.0;
};

}  // namespace

void Engine::list_contact_forces(std::vector<ContactForce>& forces) const {
  std::vector<PairSum> sums;
  const RowList& list = listing_.rows();
  const auto body_b = [&](const RowGroup& group, std::int32_t b) {
    if (group.b == SideKind::kPlane) return description_.planes[at(b)].body;
    if (listing_.is_field(b)) return listing_.field_of(b).body;
    return description_.spheres[at(listing_.order()[at(b)])].body;
  };
  const auto add = [&](const RowGroup& group, std::size_t index, std::size_t lane) {
    const ContactRow& row = list.rows[index];
    const double push_N = row.push_impulse_N_s[lane] / substep_s_;
    const RowPlace& place = list.places[index];
    const Description::Sphere& a =
        description_.spheres[at(listing_.order()[at(place.sphere_a[lane])])];
    const int other = body_b(group, place.sphere_b[lane]);
    if (!(push_N > 0.0) || a.body == other) return;
    const bool is_first = a.body < other;
    const Eigen::Vector3d normal = lane_of(row.normal, lane);
    const Eigen::Vector3d on_a_N =
        push_N * normal + lane_of(row.friction_impulse_N_s, lane) / substep_s_;
    const Eigen::Vector3d force_N = is_first ? on_a_N : Eigen::Vector3d(-on_a_N);
    const Eigen::Vector3d at_m = sphere_position_m(a, state_).vector() - a.radius_m * normal;
    PairSum one;
    one.force = {.body_a = std::min(a.body, other),
                 .body_b = std::max(a.body, other),
                 .contacts = 1,
                 .force_N = force_N,
                 .torque_N_m = at_m.cross(force_N),
                 .centre_m = push_N * at_m};
    one.push_N = push_N;
    sums.push_back(one);
  };
  for (const RowGroup& group : list.groups)
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane)
        if (list.places[row].stiffness_N_per_m[lane] != 0.0F) add(group, row, lane);
  const auto pair_of = [](const PairSum& sum) {
    return std::pair(sum.force.body_a, sum.force.body_b);
  };
  std::ranges::stable_sort(sums, {}, pair_of);
  forces.clear();
  for (auto first = sums.begin(); first != sums.end();) {
    const auto end = std::find_if(
        first, sums.end(), [&](const PairSum& sum) { return pair_of(sum) != pair_of(*first); });
    PairSum all = *first;
    for (++first; first != end; ++first) {
      all.force.contacts += first->force.contacts;
      all.force.force_N += first->force.force_N;
      all.force.torque_N_m += first->force.torque_N_m;
      all.force.centre_m += first->force.centre_m;
      all.push_N += first->push_N;
    }
    all.force.centre_m /= all.push_N;
    all.force.torque_N_m -= all.force.centre_m.cross(all.force.force_N);
    forces.push_back(all.force);
  }
}

}  // namespace stillgrid::dynamics
