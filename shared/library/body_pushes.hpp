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

/// The path that a hand's tool took. The tool goes on evenly for led_on_ticks beyond it.
struct HandPath {
  dynamics::TickPath path;
  std::uint64_t led_on_ticks = 0;
};

/// The pushes of the tools on a publisher's bodies along their paths. It also makes the states of
/// snapshots, which hold the bodies near the tools.
///
/// A body with an inverse inertia moves under its pushes. The spheres of others go on at their
/// velocity. Thread: one. Realtime: yes, but for the constructor, which allocates.
class BodyPushes {
 public:
  explicit BodyPushes(const local::GivenModel& model);

  /// Finds the pushes in the ticks after `from`, until `to`. Pre: given is in the order of its
  /// numbers; given and moving are of tick `from`.
  void find(publication::MovingRecords& moving, std::span<const local::GivenBody> given,
            std::span<const HandPath> hands, std::uint64_t from, std::uint64_t to) noexcept;
  /// Forgets the pushes.
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

  /// Returns the state of the given bodies within a margin of the tools at a tick. The nearest come
  /// first. A body has all its spheres there, or it is left out. Valid until the next call.
  [[nodiscard]] std::span<const std::byte> state_at(std::uint64_t tick,
                                                    publication::MovingRecords& moving,
                                                    std::span<const local::GivenBody> given,
                                                    std::span<const HandPath> hands,
                                                    double margin_m);

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

  [[nodiscard]] bool goes_on_at(std::uint64_t tick) const noexcept;
  void begin_proxies() noexcept;

  local::GivenBodies bodies_;
  local::GivenState state_;
  std::vector<local::GivenProxy> proxies_;  // at the end of the last pushes
  std::uint64_t proxies_tick_ = 0;          // the tick of that
  std::vector<double> radius_m_;            // a tool: its spheres about its origin
  std::vector<Near> near_;
  std::vector<Group> groups_;
  std::vector<std::optional<dynamics::ToolPose>> poses_;
  std::vector<stillgrid_push> pushes_;
  std::vector<double> work_J_;
  std::vector<std::pair<std::uint32_t, local::Twist>> wrenches_;  // in the order of bodies
  std::vector<std::byte> block_;
};

}  // namespace stillgrid::library
