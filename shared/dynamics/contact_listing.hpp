#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/dynamics/contact_history.hpp"
#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/field_lane.hpp"
#include "shared/dynamics/near_pairs.hpp"
#include "shared/dynamics/row_packer.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/tool_lane.hpp"

namespace stillgrid::dynamics {

/// How impulses act on a sphere: kBall where it is a whole free rigid body of a solid ball.
[[nodiscard]] SideKind side_kind(const Description& description, const Description::Sphere& sphere);
/// Centre of a sphere in m, in the frame of the world.
[[nodiscard]] Vector4 sphere_position_m(const Description::Sphere& sphere, const SceneState& state);
/// Velocity of a sphere's centre in the frame of the world.
[[nodiscard]] Eigen::Vector3d sphere_velocity_m_s(const Description::Sphere& sphere,
                                                  const SceneState& state);
/// A bound of the speed of a sphere's centre, which takes less time to compute.
[[nodiscard]] double highest_speed_m_s(const Description::Sphere& sphere, const SceneState& state);
/// How far a thing of a length may move until contacts are listed anew. next_m: its way in a tick.
[[nodiscard]] double listing_margin_m(double length_m, double next_m);

/// The contacts that may come about until something has moved by its reach, in rows.
///
/// Thread: one. Memory is kept from call to call.
class ContactListing {
 public:
  explicit ContactListing(const Description& description);

  /// Lists contacts anew, with the history that they have in the listing before. tick_s: the time
  /// after which it is asked for again. Realtime: allocates where there are more than ever before.
  void list(const SceneState& state, double tick_s,
            const WorkSharing& sharing = WorkSharing::alone());
  /// Spheres and rigid bodies that sleep, from the next listing on; must outlive this. Contacts of
  /// sleeping spheres with each other, with planes and with fixtures are not listed, but their
  /// history is kept.
  void set_sleeping(std::span<const std::uint8_t> spheres,
                    std::span<const std::uint8_t> rigid_bodies) {
    sleeps_ = spheres;
    rigid_sleeps_ = rigid_bodies;
    is_sleep_new_ = true;
  }

  /// History of a contact that sleeps: of a sphere, and of a second sphere, a plane or a field.
  /// Numbers are those of Description::side(); first < second. It acts on the first.
  struct SleepingContact {
    std::int32_t first, second;
    ContactHistory history;
  };
  /// A lane of rows().
  struct Lane {
    std::uint32_t row, lane;
  };
  /// Everything that list() computed, for a saved state; and back. The listing then continues to
  /// the bit.
  struct Saved {
    std::vector<Vector4> base;
    std::vector<std::int32_t> order;
    std::vector<RowGroup> groups;
    std::vector<std::int32_t> sphere_a, sphere_b;  // lanes: places in order, -1 if unused
    std::vector<FieldBase> field_base;
    std::vector<ContactHistory> history;  // lanes
    std::vector<SleepingContact> sleeping;
    std::vector<ToolFixture> fixtures;
  };
  void save(Saved& saved) const;
  /// Throws std::invalid_argument where the numbers cannot be a listing of this Description. Only a
  /// stale one, which is listed anew before its first use, may be empty.
  void check(const Saved& saved, bool is_stale) const;
  /// Pre: check().
  void load(const Saved& saved);

  /// A contact that friction has stretched: side a, and a sphere, plane or field; others are -1.
  struct Stretched {
    std::int32_t sphere_a, sphere_b = -1, plane = -1, field = -1;
    double stiffness_N_per_m;
    Eigen::Vector3d stretch_m;  // on side a
  };
  [[nodiscard]] std::vector<Stretched> stretched() const;

  [[nodiscard]] RowList& rows() noexcept { return rows_; }
  [[nodiscard]] const RowList& rows() const noexcept { return rows_; }
  /// Spheres in the order in which SpherePlace and SphereArm are stored: near ones side by side.
  [[nodiscard]] std::span<const std::int32_t> order() const noexcept { return order_; }
  /// Centres of spheres at the last listing, as order(). w: longest way until the next.
  [[nodiscard]] std::span<const Vector4> base() const noexcept { return base_; }
  [[nodiscard]] std::span<const SideKind> kinds() const noexcept { return kinds_; }
  /// Rigid bodies in the order of their movers, and the other way round.
  [[nodiscard]] std::span<const std::int32_t> rigid_order() const noexcept { return rigid_order_; }
  [[nodiscard]] std::span<const std::int32_t> mover_of_rigid() const noexcept {
    return mover_of_rigid_;
  }
  /// Lengths of spheres: the radius, or the cell of the field of which the sphere is a surface
  /// point.
  [[nodiscard]] std::span<const double> lengths_m() const noexcept { return lengths_m_; }
  /// Whether side b of a lane that is no plane is a field.
  [[nodiscard]] bool is_field(std::int32_t sphere_b) const {
    return static_cast<std::size_t>(sphere_b) >= description_.spheres.size();
  }
  /// Contacts with fields. Number k has place k behind all spheres.
  [[nodiscard]] std::span<FieldLane> field_lanes() noexcept { return field_lanes_; }
  [[nodiscard]] std::span<const FieldLane> field_lanes() const noexcept { return field_lanes_; }
  /// Poses of fields at the last listing.
  [[nodiscard]] std::span<const FieldBase> field_base() const noexcept { return field_base_; }
  /// The field of side b of a lane. Pre: is_field(sphere_b).
  [[nodiscard]] const Description::Field& field_of(std::int32_t sphere_b) const {
    const auto slot = static_cast<std::size_t>(sphere_b) - description_.spheres.size();
    return description_.fields[static_cast<std::size_t>(field_lanes_[slot].field)];
  }
  /// The rigid body of side b of a lane that is no plane; -1: a sphere of nodes.
  [[nodiscard]] int rigid_of(std::int32_t sphere_b) const {
    if (is_field(sphere_b)) return field_of(sphere_b).rigid;
    const std::int32_t sphere = order_[static_cast<std::size_t>(sphere_b)];
    return description_.spheres[static_cast<std::size_t>(sphere)].rigid;
  }
  /// Spheres of tools that have proxies, in the order of SceneState::proxy_m.
  [[nodiscard]] std::span<const std::int32_t> tools() const noexcept { return tools_; }
  /// Returns the place of such a sphere at the last listing. w: the reach of it and its proxy
  /// until the next one.
  [[nodiscard]] const Vector4& base_of_tool(std::size_t tool) const {
    return base_[tool_places_[tool]];
  }
  /// Contacts of these spheres with bodies that may move, and with fixtures, which are in no row.
  [[nodiscard]] std::span<ToolLane> tool_lanes() noexcept { return tool_lanes_; }
  [[nodiscard]] std::span<const ToolLane> tool_lanes() const noexcept { return tool_lanes_; }
  [[nodiscard]] std::span<const ToolFixture> tool_fixtures() const noexcept { return fixtures_; }
  /// Returns how many contacts of a tool's sphere take no memory beyond that of the constructor.
  [[nodiscard]] std::size_t sides_reserved() const;
  /// The tool's contact in a lane, or null.
  [[nodiscard]] const ToolLane* tool_lane(std::size_t row, std::size_t lane) const;
  /// Depth of a tool's contact where the bodies of the state are; negative: a gap.
  [[nodiscard]] double tool_depth_m(const ToolLane& lane, const SceneState& state) const;
  /// Lanes of contacts of which one side sleeps.
  [[nodiscard]] std::span<const Lane> sleeper_lanes() const noexcept { return sleeper_lanes_; }
  [[nodiscard]] std::span<const SleepingContact> sleeping_contacts() const noexcept {
    return sleeping_contacts_;
  }
  /// Stiffness of a SleepingContact without the scale of a field, N/m.
  [[nodiscard]] double stiffness_N_per_m(std::int32_t first, std::int32_t second) const;
  /// Rigid bodies of rigid_order() that are awake: the first ones.
  [[nodiscard]] std::size_t rigid_awake() const noexcept { return rigid_awake_; }
  [[nodiscard]] std::size_t listings() const noexcept { return listings_; }
  /// The search of the last listing: near pairs, and how many pairs of spheres were compared.
  [[nodiscard]] double near_pairs() const noexcept {
    return static_cast<double>(pairs_.pairs().size());
  }
  [[nodiscard]] double comparisons() const noexcept { return pairs_.comparisons(); }

 private:
  /// A contact of two places in order(), or of one and a plane, or of one and a field, which is
  /// counted behind the places.
  struct Candidate {
    std::int32_t a, b;
  };
  /// Constants of a sphere, stored as order(): side by side for near spheres. Fields follow.
  struct NearSphere {
    std::int32_t rigid, body, mover;  // the mover of a soft sphere is its first node
    SideKind kind;
    bool is_driven, is_still;
    std::int32_t material;
    bool is_tool;
    float tool_slip_speed_m_s;
    bool is_field_point;
    double radius_m;
  };
  /// Two spheres, or a sphere and a plane or a field, counted behind the spheres, smaller first;
  /// whether side a is the second.
  struct Key {
    std::int32_t first, second;
    bool is_reversed;
  };
  /// History of a contact that has one; it acts on the first of its key.
  struct KnownContact {
    std::int32_t second = 0;
    ContactHistory history;
  };
  /// Constants of a pair of materials, in floats.
  struct PairConstants {
    float stiffness_N_per_m, damping_N_s_per_m, friction, viscous_s_per_m;
  };
  void bound_ways(const SceneState& state, double tick_s);
  void order_spheres();
  void order_movers();
  void gather();
  void add_candidate(std::int32_t a, std::int32_t b, SideKind kind_b);
  void collect_near();
  void collect_near_fields();
  [[nodiscard]] std::size_t find_here(const SceneState& state);
  void bound_field_ways(const SceneState& state, double tick_s);
  void gather_fields(const SceneState& state);
  void add_field_lane(std::size_t row, std::size_t lane);
  [[nodiscard]] bool has_proxy(std::int32_t place) const {
    const NearSphere& sphere = near_spheres_[static_cast<std::size_t>(place)];
    return sphere.is_tool && sphere.tool_slip_speed_m_s == 0.0F;
  }
  [[nodiscard]] bool add_fixture(std::int32_t place, std::int32_t other);
  void add_tool_lane(std::size_t row, std::size_t lane, std::int32_t tool, std::int32_t other,
                     bool is_a);
  [[nodiscard]] bool may_meet_field(std::int32_t place, std::int32_t field) const;
  /// Side b of a lane that is no plane, as a Candidate has it.
  [[nodiscard]] std::int32_t listed_other(std::int32_t sphere_b) const;
  void check_rows(const Saved& saved) const;
  [[nodiscard]] PairConstants constants_of(const NearSphere& a, const NearSphere& b) const;
  [[nodiscard]] bool may_collide(std::int32_t place, std::int32_t other) const;
  [[nodiscard]] bool may_be_near(std::int32_t place, std::int32_t other) const;
  [[nodiscard]] std::size_t movers_of(std::int32_t place, std::int32_t* movers) const;
  [[nodiscard]] bool sleeps(std::int32_t sphere) const {
    return !sleeps_.empty() && sleeps_[static_cast<std::size_t>(sphere)] != 0;
  }
  [[nodiscard]] bool rigid_sleeps(std::int32_t rigid) const {
    return !rigid_sleeps_.empty() && rigid_sleeps_[static_cast<std::size_t>(rigid)] != 0;
  }
  [[nodiscard]] bool is_still(std::int32_t number) const;
  void add_sleepers();
  void list_sleeper_lanes();
  void remember(const WorkSharing& sharing);
  void recall(const WorkSharing& sharing);
  void divide(std::size_t group);
  bool pack(std::size_t group, std::span<const std::int32_t> part, bool is_in_turn);
  void pack();
  void add_rows(std::size_t group, std::uint32_t is_in_turn, std::uint32_t part);
  void derive_lane(std::size_t row, std::size_t lane, bool is_plane);
  void derive_row(const RowGroup& group, std::size_t row);
  void derive(const WorkSharing& sharing);
  /// The mover of planes and unused lanes.
  [[nodiscard]] std::int32_t world() const {
    return static_cast<std::int32_t>(description_.nodes.size() + description_.rigid_bodies.size());
  }
  [[nodiscard]] bool is_used(std::size_t row, std::size_t lane) const {
    return rows_.rows[row].mover_a[lane] != world();
  }
  [[nodiscard]] Key key(std::size_t row, std::size_t lane, bool is_plane) const;

  const Description& description_;
  std::vector<SideKind> kinds_;
  NearPairs pairs_;
  RowPacker packer_;
  RowList rows_;
  std::vector<Vector4> base_, bases_,
      balls_;  // stored: as order_; as spheres; spheres that are here
  std::vector<NearSphere> near_spheres_;
  std::vector<PairConstants> constants_;  // pairs of materials
  std::vector<std::int32_t> order_, rigid_order_, mover_of_rigid_, here_;
  std::vector<std::vector<Candidate>> candidates_;  // groups: planes, touching, near
  std::vector<std::int32_t> divided_;               // candidates of a group, sorted by parts
  std::vector<std::size_t> part_end_;               // parts, into divided_
  std::vector<Key> keys_;                           // lanes of all rows; unused ones have -1
  std::vector<KnownContact> known_;
  std::vector<std::int32_t> first_known_;  // one more than spheres
  std::vector<double> lengths_m_;          // see lengths_m()
  std::vector<FieldBase> field_base_;
  std::vector<FieldLane> field_lanes_;
  std::vector<std::int32_t> near_field_;  // places
  std::vector<std::int32_t> tools_;       // see tools()
  std::vector<std::size_t> tool_places_;  // places in order(), one for each of tools_
  std::vector<ToolLane> tool_lanes_;      // sorted by row and lane
  std::vector<ToolFixture> fixtures_;
  std::size_t listings_ = 0, rigid_awake_ = 0;
  std::span<const std::uint8_t> sleeps_, rigid_sleeps_;  // spheres, rigid bodies
  std::vector<SleepingContact> sleeping_contacts_;
  std::vector<Lane> sleeper_lanes_;
  mutable std::vector<std::uint8_t> seen_;  // spheres; scratch
  bool is_sleep_new_ = false;               // since the last listing
};

}  // namespace stillgrid::dynamics
