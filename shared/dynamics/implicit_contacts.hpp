#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/energy_losses.hpp"
#include "shared/dynamics/field_geometry.hpp"
#include "shared/dynamics/implicit_coupling.hpp"

namespace stillgrid::dynamics {

/// The listed contacts in an implicit step: the law of materials at the end of the step. The normal
/// force acts along the mean of the lines of centres at the start and the end. Its work is exactly
/// force times change of depth. Friction is a spring that slides at Coulomb's limit, or
/// viscous for a tool. A distance field is evaluated at the end of the step, as a tangent sphere.
///
/// The same law at an instant is for methods that integrate it: see evaluate_instant().
///
/// Thread: one. Memory is kept from step to step.
class ImplicitContacts {
 public:
  explicit ImplicitContacts(const Description& description);

  /// Leaves spheres that sleep where they are.
  void leave_out(std::span<const std::uint8_t> sleeping_spheres);
  /// Reads all lanes of the listing. Realtime: allocates where there are more than ever before.
  void start(const ImplicitPoses& poses, const ContactListing& listing);
  /// Turns the stretches of friction with their bodies, by half of the step.
  void turn_stretches(const ImplicitPoses& poses);
  /// Places spheres and fields at the end of the step.
  void move(const ImplicitPoses& poses);
  /// Writes the stretches of friction at the start, m: one column for each contact.
  void write_stretches(Eigen::Ref<Eigen::Matrix3Xd> stretches_m) const;
  /// Computes the forces at an instant, as impulses of one second, where the step would end at it.
  /// Writes the velocities of stretches, and adds the losses of one second in J. Friction is a
  /// spring with a damper, in line with a slider at Coulomb's limit. While the slider moves, the
  /// damper sets the velocity of the spring. The damper is at least 10 us times the stiffness.
  /// Realtime: yes.
  void evaluate_instant(const ImplicitPoses& poses, const Motions& velocities,
                        const Eigen::Ref<const Eigen::Matrix3Xd>& stretches_m,
                        Eigen::Ref<Eigen::Matrix3Xd> rates_m_s, EnergyLosses& powers);
  /// Computes impulses and slopes for a step that ends at these poses.
  void evaluate(const ImplicitPoses& poses, const Motions& velocities);
  /// Predicts directions of friction after this change of velocities.
  void aim_friction(const ImplicitPoses& poses, const Motions& change);
  /// Moves directions by a share of the change that aim_friction() predicts.
  void turn_aims(double share);
  /// Sets the limits of friction by the pushes of the last evaluate(). Between two calls the
  /// equations are those of a convex function, so that a search along a line ends.
  void limit_friction();
  /// Whether two spheres are deeper on their paths than at both ends, by 1 % of the smaller radius.
  [[nodiscard]] bool any_passes() const;
  /// Whether every sphere ends within the way that contacts were listed for.
  [[nodiscard]] bool all_within(const ContactListing& listing) const;
  /// Adds the losses by dampers and friction in the step.
  void add_losses(const ImplicitPoses& poses, const Motions& velocities,
                  EnergyLosses& losses) const;
  /// Writes impulses and stretches to the rows of the listing.
  void write(RowList& rows) const;
  /// Writes how far spheres have moved since the listing.
  void write_places(const ContactListing& listing, std::vector<SpherePlace>& places) const;

  [[nodiscard]] const std::vector<Coupling>& couplings() const noexcept { return couplings_; }

 private:
  struct Touch {
    std::uint32_t row = 0, lane = 0;
    std::int32_t sphere_a = 0, sphere_b = -1;  // -1 for a plane or a field
    std::int32_t field = -1;                   // index into Description::fields
    // See ToolLane.
    Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  // moves side a, seen from side b
    bool is_held = false;
    Eigen::Vector3d held_centre_m = Eigen::Vector3d::Zero();
    double held_scale = 1.0;
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // the plane's
    double offset_m = 0.0;                              // the plane's
    double radius_a_m = 0.0, radius_b_m = 0.0;
    double stiffness_N_per_m = 0.0, damping_N_s_per_m = 0.0, friction = 0.0, viscous_s_per_m = 0.0;
    Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();     // at the start
    Eigen::Vector3d line_m = Eigen::Vector3d::Zero();        // b to a at the start
    double push_impulse_N_s = 0.0, limit_impulse_N_s = 0.0;  // normal force, limit of friction
    double scale = 1.0, stiffness_root = 1.0;                // the field's at the end
    Eigen::Vector3d friction_impulse_N_s = Eigen::Vector3d::Zero(),
                    stretch_after_m = Eigen::Vector3d::Zero();
    double hold_slope_kg = 0.0;                                     // if friction sticks
    Eigen::Vector3d asked_impulse_N_s = Eigen::Vector3d::Zero();    // friction without a limit
    Eigen::Vector3d aim = Eigen::Vector3d::Zero(), next_aim = aim;  // friction over its limit
  };
  /// Line and distance of centres at the end, and the unit normal to side a.
  struct Line {
    Eigen::Vector3d line_m, direction, normal;
    double before_m, after_m;
    double scale = 1.0, stiffness_root = 1.0;
  };
  void add_lane(const ContactListing& listing, const RowGroup& group, std::size_t row,
                std::size_t lane);
  static void turn_stretch(Touch& touch, const Coupling& coupling, const ImplicitPoses& poses);
  static void set_tool(const ToolLane& tool, Touch& touch);
  [[nodiscard]] Line line_of(const Touch& touch) const;
  void evaluate_instant(Touch& touch, Coupling& coupling, const ImplicitPoses& poses,
                        const Motions& velocities, Eigen::Ref<Eigen::Vector3d> rate_m_s,
                        EnergyLosses& powers) const;
  [[nodiscard]] Eigen::Vector3d start_line_m(const Touch& touch) const;
  /// When an arm is taken: as a mean over the step, or at its end.
  enum class Moment { kMean, kEnd };
  void set_arms(const Touch& touch, Coupling& coupling, const Line& line,
                const ImplicitPoses& poses, Moment moment) const;
  [[nodiscard]] Eigen::Vector3d field_arm_m(const Touch& touch, const ImplicitPoses& poses,
                                            Moment moment) const;
  [[nodiscard]] bool passes(const Touch& touch) const;
  [[nodiscard]] bool passes_field(const Touch& touch) const;
  void set_field(const ContactListing& listing, std::int32_t sphere_b, Touch& touch,
                 Coupling& coupling) const;
  void evaluate(Touch& touch, Coupling& coupling, const ImplicitPoses& poses,
                const Motions& velocities) const;
  void rub(Touch& touch, Coupling& coupling, const Eigen::Vector3d& normal,
           const Eigen::Vector3d& velocity, double step_s) const;

  const Description& description_;
  std::vector<std::size_t> awake_;  // spheres
  std::vector<Touch> touches_;
  std::vector<Coupling> couplings_;
  std::vector<Eigen::Vector3d> before_m_, after_m_;    // centres of spheres
  std::vector<FieldPose> field_before_, field_after_;  // one for each field
};

}  // namespace stillgrid::dynamics
