#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/stillgrid.h"
#include "shared/dynamics/tool_path.hpp"
#include "shared/local/given_bodies.hpp"
#include "shared/publication/moving_records.hpp"

namespace stillgrid::library {

/// A hand's tool: the path that it took, and by how many ticks it is led on beyond it.
struct HandPath {
  dynamics::TickPath path;
  std::uint64_t led_on_ticks = 0;
};

/// What the tools do to the bodies of a publisher along their paths, and the bodies near them as a
/// snapshot carries them.
///
/// Bodies that their publisher gave an inverse inertia give way in each tick; the spheres of others
/// go on at their velocity. Thread: one. Realtime: yes, but for the constructor, which allocates.
class BodyPushes {
 public:
  explicit BodyPushes(const local::GivenModel& model);

  /// Finds the pushes over the ticks `from` to `to`, of which the first is left out.
  /// given: by number, as they were at `from`; moving was placed then.
  void find(publication::MovingRecords& moving, std::span<const local::GivenBody> given,
            std::span<const HandPath> hands, std::uint64_t from, std::uint64_t to) noexcept;
  /// There are none.
  void clear() noexcept;

  /// Each hand's to each body that it touched, as the mean over the ticks.
  [[nodiscard]] std::span<const stillgrid_push> pushes() const noexcept { return pushes_; }
  /// The mean wrench of all hands on a body's centre, N, N m.
  [[nodiscard]] local::Twist wrench_of(std::uint32_t body) const noexcept;
  /// The same of all bodies that were near, by number.
  [[nodiscard]] std::span<const std::pair<std::uint32_t, local::Twist>> wrenches() const noexcept {
    return wrenches_;
  }
  [[nodiscard]] double work_J(std::size_t hand) const noexcept { return work_J_[hand]; }

  /// Returns the given bodies that are within reach of a tool at a tick, as a snapshot carries
  /// them: those nearest, each with all its spheres there, or not at all. Good until the next call.
  [[nodiscard]] std::span<const std::byte> state_at(std::uint64_t tick,
                                                    publication::MovingRecords& moving,
                                                    std::span<const local::GivenBody> given,
                                                    std::span<const HandPath> hands,
                                                    double reach_m);

 private:
  struct Near {
    std::uint32_t body, sphere;
    double distance_m;
  };
  /// The near spheres of one body: `count` from near_[first] on, the nearest first.
  struct Group {
    std::uint32_t body;
    std::size_t first, count;
    double distance_m;
  };
  struct Ball {
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    double radius_m = 0.0;
  };
  [[nodiscard]] std::optional<Ball> ball_of(const HandPath& hand, std::uint64_t from,
                                            std::uint64_t to) const noexcept;
  [[nodiscard]] bool find_near(publication::MovingRecords& moving, const Ball& ball,
                               double ahead_s) noexcept;
  void group() noexcept;
  void fill(publication::MovingRecords& moving, std::span<const local::GivenBody> given) noexcept;
  void tell(std::size_t hand, double ticks) noexcept;

  local::GivenBodies bodies_;
  local::GivenState state_;
  std::vector<double> reach_m_;  // of each tool's spheres from its origin
  std::vector<Near> near_;
  std::vector<Group> groups_;
  std::vector<std::optional<dynamics::ToolPose>> poses_;
  std::vector<stillgrid_push> pushes_;
  std::vector<double> work_J_;
  std::vector<std::pair<std::uint32_t, local::Twist>> wrenches_;  // by number of body
  std::vector<std::byte> block_;
};

}  // namespace stillgrid::library
