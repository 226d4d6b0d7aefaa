#include "shared/rendering/tool_proxies.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "shared/collision/proxy_load.hpp"

namespace stillgrid::rendering {
namespace {

using Eigen::Vector3d;

// Of the tool sphere's radius: the way of a proxy near a field, which is looked at once a tick.
constexpr double kInField = 0.25;

/// Velocity by which a surface carries a proxy. No touched surface is faster, whatever a snapshot
/// says.
Vector3d carrying_m_s(const Vector3d& surface_m_s) noexcept {
  constexpr double kFastest_m_s = 100.0;
  return surface_m_s.squaredNorm() <= kFastest_m_s * kFastest_m_s ? surface_m_s : Vector3d::Zero();
}

bool has_penalty(const proto::SceneHeader& scene) noexcept {
  return scene.tool_slip_speed_m_s > 0.0F;
}

}  // namespace

/// The load of a proxy, with the parts that bodies which never move and soft bodies carry.
struct ToolProxies::Load : collision::ProxyLoad {
  double static_N = 0.0;
  // Soft bodies with a limit. A tool sphere touches few at once.
  struct Soft {
    std::uint32_t body;
    double crushing_N;
    Vector3d press_N;
  };
  std::array<Soft, 4> soft;
  std::size_t soft_count = 0;

  void press(const TouchedSphere& sphere, const Vector3d& force_N) noexcept {
    if (!(sphere.crushing_force_N > 0.0F)) return;
    const auto known = std::span(soft).first(soft_count);
    const auto it = std::ranges::find(known, sphere.body, &Soft::body);
    if (it != known.end())
      it->press_N += force_N;
    else if (soft_count < soft.size())
      soft[soft_count++] = {sphere.body, double{sphere.crushing_force_N}, force_N};
  }
  [[nodiscard]] bool is_crushing() const noexcept {
    return std::ranges::any_of(std::span(soft).first(soft_count),
                               [](const Soft& one) { return one.press_N.norm() > one.crushing_N; });
  }
};

/// Adds the force of one half-space, without friction.
void ToolProxies::add_push(const Surface& surface, const collision::HalfSpace& space,
                           const PlacedToolSphere& device, const ToolPose& pose, ToolForce& sum,
                           Load& load) noexcept {
  const auto& [sphere, plane, material, energy_share] = surface;
  const double share = energy_share * space.push_m / space.depth_m;
  const Vector3d touched_m_s = sphere == nullptr ? Vector3d::Zero() : sphere->velocity_m_s;
  const ToolContact contact{.depth_m = space.depth_m,
                            .normal = space.normal,
                            .point_m = device.position_m - device.radius_m * space.normal,
                            .touched_velocity_m_s = touched_m_s};
  collision::ContactMaterial smooth = material;
  smooth.friction = 0.0;
  add_contact(sum, smooth, contact, pose, share);
  const double push_N =
      load.add(material, space, energy_share, touched_m_s, relative_velocity_m_s(contact, pose));
  if (sphere != nullptr) load.press(*sphere, push_N * space.normal);
  if (plane == nullptr && (sphere == nullptr || !sphere->is_static)) return;
  load.static_N += push_N;
  sum.static_J += 0.5 * push_N * space.depth_m;
}

void ToolProxies::place(const proto::SceneHeader& scene, const ToolPose& pose,
                        bool may_lose) noexcept {
  may_lose_ = may_lose;
  const std::span<PlacedToolSphere> tool = place_tool(scene, pose, placed_);
  for (std::size_t i = 0; i < tool.size(); ++i) {
    Proxy& proxy = proxies_[i];
    const bool is_new = !has_proxies_ || i >= count_ || has_penalty(scene);
    if (is_new) {
      proxy = {};
      proxy.position_m = proxy.device_m = tool[i].position_m;
    }
    const double way_m = (tool[i].position_m - proxy.device_m).norm();
    proxy.longest_m = collision::kLayings *
                      collision::longest_move_m(tool[i].radius_m, way_m / collision::kLayings);
    proxy.from_m = proxy.device_m;
    proxy.is_given = proxy.is_own = false;
    reach_[i] = tool[i];
    if (!has_penalty(scene)) set_reach(i);
  }
  count_ = tool.size();
  has_proxies_ = true;
}

void ToolProxies::set_reach(std::size_t tool_sphere) noexcept {
  const Proxy& proxy = proxies_[tool_sphere];
  const PlacedToolSphere& device = placed_[tool_sphere];
  const double behind_m = (device.position_m - proxy.position_m).norm();
  reach_[tool_sphere] = {proxy.position_m, device.radius_m + std::min(behind_m, proxy.longest_m),
                         device.radius_m, device.position_m};
}

void ToolProxies::begin_at(std::span<const dynamics::Vector4> proxies_m, bool knows_all) noexcept {
  for (std::size_t i = 0; i < std::min(count_, proxies_m.size()); ++i) {
    proxies_[i].is_own = !knows_all && !proxies_[i].is_of_given;
    if (proxies_[i].is_own) continue;
    const Vector3d& device_m = placed_[i].position_m;
    const double own_m = (proxies_[i].position_m - device_m).norm();
    const double given_m = (proxies_m[i].vector() - device_m).norm();
    // A tool that is new in the simulation is let out of a wall. The own proxy may be out already.
    if (proxies_m[i].w == 0.0 || (proxies_m[i].w < 1.0 && given_m < own_m)) continue;
    proxies_[i].position_m = proxies_m[i].vector();
    proxies_[i].from_m = placed_[i].position_m;
    proxies_[i].is_given = true;
    set_reach(i);
  }
}

/// Lays the surface of those spheres that pushed the proxy and have gone or jumped.
void ToolProxies::find_lost(const TouchedSpheres& touched, std::uint32_t tool_sphere,
                            double tick_s) noexcept {
  Proxy& proxy = proxies_[tool_sphere];
  LostSurface& lost = proxy.lost;
  lost.depth_m = std::max(0.0, lost.depth_m - collision::kLeaving_m_s * tick_s);
  Vector3d lost_N = Vector3d::Zero();
  double most_N = 0.0;
  for (const Pusher& pusher : std::span(pushers_[tool_sphere]).first(proxy.pusher_count)) {
    const Vector3d goes_m = pusher.position_m + tick_s * pusher.velocity_m_s;
    const auto is_it = [&](const TouchedSphere& sphere) {
      return sphere.tool_sphere == tool_sphere && sphere.number == pusher.number &&
             sphere.body == pusher.body && sphere.material == pusher.material_number &&
             sphere.radius_m == pusher.radius_m &&
             (sphere.position_m - goes_m).norm() < 0.5 * pusher.radius_m;
    };
    // What goes out of reach is not lost.
    const PlacedToolSphere& reach = reach_[tool_sphere];
    if (!((goes_m - reach.position_m).norm() < gathered_within_m(reach, pusher.radius_m)) ||
        std::ranges::any_of(touched.all(), is_it))
      continue;
    lost_N += pusher.push_N;
    if (std::exchange(most_N, std::max(most_N, pusher.push_N.norm())) < most_N)
      lost.material = pusher.material;
  }
  if (!(most_N > 0.0)) return;
  lost.normal = lost_N.stableNormalized();
  lost.depth_m =
      std::max(lost.depth_m, lost.normal.dot(proxy.position_m - placed_[tool_sphere].position_m));
  lost.material.friction = lost.material.damping_N_s_per_m = 0.0;
}

/// Keeps what pushes a proxy for find_lost().
void ToolProxies::remember(std::size_t tool_sphere, std::size_t count) noexcept {
  Proxy& proxy = proxies_[tool_sphere];
  proxy.pusher_count = 0;
  proxy.is_of_given = true;
  bool is_held_by_lost = false;
  for (std::size_t k = 0; k < count; ++k) {
    if (!(spaces_[k].push_m > 0.0)) continue;
    const auto& [sphere, plane, material, energy_share] = surfaces_[k];
    proxy.is_of_given = proxy.is_of_given && sphere != nullptr && sphere->is_given;
    if (sphere == nullptr) is_held_by_lost = is_held_by_lost || plane == nullptr;
    if (sphere == nullptr || sphere->is_static || sphere->field != 0 ||
        proxy.pusher_count == kPushers)
      continue;
    pushers_[tool_sphere][proxy.pusher_count++] = {
        sphere->number,
        sphere->body,
        sphere->material,
        sphere->radius_m,
        sphere->position_m,
        sphere->velocity_m_s,
        energy_share * material.stiffness_N_per_m * spaces_[k].push_m * spaces_[k].normal,
        material};
  }
  if (!is_held_by_lost) proxy.lost.depth_m = 0.0;
}

std::size_t ToolProxies::find_surfaces(const proto::SceneHeader& scene,
                                       const TouchedSpheres& touched,
                                       std::uint32_t tool_sphere) noexcept {
  std::size_t count = 0;
  for (const TouchedSphere& sphere : touched.all())
    // A tick may show the spheres of the tick before, gathered for a tool of another scene.
    if (sphere.tool_sphere == tool_sphere && sphere.material < scene.material_count &&
        sphere.presence > 0.0)
      surfaces_[count++] = {&sphere, nullptr, contact_material(scene, sphere.material),
                            sphere.energy_share};
  for (std::uint32_t i = 0; i < scene.plane_count; ++i)
    surfaces_[count++] = {nullptr, &scene.planes[i],
                          contact_material(scene, scene.planes[i].material), 1.0};
  const LostSurface& lost = proxies_[tool_sphere].lost;
  if (lost.depth_m > 0.0) surfaces_[count++] = {nullptr, nullptr, lost.material, 1.0};
  return count;
}

/// The half-space of the lost surface, which goes with the tool.
collision::HalfSpace ToolProxies::lost_space(std::size_t tool_sphere, const PlacedToolSphere& proxy,
                                             collision::TickPart part) const noexcept {
  const Vector3d &from_m = proxies_[tool_sphere].from_m, &to_m = placed_[tool_sphere].position_m;
  const Vector3d device_m = from_m + part.from * (to_m - from_m);
  const LostSurface& lost = proxies_[tool_sphere].lost;
  return {.normal = lost.normal,
          .gap_m = lost.normal.dot(proxy.position_m - device_m) - lost.depth_m,
          .moved_m = part.share() * (to_m - from_m)};
}

std::span<collision::HalfSpace> ToolProxies::lay(std::size_t tool_sphere,
                                                 const PlacedToolSphere& proxy, std::size_t count,
                                                 double tick_s, collision::TickPart part) noexcept {
  // Surfaces are seen as at the end of the tick.
  const double ahead_s = (1.0 - part.from) * tick_s;
  for (std::size_t k = 0; k < count; ++k) {
    const auto& [sphere, plane, material, energy_share] = surfaces_[k];
    const bool is_field = sphere != nullptr && sphere->field != 0;
    if (sphere == nullptr && plane == nullptr) {
      spaces_[k] = lost_space(tool_sphere, proxy, part);
      seen_[k] = {};
      continue;
    }
    PlacedToolSphere at = proxy;  // a field is flat around where it was sampled
    const Vector3d surface_m_s =
        sphere == nullptr ? Vector3d(Vector3d::Zero()) : carrying_m_s(sphere->velocity_m_s);
    const Vector3d ahead_m = ahead_s * surface_m_s;
    at.position_m =
        is_field ? reach_[sphere->tool_sphere].position_m : Vector3d(proxy.position_m + ahead_m);
    const ToolContact contact =
        plane != nullptr ? contact_with(*plane, at) : contact_with(*sphere, at);
    spaces_[k] = {
        .normal = contact.normal,
        .gap_m = contact.normal.dot(proxy.position_m + ahead_m - at.position_m) - contact.depth_m,
        .moved_m = part.share() * tick_s * surface_m_s};
    seen_[k] = {};
    if (sphere == nullptr || is_field) continue;
    seen_[k].body = static_cast<int>(sphere->body);
    seen_[k].radius_m = sphere->radius_m;
    seen_[k].line_m = at.position_m - sphere->position_m;
  }
  const std::span<collision::HalfSpace> spaces(spaces_.data(), count);
  cover_.lay(proxy.radius_m, {seen_.data(), count}, spaces);
  return spaces;
}

/// The longest displacement of a proxy in a tick between the places where fields were sampled.
double ToolProxies::longest_near_fields_m(std::span<const collision::HalfSpace> spaces,
                                          double radius_m) const noexcept {
  double longest_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < spaces.size(); ++k) {
    const TouchedSphere* const sphere = surfaces_[k].sphere;
    if (sphere != nullptr && sphere->field != 0)
      longest_m = std::min(longest_m, kInField * radius_m + std::max(0.0, spaces[k].gap_m));
  }
  return longest_m;
}

void ToolProxies::add_forces(std::size_t tool_sphere, std::size_t count, const ToolPose& pose,
                             double tick_s, const dynamics::Vector4* stretch_m,
                             ToolForce& sum) noexcept {
  Proxy& proxy = proxies_[tool_sphere];
  const PlacedToolSphere& device = placed_[tool_sphere];
  Load load;
  for (std::size_t k = 0; k < count; ++k)
    if (spaces_[k].push_m > 0.0) add_push(surfaces_[k], spaces_[k], device, pose, sum, load);
  const Vector3d moved_m = device.position_m - proxy.device_m;
  proxy.device_m = device.position_m;
  const bool touches = load.spring_N.norm() > 0.0;
  if (!std::exchange(proxy.touches, touches) || !proxy.touches) proxy.friction = {};
  if (stretch_m != nullptr) proxy.friction.stretch_m = stretch_m->vector();
  sum.is_crushing = sum.is_crushing || load.is_crushing();
  auto pull = load.pull(proxy.position_m - device.position_m, moved_m, tick_s);
  if (!pull) return;
  if (stretch_m != nullptr) pull->moved_m.setZero();  // its stretch is that of this tick
  const Vector3d friction_N = proxy.friction.force_N(*pull);
  const Vector3d lever_m = device.position_m - device.radius_m * pull->normal - pose.position_m;
  sum.force_N += friction_N;
  sum.torque_N_m += lever_m.cross(friction_N);
  sum.static_J += 0.5 * load.static_N / load.weight_N * pull->stiffness_N_per_m *
                  proxy.friction.stretch_m.squaredNorm();
}

ToolForce ToolProxies::press(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                             const ToolPose& pose, double tick_s,
                             std::span<const dynamics::Vector4> stretches_m) noexcept {
  if (has_penalty(scene)) return tool_force(scene, touched, {placed_.data(), count_}, pose);
  ToolForce sum;
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (may_lose_) find_lost(touched, i, tick_s);
    const std::size_t count = find_surfaces(scene, touched, i);
    PlacedToolSphere at{proxies_[i].position_m, placed_[i].radius_m};
    const double since_s = proxies_[i].is_given ? 0.0 : tick_s;
    collision::DeviceMove device{proxies_[i].from_m, placed_[i].position_m, at.radius_m, since_s};
    proxies_[i].position_m = collision::follow(
        at.position_m, device, [&](const Vector3d& proxy_m, collision::TickPart part) {
          at.position_m = proxy_m;
          const std::span<collision::HalfSpace> spaces = lay(i, at, count, since_s, part);
          if (part.from == 0.0) device.longest_m = longest_near_fields_m(spaces, at.radius_m);
          return spaces;
        });
    cover_.share({spaces_.data(), count});
    // One of w = 0 touches nothing there that may move.
    const bool is_known = i < stretches_m.size() && stretches_m[i].w != 0.0 && !proxies_[i].is_own;
    add_forces(i, count, pose, tick_s, is_known ? &stretches_m[i] : nullptr, sum);
    if (may_lose_) remember(i, count);
  }
  return sum;
}

}  // namespace stillgrid::rendering
