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

/// Rigid bodies of a publisher under the pushes of the tools. Both processes step them tick by tick
/// where no engine of ours knows the scene. See docs/library.md.
///
/// A tick takes h = 1 ms. It takes the tools' contacts implicitly: w = (1 + (h^2 K + h D) W)^-1 F,
/// and the twist changes by h (a + W w). W is the inverse inertia. F is the contact law's wrench
/// where the body is at the tick's end without it; K and D are its stiffness and damping.
/// Bodies do not touch one another here: the acceleration a holds all other forces.
///
/// Thread: one. Realtime: yes, but for the constructor, which allocates.
class GivenBodies {
 public:
  /// The impulse of one hand's tool on one body in all ticks since begin().
  struct Push {
    Twist wrench = Twist::Zero();                        // N s, N m s: at the centre, which moved
    double weight_N = 0.0;                               // sum of the contacts' forces
    Eigen::Vector3d weighted = Eigen::Vector3d::Zero();  // and of their points beside the centre
    int contacts = 0;                                    // in the tick that had most
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
  /// Returns the velocity of a point that is fixed to the sphere's body.
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
    std::vector<Eigen::Vector3d> centre_m;  // one a sphere
  };
  /// One tool's contacts with one body: wrench, and resistance h^2 K + h D.
  struct Contacts {
    Twist wrench = Twist::Zero();
    Matrix6 resisting = Matrix6::Zero();
    double weight_N = 0.0;
    Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
    double own_W = 0.0;  // power of the forces on spheres that move on their own
    int count = 0;
  };
  /// The twist of a body at a tick's end without its contacts, and its inverse inertia there.
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
  void add_push(std::size_t hand, std::size_t body, const Twist& wrench) noexcept;

  GivenModel model_;
  GivenState state_;
  std::vector<Eigen::Quaterniond> turns_;  // one a body, since the state
  std::vector<Twist> starts_;              // one a body, in the state
  std::uint64_t ticks_ = 0;                // since the state
  std::vector<PlacedTool> tools_;
  std::vector<double> radius_m_;    // a tool: its spheres about its origin
  std::vector<Contacts> contacts_;  // one a hand, with the body in turn
  std::vector<Push> pushes_;        // each hand's for all bodies
};

}  // namespace stillgrid::local
