#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/scene_state.hpp"
#include "shared/local/given_bodies.hpp"
#include "shared/local/scene_copies.hpp"

namespace stillgrid::local {

/// A copy that begins from a snapshot's bodies.
struct GivenCopy {
  explicit GivenCopy(const GivenModel& model) : bodies(model) {}
  [[nodiscard]] bool is_plausible() const noexcept { return bodies.is_plausible(); }
  GivenBodies bodies;
  std::uint64_t tick = 0, began = 0;
  bool is_begun = false;
};

/// The bodies near the tools of a publisher's scene, which go on from its snapshots along the paths
/// that the tools take. LocalScene is the same of a scene of our engine. The publisher's own engine
/// is not known here, so each snapshot begins a second copy, which catches up and takes the first
/// one's place. Its spheres are shown with an offset from where they were, which goes in half a
/// period. A copy stops two periods after its state.
///
/// Thread: one. Realtime: yes, but for the constructor, which allocates.
class GivenScene : public SceneCopies<GivenCopy> {
 public:
  /// Decodes a model of a session's hands, of which this process has one. Throws
  /// std::invalid_argument where it is not sound, or has another number of hands.
  GivenScene(std::span<const std::byte> model, std::size_t hands, std::size_t own_hand);

  /// Whether a snapshot's state of that tick is not wanted: one that is as new was begun, or a copy
  /// is on its way.
  [[nodiscard]] bool confirms(std::uint64_t tick, std::uint64_t hash = 0) const noexcept;
  /// Begins the second copy from a snapshot's state. Returns whether it is one of this model.
  bool begin_at(std::uint64_t tick, std::span<const std::byte> state) noexcept;
  /// Moves the copies on to a tick, the second one by a few ticks at most.
  Advance advance_to(std::uint64_t tick) noexcept;

  /// The bodies at the tick of the last advance_to(). Pre: they were known there.
  [[nodiscard]] const GivenBodies& bodies() const noexcept { return shown().bodies; }
  /// Returns the place where sphere i of bodies().spheres() is shown then.
  [[nodiscard]] Eigen::Vector3d position_m(std::size_t i) const noexcept;
  /// Proxies of the own tool's spheres as they are shown then, and the stretches of their friction.
  /// w is as in dynamics::SceneState::proxy_m. A span is valid until the next call.
  [[nodiscard]] std::span<const dynamics::Vector4> own_proxies_m() noexcept {
    return own(proxies_m_);
  }
  [[nodiscard]] std::span<const dynamics::Vector4> own_stretches_m() noexcept {
    return own(stretches_m_);
  }

 private:
  GivenScene(const GivenModel& model, std::size_t hands, std::size_t own_hand);
  void step(GivenCopy& copy) noexcept;
  void shift() noexcept;

  /// A vector of each proxy of the own tool.
  struct OwnProxies {
    Eigen::Vector3d GivenProxy::*vector;
    std::vector<dynamics::Vector4> shown, shifts;  // shifts: at the last swap
  };
  [[nodiscard]] dynamics::Vector4 proxy_of(const GivenCopy& copy, std::size_t i,
                                           Eigen::Vector3d GivenProxy::*vector) const noexcept;
  [[nodiscard]] double left() const noexcept;
  [[nodiscard]] std::span<const dynamics::Vector4> own(OwnProxies& all) noexcept;
  void shift(OwnProxies& all) noexcept;

  GivenState decoded_;
  OwnProxies proxies_m_{&GivenProxy::position_m, {}, {}};
  OwnProxies stretches_m_{&GivenProxy::stretch_m, {}, {}};
  std::vector<Eigen::Vector3d> shifts_m_, next_shifts_m_;  // one a shown sphere, at the last swap
  std::uint64_t swapped_ = 0;                              // its tick
};

}  // namespace stillgrid::local
