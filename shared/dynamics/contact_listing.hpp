#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/near_pairs.hpp"
#include "shared/dynamics/row_packer.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// How impulses act on a sphere: kBall where it is a whole free rigid body of a solid ball.
[[nodiscard]] SideKind side_kind(const Description& description, const Description::Sphere& sphere);
/// Centre of a sphere in m, in the frame of the world.
[[nodiscard]] Vector4 sphere_position_m(const Description::Sphere& sphere, const SceneState& state);

/// What a contact has from substep to substep.
struct ContactHistory {
  float push_N_s = 0.0F, drag_N_s[3] = {}, stretch_m[3] = {};
};
/// Of the contacts that do not rest at zero: the two spheres, or a sphere and a plane behind the
/// spheres, smaller first; impulses and stretches act on the first.
struct KnownContact {
  std::int32_t first, second;
  ContactHistory history;
};

/// The contacts that may come about until something has moved by its reach, in rows.
///
/// Thread: one. Memory is kept from call to call.
class ContactListing {
 public:
  explicit ContactListing(const Description& description);

  /// Lists contacts anew, with the history that they have in the listing before. tick_s: the time
  /// after which it is asked for again. Realtime: allocates where there are more than ever before.
  void list(const SceneState& state, double tick_s);

  /// Everything that list() computed, for a saved state; and back. The listing then continues to
  /// the bit.
  struct Saved {
    std::vector<Vector4> base;  // of each sphere; w: reach
    std::vector<std::int32_t> order, rigid_order;
    std::vector<RowGroup> groups;
    std::vector<std::int32_t> sphere_a, sphere_b;  // of each lane: places in order, -1 if unused
    std::vector<ContactHistory> history;           // of each lane
  };
  void save(Saved& saved) const;
  void load(const Saved& saved);

  [[nodiscard]] RowList& rows() noexcept { return rows_; }
  [[nodiscard]] const RowList& rows() const noexcept { return rows_; }
  /// Spheres in the order in which SpherePlace and SphereArm are stored: near ones side by side.
  [[nodiscard]] std::span<const std::int32_t> order() const noexcept { return order_; }
  /// Where each sphere was when contacts were listed; w: how far it may move.
  [[nodiscard]] std::span<const Vector4> base() const noexcept { return base_; }
  [[nodiscard]] std::span<const SideKind> kinds() const noexcept { return kinds_; }
  /// Rigid bodies in the order of their movers, and the other way round.
  [[nodiscard]] std::span<const std::int32_t> rigid_order() const noexcept { return rigid_order_; }
  [[nodiscard]] std::span<const std::int32_t> mover_of_rigid() const noexcept {
    return mover_of_rigid_;
  }
  [[nodiscard]] std::size_t listings() const noexcept { return listings_; }

 private:
  /// A contact of two places in order(), or of one and a plane.
  struct Candidate {
    std::int32_t a, b;
  };
  void bound_ways(const SceneState& state, double tick_s);
  void order_movers();
  void gather();
  [[nodiscard]] bool may_collide(std::int32_t sphere, std::int32_t other) const;
  [[nodiscard]] std::size_t movers_of(std::int32_t sphere, std::int32_t* movers) const;
  void remember();
  void recall();
  void pack();
  void derive_lane(std::size_t row, std::size_t lane, const RowGroup& group);
  void derive();
  /// The mover that stands for planes and unused lanes.
  [[nodiscard]] std::int32_t world() const {
    return static_cast<std::int32_t>(description_.nodes.size() + description_.rigid_bodies.size());
  }
  [[nodiscard]] bool is_used(std::size_t row, std::size_t lane) const {
    return rows_.rows[row].mover_a[lane] != world();
  }
  [[nodiscard]] KnownContact known(std::size_t row, std::size_t lane, bool is_plane) const;

  const Description& description_;
  std::vector<SideKind> kinds_;
  NearPairs near_;
  RowPacker packer_;
  RowList rows_;
  std::vector<Vector4> base_, balls_;
  std::vector<std::int32_t> order_, rigid_order_, mover_of_rigid_, here_;
  std::vector<std::vector<Candidate>> candidates_;  // by kinds, planes and touching ones first
  std::vector<KnownContact> known_;
  std::vector<std::int32_t> first_known_;  // of each sphere, and one more
  std::size_t listings_ = 0;
};

}  // namespace stillgrid::dynamics
