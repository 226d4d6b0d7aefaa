// Where the spheres of an engine are, and how long contacts need no new listing.
#include <algorithm>
#include <cmath>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/engine.hpp"

namespace stillgrid::dynamics {
void Engine::place_spheres(std::span<const OtherSphere> spheres, double h) {
  const double falls = h * h * description_.gravity_m_s2.norm();
  for (const std::int32_t rigid : others()) {
    const std::size_t r = at(rigid);
    poses_of_others_[r] = {state_.orientation[r].quaternion().toRotationMatrix(),
                           state_.rigid_velocity_m_s[r].vector().norm(),
                           state_.angular_velocity_rad_s[r].vector().norm()};
  }
  for (const OtherSphere& sphere : spheres) {
    SpherePlace& place = bodies_.places[at(sphere.place)];
    Vector4 moved = -1.0 * sphere.base;
    double speed = 0.0;
    if (sphere.rigid >= 0) {
      const PoseOfOther& pose = poses_of_others_[at(sphere.rigid)];
      const Vector4 arm(pose.axes * sphere.local_m);
      moved = moved + state_.rigid_position_m[at(sphere.rigid)] + arm;
      speed = pose.speed_m_s + pose.spin_rad_s * sphere.arm_m;
      set_vector(bodies_.arms[at(sphere.place)].arm_m, arm);
    } else {
      double square = 0.0;
      for (std::size_t n = 0; n < at(sphere.node_count); ++n) {
        const std::size_t node = at(sphere.nodes[n]);
        moved = moved + sphere.weights[n] * state_.node_position_m[node];
        square = std::max(square, state_.node_velocity_m_s[node].vector().squaredNorm());
      }
      speed = std::sqrt(square);
    }
    set_vector(place.moved_m, moved);
    place.margin_m = static_cast<float>(h * speed + falls);
  }
}

/// Whether no sphere leaves its reach within the tick.
bool Engine::listing_holds(double tick_s) {
  const double falls = tick_s * tick_s * description_.gravity_m_s2.norm();
  if (is_stale_ || !stay_within(balls_, state_, tick_s, falls) ||
      !fields_.stay_within(listing_, state_, tick_s))
    return false;
  place_spheres(other_spheres_, tick_s);
  bool holds = true;
  for (const OtherSphere& sphere : other_spheres_) {
    const SpherePlace& place = bodies_.places[at(sphere.place)];
    const float x = place.moved_m[0], y = place.moved_m[1], z = place.moved_m[2];
    const double way = std::sqrt(x * x + y * y + z * z) + place.margin_m;
    holds = holds && way < sphere.base.w;
  }
  for (std::size_t t = 0; t < listing_.tools().size(); ++t) {
    const Description::Sphere& sphere = description_.spheres[at(listing_.tools()[t])];
    if (state_.is_here[at(sphere.rigid)] == 0) continue;
    const Vector4& base = listing_.base_of_tool(t);
    holds = holds && (state_.proxy_m[t] - base).vector().norm() +
                             tick_s * sphere_velocity_m_s(sphere, state_).norm() <
                         base.w;
  }
  return holds;
}

/// Finds the spheres and nodes that contacts may move: most of a soft body is near nothing.
void Engine::note_listed() {
  std::ranges::fill(is_listed_, 0);
  const std::size_t spheres = description_.spheres.size();
  const RowList& list = listing_.rows();
  for (const RowGroup& group : list.groups)
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
        const std::int32_t a = list.places[row].sphere_a[lane], b = list.places[row].sphere_b[lane];
        if (a < 0) continue;
        is_listed_[at(a)] = 1;
        if (group.b != SideKind::kPlane && at(b) < spheres) is_listed_[at(b)] = 1;  // else a field
      }
  const auto is_listed = [&](const OtherSphere& sphere) {
    return is_listed_[at(sphere.place)] != 0;
  };
  // Not stable_partition, which allocates.
  const auto unlisted = std::partition(other_spheres_.begin(), other_spheres_.end(), is_listed);
  listed_others_ = static_cast<std::size_t>(unlisted - other_spheres_.begin());
  // What never moves does not leave its reach.
  std::erase_if(other_spheres_, [&](const OtherSphere& sphere) {
    return !is_listed(sphere) && description_.is_fixture(sphere.rigid);
  });
  for (const OtherSphere& sphere : std::span(other_spheres_).first(listed_others_))
    for (std::size_t n = 0; n < at(sphere.node_count); ++n)
      is_listed_[spheres + at(sphere.nodes[n])] = 1;
  listed_nodes_.clear();
  each_awake_node([&](std::size_t i) {
    if (is_listed_[spheres + i] != 0) listed_nodes_.push_back(static_cast<std::int32_t>(i));
  });
}

/// Sets what stays as it is from listing to listing.
void Engine::adopt_listing() {
  const std::size_t nodes = forces_N_.size();
  fields_.adopt(listing_, bodies_);
  balls_.first_mover = nodes;
  balls_.rigid.clear();
  balls_.place.clear();
  balls_.radius_m.clear();
  balls_.base.clear();
  other_spheres_.clear();
  for (std::size_t k = 0; k < listing_.order().size(); ++k) {
    const std::size_t s = at(listing_.order()[k]);
    bodies_.arms[k].radius_m = static_cast<float>(description_.spheres[s].radius_m);
    ways_m_[k] = 0.0F;
    bodies_.places[k] = {};
    if (sleep_.spheres()[s] != 0) continue;
    if (listing_.kinds()[s] != SideKind::kBall) {
      const Description::Sphere& sphere = description_.spheres[s];
      other_spheres_.push_back({static_cast<std::int32_t>(k), sphere.rigid, sphere.node_count,
                                sphere.nodes, sphere.weights, sphere.local_m, sphere.local_m.norm(),
                                listing_.base()[k]});
      continue;
    }
    balls_.rigid.push_back(description_.spheres[s].rigid);
    balls_.place.push_back(static_cast<std::int32_t>(k));
    balls_.radius_m.push_back(static_cast<float>(description_.spheres[s].radius_m));
    balls_.base.push_back(listing_.base()[k]);
  }
  note_listed();
  for (std::size_t i = 0; i < nodes; ++i) {
    const Description::Node& node = description_.nodes[i];
    bodies_.movers[i].inverse_mass_per_kg =
        node.is_pinned || sleep_.nodes()[i] != 0 ? 0.0F : static_cast<float>(1.0 / node.mass_kg);
    if (sleep_.nodes()[i] != 0) set_vector(bodies_.movers[i].velocity_m_s, {});
  }
  for (std::size_t k = 0; k < listing_.rigid_order().size(); ++k) {
    const Description::Rigid& body = description_.rigid_bodies[at(listing_.rigid_order()[k])];
    bodies_.movers[nodes + k].inverse_mass_per_kg = body.is_driven || k >= listing_.rigid_awake()
                                                        ? 0.0F
                                                        : static_cast<float>(1.0 / body.mass_kg);
    if (k >= listing_.rigid_awake())
      for (auto* of : {&bodies_.movers[nodes + k].velocity_m_s, &bodies_.movers[nodes + k].spin})
        set_vector(*of, {});
    bodies_.inverse_inertias[nodes + k] = {};
  }
}

}  // namespace stillgrid::dynamics
