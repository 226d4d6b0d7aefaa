#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::performance {

/// A rigid sphere that begins at rest.
struct PileSphere {
  Eigen::Vector3d position_m;
  double radius_m;
  double mass_kg;
};

/// Rigid spheres of 8 to 12 mm on a floor, z upwards: the same for every engine.
struct Pile {
  std::vector<PileSphere> spheres;
  Eigen::Vector2d bin_m =
      Eigen::Vector2d::Zero();  // inner size, one corner at the origin; zero: none
  double friction = 0.5;
};

inline constexpr double kPileStep_s = 0.01, kPileGravity_m_s2 = 9.81;

/// Ten layers in a bin, a little apart and out of line: they fall into a pile that is as deep
/// however many there are. Never sleeping.
[[nodiscard]] Pile falling_pile(int count);
/// One layer on an open floor, apart from each other: what may sleep does so soon.
[[nodiscard]] Pile lying_spheres(int count);

/// An engine that moves a pile on.
class PileEngine {
 public:
  PileEngine() = default;
  PileEngine(const PileEngine&) = delete;
  PileEngine& operator=(const PileEngine&) = delete;
  PileEngine(PileEngine&&) = delete;
  PileEngine& operator=(PileEngine&&) = delete;
  virtual ~PileEngine() = default;

  /// One step of kPileStep_s, to where a display could show it.
  virtual void step() = 0;
  [[nodiscard]] virtual int touching() const = 0;  // pairs, the floor's and the walls' too
  [[nodiscard]] virtual int sleeping() const = 0;
  [[nodiscard]] virtual double mean_height_m() const = 0;
};

/// Stillgrid: what sim_server does of a period, publication included; with a prediction of the next
/// step if `predicts`, by so many threads.
[[nodiscard]] std::unique_ptr<PileEngine> our_pile(const Pile& pile, bool may_sleep, bool predicts,
                                                   int threads = 1);
/// Bullet's rigid bodies (3.24): sequential impulses, ten iterations, contacts without give,
/// lengths in centimetres.
[[nodiscard]] std::unique_ptr<PileEngine> bullet_pile(const Pile& pile, bool may_sleep);
/// MuJoCo (2.2.2) by conjugate gradients over elliptic cones, its defaults otherwise; it has no
/// sleep. Null where the build has no MuJoCo, or it no room for as many: 400 at most.
[[nodiscard]] std::unique_ptr<PileEngine> mujoco_pile(const Pile& pile);

}  // namespace stillgrid::performance
