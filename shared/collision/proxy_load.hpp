#pragma once

#include <Eigen/Core>
#include <optional>

#include "shared/collision/contact_law.hpp"
#include "shared/collision/tool_proxy.hpp"

namespace stillgrid::collision {

/// The springs of all half-spaces that push one proxy. Friction acts on a proxy as a whole, because
/// another sphere may carry its load in the next tick. Both processes sum by it. Realtime: yes.
struct ProxyLoad {
  Eigen::Vector3d spring_N = Eigen::Vector3d::Zero();
  // Velocities of the touched points, and of the tool relative to them, times the springs' forces.
  Eigen::Vector3d weighted_touched = Eigen::Vector3d::Zero();
  Eigen::Vector3d weighted_slip = Eigen::Vector3d::Zero();
  double weight_N = 0.0, limit_N = 0.0, damping_N_s_per_m = 0.0;

  /// Adds a half-space with a push. energy_share: that of its spring. slip_m_s: velocity of the
  /// tool relative to the touched point. Returns the force of the spring, N.
  double add(const ContactMaterial& material, const HalfSpace& space, double energy_share,
             const Eigen::Vector3d& touched_m_s, const Eigen::Vector3d& slip_m_s) noexcept {
    const double share = energy_share * space.push_m / space.depth_m;
    const double push_N = energy_share * material.stiffness_N_per_m * space.push_m;
    spring_N += push_N * space.normal;
    weighted_touched += push_N * touched_m_s;
    weighted_slip += push_N * slip_m_s;
    weight_N += push_N;
    damping_N_s_per_m += share * material.damping_N_s_per_m;
    limit_N += share * material.friction *
               normal_force_N(material, space.depth_m, -space.normal.dot(slip_m_s));
    return push_N;
  }

  /// Returns the pull of a tick on friction, if a spring pushes the tool back. The place of the
  /// proxy beside its tool sphere is behind_m. The displacement of that sphere is moved_m.
  [[nodiscard]] std::optional<StickingFriction::Pull> pull(const Eigen::Vector3d& behind_m,
                                                           const Eigen::Vector3d& moved_m,
                                                           double tick_s) const noexcept {
    const double press_N = spring_N.norm();
    if (!(press_N > 0.0)) return std::nullopt;
    const Eigen::Vector3d normal = spring_N / press_N;
    const double depth_m = normal.dot(behind_m);
    if (!(depth_m > 0.0)) return std::nullopt;
    return StickingFriction::Pull{.moved_m = moved_m - tick_s / weight_N * weighted_touched,
                                  .velocity_m_s = weighted_slip / weight_N,
                                  .normal = normal,
                                  .stiffness_N_per_m = press_N / depth_m,
                                  .damping_N_s_per_m = damping_N_s_per_m,
                                  .limit_N = limit_N};
  }
};

}  // namespace stillgrid::collision
