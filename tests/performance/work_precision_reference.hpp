#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "tests/performance/work_precision_run.hpp"
#include "tests/performance/work_precision_scenes.hpp"

namespace stillgrid::performance {

/// A world of masses and springs, moved on by the classical Runge-Kutta method of order 4. It
/// shares no code with the integrators that are held against it.
class SpringReference {
 public:
  explicit SpringReference(const bodies::World& world);

  /// Moves on to time_s by equal steps of at most step_s.
  void advance_to(double time_s, double step_s);

  [[nodiscard]] const Eigen::Matrix3Xd& positions_m() const noexcept { return positions_m_; }
  /// Adds to where free nodes are, a column each.
  void shift(const Eigen::Matrix3Xd& shift_m);

  /// Half of 2 / w, w being a bound on all frequencies whatever the shape.
  [[nodiscard]] double stable_step_s() const;

 private:
  void accelerate(const Eigen::Matrix3Xd& positions_m, const Eigen::Matrix3Xd& velocities_m_s,
                  Eigen::Matrix3Xd& accelerations_m_s2) const;
  void step(double step_s);

  std::vector<bodies::Spring> springs_;
  Eigen::Vector3d gravity_m_s2_;
  std::vector<double> inverse_masses_;  // zero: pinned
  Eigen::Matrix3Xd positions_m_, velocities_m_s_;
  Eigen::Matrix3Xd moved_m_, speeds_m_s_, slope_m_s2_, sum_m_, sum_m_s_;
  double time_s_ = 0.0;
};

/// Where a scene truly goes, as far as it is known.
struct Reference {
  std::vector<Eigen::Matrix3Xd> places_m;  // at the scene's early, end and rest times
  double step_s = 0.0;                     // zero: a formula's
  Errors on_halving;                       // how far halving its step moved it
  Errors disturbed;  // how far it is moved by a shift of 1e-6 m rms, seeded, of every free node
};
inline constexpr double kDisturbance_m = 1e-6;

/// Of masses and springs by SpringReference, of contacts by our own velocity Verlet with substeps
/// a tenth as long as the finest that the chart has time for.
[[nodiscard]] Reference make_reference(const ChartScene& scene);

}  // namespace stillgrid::performance
