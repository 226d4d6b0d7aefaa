#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/scene_segment.hpp"
#include "shared/collision/smooth_cover.hpp"
#include "shared/collision/tool_proxy.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/tool_force.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// The proxies of a tool's spheres. A proxy follows its sphere and stays outside the surfaces that
/// the tool touches. A spring from the sphere to its proxy pulls the tool. It has the stiffness of
/// the touched material, however many spheres cover a body. Friction sticks. See
/// docs/algorithms/tool_contact.md.
///
/// Thread: the haptic loop's only. Realtime: wait-free, without allocation.
class ToolProxies {
 public:
  /// Places the tool in this tick. Proxies that are new begin at their spheres. may_lose: spheres
  /// of the scene come and go.
  /// Pre: scene.tool_sphere_count <= kMaxToolSpheres.
  void place(const proto::SceneHeader& scene, const ToolPose& pose, bool may_lose = false) noexcept;
  /// Moves proxies to those of a simulation with the tool at the pose of place(). It may still let
  /// one out of a surface that the own one has left. See SceneState::proxy_m. knows_all: it has all
  /// surfaces; else an own proxy that another surface pushes stays.
  void begin_at(std::span<const dynamics::Vector4> proxies_m, bool knows_all) noexcept;
  /// Returns the spheres to gather with: at the proxies, so wide that all is found that may push in
  /// this tick. Valid until the next place().
  [[nodiscard]] std::span<const PlacedToolSphere> reach() const noexcept {
    return {reach_.data(), count_};
  }

  /// Moves the proxies and returns the force on the tool at the pose of place(). touched: the
  /// spheres that reach() met. Those of unknown material do not count. tick_s: the last tick's
  /// length. A simulation with the tool at this pose gives stretches_m: the stretch of friction of
  /// each tool sphere, m, in the frame of the world. Without it friction sums velocities.
  [[nodiscard]] ToolForce press(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                                const ToolPose& pose, double tick_s,
                                std::span<const dynamics::Vector4> stretches_m = {}) noexcept;
  /// Returns the force of press(), and leaves the proxies where they are.
  [[nodiscard]] ToolForce force_of(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                                   const ToolPose& pose, double tick_s) noexcept {
    const auto kept = proxies_;
    const ToolForce force = press(scene, touched, pose, tick_s);
    proxies_ = kept;
    return force;
  }
  /// There was no scene, or it was another.
  void forget() noexcept { has_proxies_ = false; }

 private:
  /// A moving sphere that pushed a proxy in the last press().
  struct Pusher {
    std::uint32_t number, body, material_number;
    double radius_m;
    Eigen::Vector3d position_m, velocity_m_s, push_N;
    collision::ContactMaterial material;
  };
  /// The surface of spheres that pushed a proxy and are no longer there. It goes with the tool and
  /// lets the proxy in.
  struct LostSurface {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double depth_m = 0.0;  // depth of the tool's sphere; 0 without such a surface
    collision::ContactMaterial material;
  };
  struct Proxy {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d device_m = Eigen::Vector3d::Zero();  // the tool's sphere in the last press()
    Eigen::Vector3d from_m = Eigen::Vector3d::Zero();    // and as the proxy came to its place
    bool is_given = false;                               // begin_at() set its place in this tick
    bool is_own = false;  // begin_at() left it, for the simulation does not know its surfaces
    collision::StickingFriction friction;
    double longest_m = 0.0;  // way in this tick
    bool touches = false;
    bool is_of_given = true;  // given bodies alone pushed it in the last press()
    std::size_t pusher_count = 0;
    LostSurface lost;
  };
  struct Surface {
    const TouchedSphere* sphere = nullptr;
    const proto::Plane* plane = nullptr;
    collision::ContactMaterial material;
    double energy_share = 1.0;  // that of a field's map, whatever its slope at the proxy
  };
  struct Load;
  void set_reach(std::size_t tool_sphere) noexcept;
  void find_lost(const TouchedSpheres& touched, std::uint32_t tool_sphere, double tick_s) noexcept;
  void remember(std::size_t tool_sphere, std::size_t count) noexcept;
  [[nodiscard]] std::size_t find_surfaces(const proto::SceneHeader& scene,
                                          const TouchedSpheres& touched,
                                          std::uint32_t tool_sphere) noexcept;
  [[nodiscard]] std::span<collision::HalfSpace> lay(std::size_t tool_sphere,
                                                    const PlacedToolSphere& proxy,
                                                    std::size_t count, double tick_s,
                                                    collision::TickPart part) noexcept;
  [[nodiscard]] collision::HalfSpace lost_space(std::size_t tool_sphere,
                                                const PlacedToolSphere& proxy,
                                                collision::TickPart part) const noexcept;
  [[nodiscard]] double longest_near_fields_m(std::span<const collision::HalfSpace> spaces,
                                             double radius_m) const noexcept;
  static void add_push(const Surface& surface, const collision::HalfSpace& space,
                       const PlacedToolSphere& device, const ToolPose& pose, ToolForce& sum,
                       Load& load) noexcept;
  void add_forces(std::size_t tool_sphere, std::size_t count, const ToolPose& pose, double tick_s,
                  const dynamics::Vector4* stretch_m, ToolForce& sum) noexcept;

  static constexpr std::size_t kSurfaces = TouchedSpheres::kCapacity + proto::kMaxPlanes + 1;
  std::array<Proxy, proto::kMaxToolSpheres> proxies_;
  static constexpr std::size_t kPushers = 16;  // a tool sphere keeps those that it met first
  std::array<std::array<Pusher, kPushers>, proto::kMaxToolSpheres> pushers_;
  ToolSpheres placed_, reach_;
  std::size_t count_ = 0;  // number of the tool's spheres
  bool has_proxies_ = false;
  bool may_lose_ = false;
  std::array<Surface, kSurfaces> surfaces_;  // near one tool sphere
  std::array<collision::HalfSpace, kSurfaces> spaces_;
  std::array<collision::SeenSurface, kSurfaces> seen_;
  collision::SmoothCover cover_;
};

}  // namespace stillgrid::rendering
