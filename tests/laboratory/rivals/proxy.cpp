#include "tests/laboratory/rivals/proxy.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace stillgrid::laboratory {
namespace {

/// Times a tick that half-spaces are laid anew: along a curved surface the place comes nearer each
/// time, and the next tick goes on.
constexpr int kLayings = 2;

/// Rounds over the half-spaces of a laying, and the change at which they end.
constexpr int kRounds = 16;
constexpr double kTolerance_m = 1e-9;

}  // namespace

void Proxy::widen(std::span<rendering::PlacedToolSphere> balls) const noexcept {
  // It comes nearer to the tool only, but from any side.
  for (std::size_t i = 0; i < balls.size(); ++i)
    balls[i].radius_m += (places_m_[i] - balls[i].position_m).norm();
}

void Proxy::update(const LocalScene&, const PlacedTool&, const PlacedTool& present,
                   bool is_first) noexcept {
  if (!is_first) return;
  for (std::size_t i = 0; i < present.spheres.size(); ++i)
    places_m_[i] = present.spheres[i].position_m;
}

/// Lays the half-spaces that touch what is round `at` and may be in the way to the goal.
void Proxy::find_half_spaces(const LocalScene& scene, std::uint32_t tool_sphere,
                             const rendering::PlacedToolSphere& at,
                             const Eigen::Vector3d& goal_m) noexcept {
  // The nearest place is no farther from the goal than `at` is.
  const double search_radius_m = 2.0 * (goal_m - at.position_m).norm() + at.radius_m;
  count_ = 0;
  const auto add = [&](const rendering::ToolContact& contact, std::uint32_t material) {
    if (contact.depth_m < -search_radius_m) return;
    half_spaces_[count_++] = {contact.normal, contact.normal.dot(at.position_m) + contact.depth_m,
                              0.0, material, contact.touched_velocity_m_s};
  };
  for (const rendering::TouchedSphere& sphere : scene.patch.all())
    if (sphere.tool_sphere == tool_sphere && sphere.material < scene.fixed.material_count)
      add(rendering::contact_with(sphere, at), sphere.material);
  for (std::uint32_t i = 0; i < scene.fixed.plane_count; ++i)
    add(rendering::contact_with(scene.fixed.planes[i], at), scene.fixed.planes[i].material);
}

/// Hildreth's method: each half-space in turn pushes as much as it needs, or gives back.
Eigen::Vector3d Proxy::nearest_free_m(const Eigen::Vector3d& goal_m) noexcept {
  Eigen::Vector3d place_m = goal_m;
  for (int round = 0; round < kRounds; ++round) {
    double most_m = 0.0;
    for (HalfSpace& half : std::span(half_spaces_).first(count_)) {
      const double push_m = std::max(0.0, half.push_m + half.offset_m - half.normal.dot(place_m));
      place_m += (push_m - half.push_m) * half.normal;
      most_m = std::max(most_m, std::abs(push_m - half.push_m));
      half.push_m = push_m;
    }
    if (!(most_m > kTolerance_m)) break;
  }
  return place_m;
}

/// The contact law along the spring, with the constants of what pushes, each by its push.
void Proxy::add_spring(rendering::ToolForce& sum, const LocalScene& scene,
                       const Eigen::Vector3d& place_m, const rendering::PlacedToolSphere& probe,
                       const rendering::ToolPose& pose) const noexcept {
  LocalSurface surface{};
  double pushed_m = 0.0, most_m = 0.0;
  surface.velocity_m_s.setZero();
  for (const HalfSpace& half : std::span(half_spaces_).first(count_)) {
    if (!(half.push_m > 0.0)) continue;
    const collision::ContactMaterial material =
        rendering::contact_material(scene.fixed, half.material);
    if (half.push_m > most_m) {
      surface.material.friction = material.friction;
      surface.material.slip_speed_m_s = material.slip_speed_m_s;
      most_m = half.push_m;
    }
    surface.material.stiffness_N_per_m += half.push_m * material.stiffness_N_per_m;
    surface.material.damping_N_s_per_m += half.push_m * material.damping_N_s_per_m;
    surface.velocity_m_s += half.push_m * half.velocity_m_s;
    pushed_m += half.push_m;
  }
  const Eigen::Vector3d spring_m = place_m - probe.position_m;
  const double depth_m = spring_m.norm();
  if (!(pushed_m > 0.0) || !(depth_m > 0.0)) return;
  surface.material.stiffness_N_per_m /= pushed_m;
  surface.material.damping_N_s_per_m /= pushed_m;
  surface.velocity_m_s /= pushed_m;
  add_surface(sum, surface, depth_m, spring_m / depth_m, probe, pose);
}

rendering::ToolForce Proxy::force(const LocalScene& scene, const PlacedTool& tool) noexcept {
  rendering::ToolForce sum;
  for (std::uint32_t i = 0; i < tool.spheres.size(); ++i) {
    rendering::PlacedToolSphere at = tool.spheres[i];
    if (places_m_[i].allFinite()) at.position_m = places_m_[i];  // else a pose was no number
    for (int laying = 0; laying < kLayings; ++laying) {
      find_half_spaces(scene, i, at, tool.spheres[i].position_m);
      at.position_m = nearest_free_m(tool.spheres[i].position_m);
    }
    places_m_[i] = at.position_m;
    add_spring(sum, scene, at.position_m, tool.spheres[i], tool.pose);
  }
  return sum;
}

}  // namespace stillgrid::laboratory
