#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/shared/dynamics/engine_scenes.hpp"

namespace stillgrid::performance {

/// Free rigid bodies, planes and joints that every engine simulates.
struct PeerScene {
  dynamics::EngineScene ours;          // masses, positions, planes and joints hold for all engines
  std::vector<Eigen::Vector3d> box_m;  // edges of each rigid body; empty: bodies are balls or links
};
/// Returns boxes of 16 to 24 mm that fall into a bin, as dynamics::falling_pile() does with balls.
/// In our engine they are exact shapes, as the body kind "rigid_box" is by default.
[[nodiscard]] PeerScene falling_boxes(int count);
/// Returns links of 30 mm and 10 g that hang from the world on ball joints, one below the other.
/// Gravity is turned by 45 degrees, so that they swing.
[[nodiscard]] PeerScene hanging_links(int count, double stiffness_N_per_m);

struct Pose {
  Eigen::Vector3d position_m;
  Eigen::Quaterniond orientation;
};

/// A scene in one engine.
class PeerWorld {
 public:
  PeerWorld() = default;
  virtual ~PeerWorld() = default;
  PeerWorld(const PeerWorld&) = delete;
  PeerWorld& operator=(const PeerWorld&) = delete;

  /// Advances by 10 ms.
  virtual void step() = 0;
  /// Returns the pose of each rigid body, in the order of the scene.
  [[nodiscard]] virtual std::vector<Pose> poses() const = 0;
};

[[nodiscard]] std::unique_ptr<PeerWorld> our_world(const PeerScene& scene, int threads,
                                                   const dynamics::EngineMethod& method);

struct BulletMethod {
  int substeps = 1, iterations = 10;  // in 10 ms, in a substep
};
[[nodiscard]] std::unique_ptr<PeerWorld> bullet_world(const PeerScene& scene, BulletMethod method);

struct MujocoMethod {
  int substeps = 5;               // in 10 ms; 5 is MuJoCo's default
  double time_constant_s = 0.02;  // for contacts; its default
  std::string integrator = "Euler";
  std::string solver = "Newton";
};
/// Throws std::runtime_error where MuJoCo refuses the scene.
[[nodiscard]] std::unique_ptr<PeerWorld> mujoco_world(const PeerScene& scene,
                                                      const MujocoMethod& method);

/// Returns the mean depth in mm of pairs of bodies that overlap. Bullet's collision detection
/// measures the poses of every engine.
[[nodiscard]] double overlap_mm(const PeerScene& scene, std::span<const Pose> poses);

}  // namespace stillgrid::performance
