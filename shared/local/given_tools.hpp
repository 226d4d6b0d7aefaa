#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shared/collision/smooth_cover.hpp"
#include "shared/collision/tool_proxy.hpp"
#include "shared/dynamics/tool_path.hpp"
#include "shared/local/given_state.hpp"

namespace stillgrid::local {

/// A sphere of a given body in a tick in which no tool pushes the body.
struct LedSphere {
  Eigen::Vector3d end_m = Eigen::Vector3d::Zero();    // its centre at the tick's end
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();  // displacement of the centre in the tick
};

/// The push of a tool's sphere on a body.
struct GivenContact {
  std::size_t hand = 0, proxy = 0;  // proxy: index among the spheres of all tools
  std::size_t sphere = 0;           // index of the touched sphere
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();       // on the body if it goes on as led
  Eigen::Matrix3d resisting_kg = Eigen::Matrix3d::Zero();  // h^2 K + h D at the point
  double press_N = 0.0;                                    // force of the spring
};

/// The proxies of the tools in a publisher's scene. The law is that of the haptic process: see
/// rendering::ToolProxies and docs/algorithms/tool_contact.md.
///
/// Thread: one. Realtime: yes, but for the constructor, which allocates.
class GivenTools {
 public:
  static constexpr std::size_t kMaxContacts = 1024;  // in a tick; no more push

  /// model: lives longer.
  explicit GivenTools(const GivenModel& model);
  GivenTools(const GivenTools&) = delete;
  GivenTools& operator=(const GivenTools&) = delete;

  /// Goes on with the proxies of a state.
  void begin(const GivenState& state) noexcept;
  /// Moves the tools to their poses at a tick's end. One without a pose is away. Proxies of a tool
  /// that comes begin at its spheres.
  void place(std::span<const std::optional<dynamics::ToolPose>> poses) noexcept;
  /// Moves the proxies and returns their contacts, valid until the next call. bodies: at the
  /// tick's end without the tools. led: one a sphere.
  [[nodiscard]] std::span<const GivenContact> touch(std::span<const GivenBody> bodies,
                                                    std::span<const GivenSphere> spheres,
                                                    std::span<const LedSphere> led) noexcept;
  /// The motion of a contact's sphere under the pushes.
  struct Pushed {
    Eigen::Vector3d aside_m = Eigen::Vector3d::Zero();  // displacement of the contact's point by it
    Eigen::Vector3d end_m = Eigen::Vector3d::Zero();    // the sphere's centre at the tick's end
  };
  /// Moves each proxy with the spheres that carry it. pushed: one a contact of touch().
  void settle(std::span<const GivenBody> bodies, std::span<const GivenSphere> spheres,
              std::span<const Pushed> pushed) noexcept;

  /// The proxies after the last tick, in the order of hands and their spheres.
  [[nodiscard]] std::span<const GivenProxy> proxies() const noexcept { return proxies_; }
  /// Returns those of a hand.
  [[nodiscard]] std::span<const GivenProxy> proxies(std::size_t hand) const noexcept {
    return proxies().subspan(tools_[hand].first, model_.tools[hand].spheres.size());
  }
  /// Returns the longest distance of a hand's sphere from its proxy, m.
  [[nodiscard]] double behind_m(std::size_t hand) const noexcept;

 private:
  struct Tool {
    bool is_here = false;
    std::size_t first = 0;  // proxy
    dynamics::ToolPose pose;
    Eigen::Vector3d turning_rad_s = Eigen::Vector3d::Zero();
  };
  /// A surface near a proxy.
  struct Near {
    std::size_t sphere;
    Eigen::Vector3d velocity_m_s;  // velocity of the touched point
  };
  void find_near(std::size_t hand, std::size_t i, std::span<const GivenBody> bodies,
                 std::span<const GivenSphere> spheres, std::span<const LedSphere> led) noexcept;
  [[nodiscard]] std::span<collision::HalfSpace> lay(const Eigen::Vector3d& proxy_m, double radius_m,
                                                    std::span<const GivenSphere> spheres,
                                                    std::span<const LedSphere> led,
                                                    collision::TickPart part) noexcept;
  void follow(std::size_t hand, std::size_t i, std::span<const GivenSphere> spheres,
              std::span<const LedSphere> led) noexcept;
  void push(std::size_t hand, std::size_t i, std::span<const GivenSphere> spheres,
            const Eigen::Vector3d& moved_m) noexcept;

  const GivenModel& model_;
  std::vector<Tool> tools_;
  std::vector<GivenProxy> proxies_;
  std::vector<GivenContact> contacts_;
  std::vector<Near> near_;
  std::vector<collision::HalfSpace> spaces_;
  std::vector<collision::SeenSurface> seen_;
  collision::SmoothCover cover_;
};

}  // namespace stillgrid::local
