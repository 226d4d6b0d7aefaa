#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/energy_losses.hpp"
#include "shared/dynamics/implicit_coupling.hpp"

namespace stillgrid::dynamics {

/// The listed contacts in an implicit step: the law of materials at the end of the step. The normal
/// force acts along the mean of the lines of centres at the start and the end, so that its work is
/// exactly force times change of depth. Friction is a spring that slides at Coulomb's limit, or
/// viscous for a tool.
///
/// Thread: one. Memory is kept from step to step.
class ImplicitContacts {
 public:
  explicit ImplicitContacts(const Description& description);

  /// Reads all lanes of the listing. Realtime: allocates where there are more than ever before.
  void start(const ImplicitPoses& poses, const ContactListing& listing);
  /// Computes impulses and slopes for a step that ends at these poses.
  void evaluate(const ImplicitPoses& poses, const Motions& velocities);
  /// Predicts directions of friction after this change of velocities.
  void aim_friction(const ImplicitPoses& poses, const Motions& change);
  /// Moves directions by a share of what aim_friction() predicts.
  void turn_aims(double share);
  /// Sets the limits of friction by the pushes of the last evaluate(). Between two calls the
  /// equations are those of a convex function, so that a search along a line ends.
  void limit_friction();
  /// Whether two spheres are deeper on their ways than at both ends, by half the smaller radius.
  [[nodiscard]] bool any_passes() const;
  /// Whether every sphere ends within the way that contacts were listed for.
  [[nodiscard]] bool all_within(const ContactListing& listing) const;
  /// Adds what dampers and friction take in the step.
  void add_losses(const ImplicitPoses& poses, const Motions& velocities,
                  EnergyLosses& losses) const;
  /// Writes impulses and stretches to the rows of the listing.
  void write(RowList& rows) const;

  [[nodiscard]] const std::vector<Coupling>& couplings() const noexcept { return couplings_; }

 private:
  struct Touch {
    std::uint32_t row = 0, lane = 0;
    std::int32_t sphere_a = 0, sphere_b = -1;           // of a plane: -1
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // of a plane
    double offset_m = 0.0;                              // of a plane
    double radius_a_m = 0.0, radius_b_m = 0.0;
    double stiffness_N_per_m = 0.0, damping_N_s_per_m = 0.0, friction = 0.0, viscous_s_per_m = 0.0;
    Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // at the start
    Eigen::Vector3d line_m = Eigen::Vector3d::Zero();     // b to a at the start
    double push_N_s = 0.0, most_N_s = 0.0;  // of normal force, and of friction at its limit
    Eigen::Vector3d drag_N_s = Eigen::Vector3d::Zero(), stretch_after_m = Eigen::Vector3d::Zero();
    double hold_slope_kg = 0.0;                                     // of friction that sticks
    Eigen::Vector3d asked_N_s = Eigen::Vector3d::Zero();            // friction without a limit
    Eigen::Vector3d aim = Eigen::Vector3d::Zero(), next_aim = aim;  // friction over its limit
  };
  /// Line and distance of centres at the end, and the unit normal to side a.
  struct Line {
    Eigen::Vector3d line_m, direction, normal;
    double before_m, after_m;
  };
  void add_lane(const ContactListing& listing, const RowGroup& group, std::size_t row,
                std::size_t lane);
  [[nodiscard]] Line line_of(const Touch& touch) const;
  void evaluate(Touch& touch, Coupling& coupling, const ImplicitPoses& poses,
                const Motions& velocities) const;
  void rub(Touch& touch, Coupling& coupling, const Eigen::Vector3d& normal,
           const Eigen::Vector3d& velocity, double step_s) const;

  const Description& description_;
  std::vector<Touch> touches_;
  std::vector<Coupling> couplings_;
  std::vector<Eigen::Vector3d> before_m_, after_m_;  // centres of spheres
};

}  // namespace stillgrid::dynamics
