// What sleep saves in an engine, and how driven bodies wake.
#include <algorithm>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/coupled_step.hpp"
#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/field_geometry.hpp"
#include "shared/dynamics/sphere_ways.hpp"

namespace stillgrid::dynamics {
/// Leaves out of a tick what sleeps. The next listing is to follow.
void Engine::adopt_sleep() {
  is_still_known_ = false;
  listing_.set_sleeping(sleep_.spheres(), sleep_.rigid_bodies());
  springs_.leave_out(sleep_.nodes());
  if (coupled_) coupled_->leave_out(sleep_);
  awake_nodes_.clear();
  for (std::size_t i = 0; i < sleep_.nodes().size(); ++i) {
    if (sleep_.nodes()[i] != 0) continue;
    if (awake_nodes_.empty() || awake_nodes_.back().second != i) awake_nodes_.emplace_back(i, i);
    awake_nodes_.back().second = i + 1;
  }
  find_awake_joints(description_, sleep_, awake_joints_);
}

/// An island that wakes may touch another one, once its contacts are listed.
void Engine::wake_touched(double tick_s) {
  while (sleep_.wake_touched(state_, listing_, tick_s)) {
    adopt_sleep();
    list_contacts(tick_s);
  }
}

/// Whether all bodies sleep and no driven body comes near one in the tick.
bool Engine::passes(double tick_s) {
  if (!may_pass_ || !sleep_.all_sleep()) return false;
  if (!is_still_known_) {
    still_at_.clear();
    for (std::size_t s = 0; s < description_.spheres.size(); ++s) {
      const Description::Sphere& sphere = description_.spheres[s];
      const bool is_fixture = description_.is_fixture(sphere.rigid);
      if (sleep_.spheres()[s] == 0 && !is_fixture) continue;
      still_at_.push_back(sphere_position_m(sphere, state_));
      still_at_.back().w = sphere.radius_m;
    }
    still_.arrange(still_at_);
    is_still_known_ = true;
  }
  for (const Description::Sphere& sphere : description_.spheres) {
    if (sphere.rigid < 0 || driven_of_rigid_[at(sphere.rigid)] < 0) continue;
    if (!is_clear_of_sleepers(sphere, tick_s)) return false;
  }
  is_stale_ = true;  // nothing followed the driven bodies
  return true;
}

bool Engine::is_clear_of_sleepers(const Description::Sphere& sphere, double tick_s) {
  const std::size_t rigid = at(sphere.rigid);
  if (description_.rigid_bodies[rigid].is_fixture || state_.is_here[rigid] == 0) return true;
  const SpherePath way = sphere_path(sphere, state_, tick_s);
  Vector4 ball(way.from_m);
  ball.w = sphere.radius_m + way.path_m.norm();
  const auto tools = listing_.tools();
  const auto tool = std::ranges::find_if(
      tools, [&](std::int32_t s) { return &description_.spheres[at(s)] == &sphere; });
  // A proxy that something holds back is to be followed.
  if (tool != tools.end() && behind_m(static_cast<std::size_t>(tool - tools.begin())) > 0.0)
    return false;
  bool is_clear = true;
  still_.each_near(ball, [&](std::int32_t k) {
    const Vector4& still = still_at_[at(k)];
    is_clear = is_clear && least_distance_m(way.from_m - still.vector(), way.path_m) >
                               sphere.radius_m + still.w;
  });
  for (const Description::Field& field : description_.fields)
    is_clear = is_clear && (field.rigid == sphere.rigid ||
                            !may_touch(field, field_pose(field, state_).into(way.from_m),
                                       sphere.radius_m, way.path_m.norm()));
  return is_clear;
}

}  // namespace stillgrid::dynamics
