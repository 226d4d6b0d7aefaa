#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shared/dynamics/tool_path.hpp"
#include "shared/local/given_state.hpp"

namespace stillgrid::local {

/// Rigid bodies of a publisher, which give way to the tools tick by tick: what both processes run
/// where no engine of ours knows the scene. See docs/library.md.
///
/// A tick of 1 ms takes the tools' contacts implicitly: with W the inverse inertia, F the contact
/// law's wrench at the place to which the body goes without it, and K and D its stiffness and
/// damping, the wrench is w = (1 + (h^2 K + h D) W)^-1 F, and the twist changes by h (a + W w).
/// Bodies do not touch one another here: what held them is in the acceleration a.
///
/// Thread: one. Realtime: yes, but for the constructor, which allocates.
class GivenBodies {
 public:
  /// What one hand's tool did to one body in all ticks since begin().
  struct Push {
    Twist wrench = Twist::Zero();  // N s, N m s: at the centre, which moved
    double weight_N = 0.0;         // sum of the contacts' forces
    Eigen::Vector3d weighted_m_N =
        Eigen::Vector3d::Zero();  // and of their points beside the centre
    int contacts = 0;             // in the tick that had most
    double work_J = 0.0;
  };

  explicit GivenBodies(GivenModel model);

  /// Begins from a state. Pre: kMaxHeldBodies and kMaxGivenSpheres at most, of the model's
  /// materials, in order.
  void begin(const GivenState& state) noexcept;
  /// Moves all on by a tick. tools: where each hand's tool is at its end; one without a pose is
  /// away.
  void step(std::span<const std::optional<dynamics::ToolPose>> tools) noexcept;

  /// All stop where they are.
  void stand() noexcept;

  /// The bodies and spheres after the last tick. Arms are in the frame that turns with the body.
  [[nodiscard]] std::span<const GivenBody> bodies() const noexcept { return state_.bodies; }
  [[nodiscard]] std::span<const GivenSphere> spheres() const noexcept { return state_.spheres; }
  [[nodiscard]] Eigen::Vector3d position_m(const GivenSphere& sphere) const noexcept;
  /// Of a point that is fixed to the sphere's body.
  [[nodiscard]] Eigen::Vector3d velocity_m_s(const GivenSphere& sphere,
                                             const Eigen::Vector3d& point_m) const noexcept;
  [[nodiscard]] const Push& push(std::size_t hand, std::size_t body) const noexcept {
    return pushes_[hand * kMaxHeldBodies + body];
  }
  [[nodiscard]] const GivenModel& model() const noexcept { return model_; }
  /// Whether all places and velocities are numbers that a reader takes.
  [[nodiscard]] bool is_plausible() const noexcept;

 private:
  struct PlacedTool {
    bool is_here = false;
    dynamics::ToolPose pose;
    Eigen::Vector3d turning_rad_s = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> centre_m;  // of its spheres
  };
  /// One tool's contacts with one body: wrench and what resists, h^2 K + h D.
  struct Contacts {
    Twist wrench = Twist::Zero();
    Matrix6 resisting = Matrix6::Zero();
    double weight_N = 0.0;
    Eigen::Vector3d weighted_m_N = Eigen::Vector3d::Zero();
    double drift_W = 0.0;  // of the forces on spheres that drift
    int count = 0;
  };
  /// The twist to which a body goes without its contacts, and how it gives way to them.
  struct Course {
    Twist twist;
    Matrix6 inverse_inertia;
  };
  [[nodiscard]] Course course_of(std::size_t index, const Matrix6& inverse_inertia,
                                 const Matrix6& resisting) const noexcept;
  void place(std::span<const std::optional<dynamics::ToolPose>> tools) noexcept;
  void step(std::size_t body, std::span<GivenSphere> spheres) noexcept;
  void touch(std::size_t hand, const GivenBody& body, const Eigen::Vector3d& arm_m,
             const GivenSphere& sphere, Contacts& contacts) const noexcept;
  void take(std::size_t hand, std::size_t body, const Twist& wrench) noexcept;

  GivenModel model_;
  GivenState state_;
  std::vector<Eigen::Quaterniond> turns_;  // of each body since the state
  std::vector<Twist> starts_;              // of each body in the state
  std::uint64_t ticks_ = 0;                // since the state
  std::vector<PlacedTool> tools_;
  std::vector<double> reach_m_;     // of each tool's spheres from its origin
  std::vector<Contacts> contacts_;  // of each hand with the body in turn
  std::vector<Push> pushes_;        // by hand and body
};

}  // namespace stillgrid::local
