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
#include "shared/local/given_tools.hpp"

namespace stillgrid::local {

/// Rigid bodies of a publisher under the pushes of the tools. Both processes step them tick by tick
/// where no engine of ours knows the scene. See docs/library.md.
///
/// A tick takes h = 1 ms. It takes the tools' contacts implicitly: w = (1 + (h^2 K + h D) W)^-1 F,
/// and the twist changes by h (a + W w). W is the inverse inertia. F is the wrench of the proxies'
/// springs where the body is at the tick's end without it. K and D are their stiffness and damping.
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

  /// Begins from a state. tools: where each hand's tool is then. Pre: kMaxHeldBodies and
  /// kMaxGivenSpheres at most, of the model's materials, in order.
  void begin(const GivenState& state,
             std::span<const std::optional<dynamics::ToolPose>> tools = {}) noexcept;
  /// Moves all on by a tick. tools: where each hand's tool is at its end; one without a pose is
  /// away.
  void step(std::span<const std::optional<dynamics::ToolPose>> tools) noexcept;

  /// Stops all bodies where they are, whatever pushes them.
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
  [[nodiscard]] const GivenTools& tools() const noexcept { return tools_; }
  /// Whether all places and velocities are numbers that a reader takes.
  [[nodiscard]] bool is_plausible() const noexcept;

 private:
  /// One tool's contacts with one body: wrench, and resistance h^2 K + h D.
  struct Contacts {
    Twist wrench = Twist::Zero();
    Matrix6 resisting = Matrix6::Zero();
    double weight_N = 0.0;
    Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
    double own_W = 0.0;  // power of the forces on spheres that move on their own
    int count = 0;
  };
  /// A body before a tick, and its twist in it without the tools.
  struct LedBody {
    Eigen::Vector3d start_m;
    Eigen::Quaterniond start_turn;
    Twist twist;
  };
  /// The twist of a body at a tick's end without its contacts, and its inverse inertia there.
  struct Course {
    Twist twist;
    Matrix6 inverse_inertia;
  };
  [[nodiscard]] Course course_of(std::size_t index, const Matrix6& inverse_inertia,
                                 const Matrix6& resisting) const noexcept;
  void lead() noexcept;
  void move(std::size_t body) noexcept;
  void push(std::size_t body, std::span<const GivenContact> contacts) noexcept;
  void add_push(std::size_t hand, std::size_t body, const Twist& wrench) noexcept;

  GivenModel model_;
  GivenState state_;
  std::vector<Eigen::Quaterniond> turns_;  // one a body, since the state
  std::vector<Twist> starts_;              // one a body, in the state
  std::uint64_t ticks_ = 0;                // since the state
  GivenTools tools_;
  std::vector<LedSphere> led_;              // one a sphere
  std::vector<LedBody> led_bodies_;         // one a body
  std::vector<GivenTools::Pushed> pushed_;  // one a contact
  std::vector<Contacts> contacts_;          // one a hand, with the body in turn
  std::vector<Push> pushes_;                // each hand's for all bodies
};

}  // namespace stillgrid::local
