#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "shared/dynamics/engine.hpp"

namespace stillgrid::dynamics {

/// A description and a state that grow together.
struct EngineScene {
  Description description;
  SceneState state;

  EngineScene() { description.materials.push_back({1000.0, 2.0, 0.5}); }

  /// Adds a rigid body of mass_kg; returns its index.
  int add_rigid(double mass_kg, const Eigen::Vector3d& inertia_kg_m2,
                const Eigen::Vector3d& position_m, bool is_driven = false) {
    description.rigid_bodies.push_back({mass_kg, inertia_kg_m2, is_driven});
    state.rigid_position_m.emplace_back(position_m);
    state.rigid_velocity_m_s.emplace_back();
    state.orientation.emplace_back(Eigen::Quaterniond::Identity());
    state.angular_velocity_rad_s.emplace_back();
    return static_cast<int>(description.rigid_bodies.size()) - 1;
  }
  /// Adds a sphere to a rigid body. Each rigid body is a body of its own.
  void add_sphere(int rigid, double radius_m,
                  const Eigen::Vector3d& local_m = Eigen::Vector3d::Zero()) {
    Description::Sphere sphere;
    sphere.radius_m = radius_m;
    sphere.rigid = sphere.body = rigid;
    sphere.local_m = local_m;
    description.spheres.push_back(sphere);
  }
  /// Adds a ball of 1000 kg/m^3; returns its rigid body.
  int add_ball(double radius_m, const Eigen::Vector3d& position_m) {
    const double mass_kg = 1000.0 * 4.0 / 3.0 * M_PI * std::pow(radius_m, 3);
    const double inertia = 0.4 * mass_kg * radius_m * radius_m;
    const int rigid = add_rigid(mass_kg, Eigen::Vector3d::Constant(inertia), position_m);
    add_sphere(rigid, radius_m);
    return rigid;
  }
  /// Adds a block of 2 x 2 x 2 spheres whose inertia is that of a box; returns its rigid body.
  int add_block(double mass_kg, const Eigen::Vector3d& size_m, const Eigen::Vector3d& position_m) {
    const Eigen::Vector3d square = size_m.cwiseProduct(size_m);
    const int rigid = add_rigid(
        mass_kg, mass_kg / 12.0 * (Eigen::Vector3d::Constant(square.sum()) - square), position_m);
    const double radius_m = 0.25 * size_m.minCoeff();
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      add_sphere(rigid, radius_m,
                 sign.cwiseProduct(0.5 * size_m - Eigen::Vector3d::Constant(radius_m)));
    }
    return rigid;
  }
  /// Adds a node; returns its index.
  int add_node(double mass_kg, const Eigen::Vector3d& position_m, bool is_pinned = false) {
    description.nodes.push_back({mass_kg, is_pinned});
    state.node_position_m.emplace_back(position_m);
    state.node_velocity_m_s.emplace_back();
    return static_cast<int>(description.nodes.size()) - 1;
  }
  void add_spring(int a, int b, double stiffness_N_per_m, double damping_N_s_per_m = 0.0) {
    const double rest_m = (state.node_position_m[static_cast<std::size_t>(a)] -
                           state.node_position_m[static_cast<std::size_t>(b)])
                              .vector()
                              .norm();
    description.springs.push_back({a, b, rest_m, stiffness_N_per_m, damping_N_s_per_m});
  }
  /// Covers one to four nodes by a sphere at their mean. body: for who collides.
  void cover(const std::vector<int>& nodes, double radius_m, int body) {
    Description::Sphere sphere;
    sphere.radius_m = radius_m;
    sphere.body = body;
    sphere.node_count = static_cast<int>(nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      sphere.nodes[k] = nodes[k];
      sphere.weights[k] = 1.0 / static_cast<double>(nodes.size());
    }
    description.spheres.push_back(sphere);
  }
  void add_plane(const Eigen::Vector3d& normal, double offset_m) {
    description.planes.push_back({normal, offset_m, 0});
  }
  void with_gravity() { description.gravity_m_s2 = {0.0, 0.0, -9.81}; }

  [[nodiscard]] Engine engine(EngineMethod method = {}) const {
    return {description, state, method};
  }
};

/// Adds bodies that fall into a bin, in ten layers. add(position_m, between) adds one; between(low,
/// high) draws a number. Seed 17.
template <class Add>
void fall_into_bin(EngineScene& scene, int count, double spacing_m, const Add& add) {
  scene.with_gravity();
  std::mt19937_64 random(17);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const int layer = (count + 9) / 10;
  const int columns = static_cast<int>(std::ceil(std::sqrt(layer)));
  const int rows = (layer + columns - 1) / columns;
  for (int i = 0; i < count; ++i) {
    const int place = i % layer;
    Eigen::Vector3d at = spacing_m * Eigen::Vector3d(place % columns, place / columns, i / layer);
    for (double& coordinate : at) coordinate += 0.5 * spacing_m + between(0.0, 4e-4);
    add(at, between);
  }
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  scene.add_plane(Eigen::Vector3d::UnitX(), 0.0);
  scene.add_plane(-Eigen::Vector3d::UnitX(), -spacing_m * columns);
  scene.add_plane(Eigen::Vector3d::UnitY(), 0.0);
  scene.add_plane(-Eigen::Vector3d::UnitY(), -spacing_m * rows);
}

/// Balls of 8 to 12 mm that fall into a bin.
inline EngineScene falling_pile(int count) {
  EngineScene scene;
  fall_into_bin(scene, count, 2.05 * 0.012, [&](const Eigen::Vector3d& at, const auto& between) {
    scene.add_ball(between(0.008, 0.012), at);
  });
  return scene;
}

}  // namespace stillgrid::dynamics
