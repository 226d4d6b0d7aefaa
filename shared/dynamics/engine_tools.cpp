// The proxies of tools: where they are, and how the contacts of a tick see their tools.
#include <algorithm>
#include <utility>

#include "shared/collision/tool_proxy.hpp"
#include "shared/dynamics/at.hpp"
#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

/// Whether a surface holds a proxy back. Others are where their spheres are.
bool is_held(const Vector4& proxy) {
  return proxy.w > 0.0;
}

}  // namespace

/// What a proxy's sphere sees of another side at the start of a part of the tick. The side goes on
/// evenly.
Engine::Seen Engine::see(std::int32_t other, const Eigen::Vector3d& proxy_m, const ProxyTick& tick,
                         collision::TickPart part) const {
  const double radius_m = tick.device.radius_m;
  const Description::Side side = description_.side(at(other));
  Seen seen;
  if (side.plane != nullptr) {
    const double gap_m = side.plane->normal.dot(proxy_m) - side.plane->offset_m - radius_m;
    seen.space = {side.plane->normal, gap_m};
  } else if (side.field != nullptr) {
    const FieldPose pose = field_pose(*side.field, state_);
    const auto r = at(side.field->rigid);
    seen.velocity_m_s = state_.rigid_velocity_m_s[r].vector() +
                        state_.angular_velocity_rad_s[r].vector().cross(
                            tick.proxy_m - state_.rigid_position_m[r].vector());
    const TangentSphere tangent = proxy_tangent(
        *side.field, pose, proxy_m - part.from * tick.device.tick_s * seen.velocity_m_s,
        tick.device.to_m - tick.device.tick_s * seen.velocity_m_s, radius_m);
    seen.space = {tangent.normal, -tangent.depth_m};
    seen.map_scale = tangent.map_scale;
  } else {
    seen.velocity_m_s = sphere_velocity_m_s(*side.sphere, state_);
    const Eigen::Vector3d line_m = proxy_m - sphere_position_m(*side.sphere, state_).vector() -
                                   part.from * tick.device.tick_s * seen.velocity_m_s;
    seen.space = {line_m.stableNormalized(), line_m.norm() - radius_m - side.sphere->radius_m};
    seen.surface = {side.sphere->body, side.sphere->radius_m, line_m};
  }
  seen.space.moved_m = part.share() * tick.device.tick_s * seen.velocity_m_s;
  return seen;
}

/// Lays the half-spaces of all that a proxy may touch.
std::span<collision::HalfSpace> Engine::lay(const Eigen::Vector3d& proxy_m, const ProxyTick& tick,
                                            collision::TickPart part) {
  for (std::size_t k = 0; k < touchable_.size(); ++k) {
    seen_[k] = see(touchable_[k], proxy_m, tick, part);
    spaces_[k] = seen_[k].space;
    surfaces_[k] = seen_[k].surface;
  }
  cover_.lay(tick.device.radius_m, surfaces_, spaces_);
  return spaces_;
}

/// What a tool's sphere may touch: lanes, then fixtures, then planes.
void Engine::find_touchable(std::int32_t tool) {
  touchable_.clear();
  for (const ToolLane& lane : listing_.tool_lanes())
    if (lane.tool == tool) touchable_.push_back(lane.other);
  for (const ToolFixture& fixture : listing_.tool_fixtures())
    if (fixture.tool == tool) touchable_.push_back(fixture.other);
  for (std::size_t p = 0; p < description_.planes.size(); ++p)
    touchable_.push_back(static_cast<std::int32_t>(description_.spheres.size() + p));
  seen_.resize(touchable_.size());
  spaces_.resize(touchable_.size());
  surfaces_.resize(touchable_.size());
}

/// Proxies of tools that come begin at their spheres.
void Engine::begin_proxies() {
  for (std::size_t t = 0; t < listing_.tools().size(); ++t) {
    const Description::Sphere& sphere = description_.spheres[at(listing_.tools()[t])];
    const auto driven = at(driven_of_rigid_[at(sphere.rigid)]);
    if (poses_[driven].is_here && appeared_[driven] == 0) continue;
    state_.proxy_stretch_m[t] = {};
    state_.proxy_m[t] = poses_[driven].is_here ? sphere_position_m(sphere, state_) : Vector4();
  }
}

/// How far a tool's sphere is from its proxy.
double Engine::behind_m(std::size_t tool) const {
  const Description::Sphere& sphere = description_.spheres[at(listing_.tools()[tool])];
  if (state_.is_here[at(sphere.rigid)] == 0 || !is_held(state_.proxy_m[tool])) return 0.0;
  return (state_.proxy_m[tool] - sphere_position_m(sphere, state_)).vector().norm();
}

/// Energy of the springs of a tool's contacts, and of their friction.
double Engine::tool_energy_J(std::size_t driven) const {
  double sum_J = 0.0;
  for (const ToolLane& lane : listing_.tool_lanes()) {
    if (at(description_.spheres[at(listing_.tools()[at(lane.tool)])].rigid) != driven_[driven])
      continue;
    // No energy of the scene is between two driven bodies.
    const int other = description_.side(at(lane.other)).rigid();
    if (other >= 0 && driven_of_rigid_[at(other)] >= 0) continue;
    const RowPlace& place = listing_.rows().places[lane.row];
    const double depth_m = listing_.tool_depth_m(lane, state_);
    if (depth_m <= 0.0) continue;
    double square_m2 = lane.map_scale * depth_m * depth_m;
    for (const RowFloats& stretch_m : place.stretch_m)
      square_m2 += double{stretch_m[lane.lane]} * double{stretch_m[lane.lane]};
    sum_J += 0.5 * lane.share * double{lane.stiffness_N_per_m} * square_m2;
  }
  return sum_J;
}

/// Moves the proxies along with their tools for a part of a tick, from where the last part left
/// them. Other contacts may be listed for the same part, and the proxies moved again.
void Engine::move_proxies(double part_s) {
  moved_proxy_m_ = state_.proxy_m;
  a_tool_goes_far_ = false;
  for (std::size_t t = 0; t < listing_.tools().size(); ++t) {
    const Description::Sphere& sphere = description_.spheres[at(listing_.tools()[t])];
    const auto driven = at(driven_of_rigid_[at(sphere.rigid)]);
    if (!poses_[driven].is_here) continue;
    const std::size_t r = at(sphere.rigid);
    const Eigen::Vector3d device_m = state_.rigid_position_m[r].vector() +
                                     part_s * state_.rigid_velocity_m_s[r].vector() +
                                     turned(state_.orientation[r].quaternion(),
                                            state_.angular_velocity_rad_s[r].vector(), part_s) *
                                         sphere.local_m;
    const Eigen::Vector3d from_m = sphere_position_m(sphere, state_).vector();
    const Eigen::Vector3d proxy_m =
        is_held(state_.proxy_m[t]) ? state_.proxy_m[t].vector() : from_m;
    find_touchable(static_cast<std::int32_t>(t));
    const ProxyTick tick{{from_m, device_m, sphere.radius_m, part_s}, proxy_m};
    moved_proxy_m_[t] = Vector4(collision::follow(
        proxy_m, tick.device, [&](const Eigen::Vector3d& at_m, collision::TickPart part) {
          return lay(at_m, tick, part);
        }));
    const bool is_let_out = std::ranges::any_of(spaces_, &collision::HalfSpace::lets_out);
    moved_proxy_m_[t].w = moved_proxy_m_[t].vector() == device_m ? 0.0 : is_let_out ? 0.5 : 1.0;
    cover_.share(spaces_);
    std::size_t k = 0;
    for (ToolLane& lane : listing_.tool_lanes())
      if (lane.tool == static_cast<std::int32_t>(t)) {
        aim_lane(lane, seen_[k], spaces_[k], tick);
        const double way_m = (device_m - from_m - part_s * seen_[k].velocity_m_s).norm();
        a_tool_goes_far_ =
            a_tool_goes_far_ || way_m > std::max(sphere.radius_m, seen_[k].space.gap_m);
        ++k;
      }
  }
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    if (is_tool_[k] == 0) continue;
    const double held_J = tool_energy_J(k);
    reactions_[k].aimed_J += held_J - std::exchange(held_J_[k], held_J);
  }
}

/// Lets a contact see its tool as deep in the other side as in the half-space.
void Engine::aim_lane(ToolLane& lane, const Seen& seen, const collision::HalfSpace& space,
                      const ProxyTick& tick) {
  const Description::Sphere& sphere = description_.spheres[at(listing_.tools()[at(lane.tool)])];
  const Description::Side other = description_.side(at(lane.other));
  const Eigen::Vector3d& device_m = tick.device.to_m;
  const bool is_free = !is_held(moved_proxy_m_[at(lane.tool)]);
  const Eigen::Vector3d goes_m = tick.device.tick_s * seen.velocity_m_s;
  lane.share = space.depth_m > 0.0 ? space.push_m / space.depth_m : 1.0;
  lane.is_held = other.field != nullptr && !is_free;
  lane.shift_m.setZero();
  if (lane.is_held) {
    const double radii_m = sphere.radius_m + field_radius_m(*other.field);
    lane.ahead_m = device_m - (radii_m - space.depth_m) * space.normal;
    lane.centre_m = field_pose(*other.field, state_).into(lane.ahead_m - goes_m);
    lane.map_scale = seen.map_scale;
  } else if (other.sphere != nullptr && !is_free) {
    const double radii_m = sphere.radius_m + other.sphere->radius_m;
    lane.ahead_m = sphere_position_m(*other.sphere, state_).vector() + goes_m;
    lane.shift_m = lane.ahead_m + (radii_m - space.depth_m) * space.normal - device_m;
  }
  const double sign = lane.is_a ? 1.0 : -1.0;
  const Eigen::Vector3d apart_m = lane.apart_m + sign * lane.shift_m;
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();
  // What opens during the tick still sticks as it begins.
  if (space.push_m > 0.0 || listing_.tool_depth_m(lane, state_) > 0.0)
    stretch_m = sign * state_.proxy_stretch_m[at(lane.tool)].vector();
  RowPlace& place = listing_.rows().places[lane.row];
  for (int axis = 0; axis < 3; ++axis) {
    place.apart_m[axis][lane.lane] = static_cast<float>(apart_m[axis]);
    place.stretch_m[axis][lane.lane] = static_cast<float>(stretch_m[axis]);
  }
  place.stiffness_N_per_m[lane.lane] = static_cast<float>(lane.share) * lane.stiffness_N_per_m;
  place.damping_N_s_per_m[lane.lane] = static_cast<float>(lane.share) * lane.damping_N_s_per_m;
}

/// How far a side that bears a proxy is from where even motion would have it.
Eigen::Vector3d Engine::turned_aside_m(const ToolLane& lane) const {
  const Description::Side other = description_.side(at(lane.other));
  if (lane.is_held) return field_pose(*other.field, state_).out_of(lane.centre_m) - lane.ahead_m;
  if (other.sphere == nullptr) return Eigen::Vector3d::Zero();
  return sphere_position_m(*other.sphere, state_).vector() - lane.ahead_m;
}

/// Ends a part of a tick after a share of what move_proxies() was asked for. A proxy goes with what
/// bears it. Friction is a tool sphere's own: what bears its load may change from contact to
/// contact.
void Engine::finish_proxies(double share) {
  const RowList& rows = listing_.rows();
  for (std::size_t t = 0; t < state_.proxy_stretch_m.size(); ++t) {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero(), aside_m = Eigen::Vector3d::Zero();
    double shares = 0.0, total_impulse_N_s = 0.0;
    for (const ToolLane& lane : listing_.tool_lanes()) {
      const double impulse_N_s = rows.rows[lane.row].push_impulse_N_s[lane.lane];
      if (at(lane.tool) != t || impulse_N_s <= 0.0) continue;
      total_impulse_N_s += impulse_N_s;
      aside_m += impulse_N_s * turned_aside_m(lane);
      const RowFloats(&stretch_m)[3] = rows.places[lane.row].stretch_m;
      sum_m += (lane.is_a ? lane.share : -lane.share) * Eigen::Vector3d(stretch_m[0][lane.lane],
                                                                        stretch_m[1][lane.lane],
                                                                        stretch_m[2][lane.lane]);
      shares += lane.share;
    }
    state_.proxy_stretch_m[t] = shares > 0.0 ? Vector4(sum_m / shares) : Vector4();
    state_.proxy_stretch_m[t].w = shares;
    Vector4 moved = moved_proxy_m_[t];
    if (is_held(moved) && share == 1.0 && total_impulse_N_s > 0.0)
      moved = moved + Vector4(aside_m / total_impulse_N_s);
    state_.proxy_m[t] = moved - (1.0 - share) * (moved - state_.proxy_m[t]);
  }
  for (std::size_t k = 0; k < driven_.size(); ++k)
    if (is_tool_[k] != 0) held_J_[k] = tool_energy_J(k);
}

}  // namespace stillgrid::dynamics
