#include "tests/laboratory/rivals/penetration_volume.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace stillgrid::laboratory {
namespace {

double ball_m3(double radius_m) {
  return 4.0 / 3.0 * std::numbers::pi * radius_m * radius_m * radius_m;
}

double cap_m3(double radius_m, double height_m) {
  return std::numbers::pi / 3.0 * height_m * height_m * (3.0 * radius_m - height_m);
}

/// Where a sphere of the tool overlaps a ball, by the volume: what the contact law takes for a
/// depth is the depth at which the material's spring pushes as hard.
template <class Visit>
void for_each_overlap(const VolumeBody& body, const spheres::Ball& probe, Visit&& visit) {
  for (const std::uint32_t i : spheres::balls_near(body.balls.grid, probe.centre_m)) {
    const spheres::Ball& ball = body.balls.balls[i];
    const SphereOverlap overlap = overlap_of(ball, probe);
    const Eigen::Vector3d apart_m = probe.centre_m - ball.centre_m;
    const double distance_m = apart_m.norm();
    // Centre on centre has no direction to push in.
    if (overlap.volume_m3 > 0.0 && distance_m > 0.0)
      visit(rendering::ToolContact{.depth_m = body.pressure_per_m2 * overlap.volume_m3,
                                   .normal = apart_m / distance_m,
                                   .point_m = overlap.centroid_m,
                                   .touched_velocity_m_s = Eigen::Vector3d::Zero()});
  }
}

}  // namespace

SphereOverlap overlap_of(const spheres::Ball& a, const spheres::Ball& b) noexcept {
  const Eigen::Vector3d apart_m = b.centre_m - a.centre_m;
  const double distance_m = apart_m.norm();
  const double depth_m = a.radius_m + b.radius_m - distance_m;
  if (!(depth_m > 0.0)) return {};
  if (distance_m <= std::abs(a.radius_m - b.radius_m)) {
    const spheres::Ball& inner = a.radius_m < b.radius_m ? a : b;
    return {ball_m3(inner.radius_m), inner.centre_m};
  }
  // The lens is a cap of each, on the plane of the circle in which they meet. Moments of the caps
  // about their own centres are equal and opposite, so volumes divide the line of the centres.
  const double a_cap_m3 =
      cap_m3(a.radius_m, depth_m * (b.radius_m + distance_m - a.radius_m) / (2.0 * distance_m));
  const double b_cap_m3 =
      cap_m3(b.radius_m, depth_m * (a.radius_m + distance_m - b.radius_m) / (2.0 * distance_m));
  const double volume_m3 = a_cap_m3 + b_cap_m3;
  if (!(volume_m3 > 0.0)) return {};
  return {volume_m3, a.centre_m + b_cap_m3 / volume_m3 * apart_m};
}

VolumeBody make_volume_body(std::span<const spheres::Ball> balls,
                            const spheres::SurfaceSamples& surface, double tool_radius_m,
                            double press_depth_m) {
  VolumeBody body{spheres::make_ball_body(balls, tool_radius_m), 1.0};
  const double slope_m2 =
      spheres::map_force(surface, tool_radius_m, press_depth_m, [&](const Eigen::Vector3d& tool_m) {
        return unit_volume_force_m(body, tool_m);
      }).effective_stiffness;
  if (!(slope_m2 > 0.0))
    throw std::runtime_error("press_depth_m = " + std::to_string(press_depth_m) +
                             ": expected a depth at which overlaps grow");
  body.pressure_per_m2 = 1.0 / slope_m2;
  return body;
}

Eigen::Vector3d unit_volume_force_m(const VolumeBody& body,
                                    const Eigen::Vector3d& tool_m) noexcept {
  Eigen::Vector3d force_m = Eigen::Vector3d::Zero();
  for_each_overlap(
      body, {tool_m, body.balls.tool_radius_m},
      [&](const rendering::ToolContact& contact) { force_m += contact.depth_m * contact.normal; });
  return force_m;
}

rendering::ToolForce volume_force(const VolumeBody& body,
                                  const collision::ContactMaterial& material,
                                  std::span<const rendering::PlacedToolSphere> tool,
                                  const rendering::ToolPose& pose) noexcept {
  rendering::ToolForce sum;
  for (const rendering::PlacedToolSphere& probe : tool)
    for_each_overlap(
        body, {probe.position_m, probe.radius_m}, [&](const rendering::ToolContact& contact) {
          const Eigen::Vector3d force_N =
              collision::contact_force_N(material, contact.depth_m, contact.normal,
                                         rendering::relative_velocity_m_s(contact, pose));
          sum.force_N += force_N;
          sum.torque_N_m += (contact.point_m - pose.position_m).cross(force_N);
          ++sum.contacts;
        });
  return sum;
}

}  // namespace stillgrid::laboratory
