#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace stillgrid::dynamics {

/// Three numbers and one more, of the size of a vector register.
struct alignas(32) Vector4 {
  double x = 0.0, y = 0.0, z = 0.0, w = 0.0;

  Vector4() = default;
  Vector4(double x_, double y_, double z_, double w_ = 0.0) : x(x_), y(y_), z(z_), w(w_) {}
  explicit Vector4(const Eigen::Vector3d& v) : x(v.x()), y(v.y()), z(v.z()) {}
  explicit Vector4(const Eigen::Quaterniond& q) : x(q.x()), y(q.y()), z(q.z()), w(q.w()) {}

  [[nodiscard]] Eigen::Vector3d vector() const { return {x, y, z}; }
  [[nodiscard]] Eigen::Quaterniond quaternion() const { return {w, x, y, z}; }

  friend Vector4 operator+(const Vector4& a, const Vector4& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w};
  }
  friend Vector4 operator-(const Vector4& a, const Vector4& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
  }
  friend Vector4 operator*(double s, const Vector4& a) {
    return {s * a.x, s * a.y, s * a.z, s * a.w};
  }
};

/// How fast contacts, but those of balls, change the velocities of the bodies they push: the most
/// of all of them in a tick.
struct ContactRates {
  double stiffness_per_s2 = 0.0, damping_per_s = 0.0;
};

/// Positions and velocities of all nodes and rigid bodies, in SI units and the frame of the world.
/// Arrays are in the order of Description. w is zero but in quaternions.
struct SceneState {
  std::uint64_t tick = 0;  // ticks since the start
  ContactRates contacts;   // last tick
  std::vector<Vector4> node_position_m, node_velocity_m_s;
  std::vector<Vector4> rigid_position_m, rigid_velocity_m_s;  // centre of mass
  std::vector<Vector4> orientation;                           // unit quaternions
  std::vector<Vector4> angular_velocity_rad_s;
  std::vector<std::uint8_t> is_here;  // 0: a driven body that is away
  // Spheres of tools that have proxies. A proxy's w is 1 if a surface holds it back and 0 if it is
  // at its sphere. A w between them says that the proxy is still let out of a surface. The stretch
  // is that of friction. Its w is 0 if the sphere touches no body that may move.
  std::vector<Vector4> proxy_m, proxy_stretch_m;

  /// Returns the arrays of positions, velocities, orientations and proxies. Realtime: yes.
  [[nodiscard]] std::array<const std::vector<Vector4>*, 8> vectors() const noexcept {
    return {&node_position_m, &node_velocity_m_s,      &rigid_position_m, &rigid_velocity_m_s,
            &orientation,     &angular_velocity_rad_s, &proxy_m,          &proxy_stretch_m};
  }
};

/// Returns a number of the tick and of all positions, velocities and bodies that are here. States
/// of one scene that differ in one of these numbers have other hashes, and but for chance all that
/// differ. 0.0 and -0.0 differ. Realtime: yes.
[[nodiscard]] std::uint64_t hash(const SceneState& state);

}  // namespace stillgrid::dynamics
