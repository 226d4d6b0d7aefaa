#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "proto/tool_segment.hpp"
#include "shared/collision/voxel_grid.hpp"
#include "shared/display/response.hpp"
#include "shared/display/transition.hpp"

namespace stillgrid::rendering {

/// A sphere of the tool, placed in the scene for one tick.
struct PlacedToolSphere {
  Eigen::Vector3d position_m;
  double radius_m;
  Eigen::Vector3d before_m;  // where the last tick that saw the scene placed it
};

/// A sphere of the scene as displayed, that a sphere of the tool overlaps.
struct TouchedSphere {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
  double radius_m;
  std::uint32_t material;
  std::uint32_t tool_sphere;  // which one overlaps it
  bool swept;  // only on the way to this tick; then position_m is where the two were closest
  std::uint32_t number = 0;    // in its grid
  std::uint32_t body = 0;      // order in the scene file
  std::uint32_t response = 0;  // its number in TouchedSpheres::responses, from 1; 0: none
  // Where it would be if it did not give way, and how it would move.
  Eigen::Vector3d base_m = Eigen::Vector3d::Zero(), base_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d led_m_s = Eigen::Vector3d::Zero();  // at which the snapshot is led on
  Eigen::Vector3d seen_m = Eigen::Vector3d::Zero();   // from where a contact's normal points
  double presence =
      1.0;  // weight of the displayed snapshots in which it is; its force is so much less
  bool is_static = false;
  std::uint32_t field = 0;  // its number in TouchedSpheres::fields, from 1; 0: of a grid
};

/// What else is known of a touched sphere that stands for a body with a field: it is fixed to the
/// body and tangent to where the tool meets it, its `presence` the field's stiffness over the
/// material's, by which its force is more or less.
struct TouchedField {
  std::uint32_t field = 0;                                 // among SceneView::fields()
  Eigen::Vector3d to_contact_m = Eigen::Vector3d::Zero();  // from the sphere's centre, world frame
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();       // of contact, in the body's frame
  double energy_share = 1.0;  // of its spring's energy, beside that of a force linear in depth
};

/// Spheres that a tick may visit, whatever the segment says. A query for one tool sphere looks at
/// as many swept bounds and rows of cells at most.
inline constexpr std::uint32_t kMaxVisits = 8192;

/// What a tick gathered, in memory of its own and of fixed size.
struct TouchedSpheres {
  static constexpr std::size_t kCapacity = 512, kResponseCapacity = 128, kFieldCapacity = 256;
  std::array<TouchedSphere, kCapacity> spheres;
  std::size_t count = 0;
  std::array<display::ResponseMatrix, kResponseCapacity> responses;
  std::size_t response_count = 0;
  std::array<TouchedField, kFieldCapacity> fields;
  std::size_t field_count = 0;
  std::uint32_t visits_left = kMaxVisits;  // in this tick, for all spheres of the tool
  bool truncated = false;                  // more was there than may be looked at or kept in a tick

  [[nodiscard]] std::span<const TouchedSphere> all() const noexcept {
    return {spheres.data(), count};
  }
  void clear() noexcept {
    count = response_count = field_count = 0;
    visits_left = kMaxVisits;
    truncated = false;
  }
  /// Counts a visit. Returns false, and notes the truncation, once no visit is left or the memory
  /// is full.
  [[nodiscard]] bool may_visit() noexcept {
    const bool may = visits_left > 0 && count < kCapacity;
    truncated = truncated || !may;
    visits_left -= may ? 1 : 0;
    return may;
  }
  [[nodiscard]] const display::ResponseMatrix& response_of(
      const TouchedSphere& sphere) const noexcept {
    return responses[sphere.response - 1];
  }
  /// Of a sphere that stands for a field; nothing of others.
  [[nodiscard]] const TouchedField* field_of(const TouchedSphere& sphere) const noexcept {
    return sphere.field != 0 ? &fields[sphere.field - 1] : nullptr;
  }
  /// From a sphere's centre to the point that stands for its body: of a field's that of contact.
  [[nodiscard]] Eigen::Vector3d to_body_m(const TouchedSphere& sphere) const noexcept {
    return sphere.field != 0 ? fields[sphere.field - 1].to_contact_m : Eigen::Vector3d::Zero();
  }
  [[nodiscard]] bool has_swept() const noexcept {
    return std::any_of(all().begin(), all().end(), [](const auto& sphere) { return sphere.swept; });
  }
  /// A contact on the way is of one tick; shown in the next it would be where nothing is.
  void drop_swept() noexcept;
};

/// Shifts of the bodies that the tool touched when a snapshot came; none of others.
struct BodyShifts {
  struct Shift {
    std::uint32_t body;
    Eigen::Vector3d shift_m;
  };
  std::array<Shift, proto::kMaxShiftedBodies> shifts{};
  std::size_t count = 0;

  [[nodiscard]] Eigen::Vector3d of(std::uint32_t body) const noexcept {
    for (std::size_t i = 0; i < count; ++i)
      if (shifts[i].body == body) return shifts[i].shift_m;
    return Eigen::Vector3d::Zero();
  }
  [[nodiscard]] double longest_m() const noexcept {
    double longest_m = 0.0;
    for (std::size_t i = 0; i < count; ++i)
      longest_m = std::max(longest_m, shifts[i].shift_m.norm());
    return longest_m;
  }
};

/// How spheres are displayed that give way to the tool's force.
struct CompliantDisplay {
  display::ModeMotion motion = {};
  double slack_m = 0.0;  // by which any may move, so that all contacts are found
  double share = 0.0;    // of the shifts that is left
  BodyShifts shifts = {};
};

/// How a grid's spheres are displayed in this tick, and were in the tick before.
struct DisplayedMotion {
  display::SnapshotWeights now;
  display::SnapshotWeights before;
  CompliantDisplay compliant_display = {};
};

/// Where sphere `number` of a grid is displayed. Realtime: safe on words that change or lie.
/// Pre: number < grid.shape.sphere_count.
[[nodiscard]] Eigen::Vector3d displayed_m(const collision::GridView& grid, std::uint32_t number,
                                          const display::SnapshotWeights& weights,
                                          const CompliantDisplay& compliant_display) noexcept;

/// Places a touched sphere where the modes move it from its base, by its response: straight_m but
/// for the arc of the body's point so far from its centre, and at beside_m_s beside that.
/// Realtime: yes.
void place(const display::ModeMotion& motion, const Eigen::Vector3d& straight_m,
           const Eigen::Vector3d& beside_m_s, TouchedSphere& sphere,
           const Eigen::Vector3d& to_body_m = Eigen::Vector3d::Zero()) noexcept;
void give_way(const display::ModeMotion& motion, const display::ResponseMatrix& response,
              TouchedSphere& sphere,
              const Eigen::Vector3d& to_body_m = Eigen::Vector3d::Zero()) noexcept;

/// Adds to `touched` the spheres of a grid that overlap the tool where `shown` displays them, or
/// would if they gave way by less or more within the slack.
/// [Davanne 2002, section 3: the static grid as intermediate model, the tool never entered.]
///
/// Swept: where tool and sphere moved past one another by more than half the tool sphere's radius
/// since the tick before, and overlap at neither end, they are also tested where they came closest
/// on the straight way. Shorter moves can miss no overlap deeper than a 32nd of that radius.
/// A sphere is absent from the snapshots in which its position is not a number: it is displayed by
/// the others, and not swept. Points of bodies that have fields are nobody's to touch. Realtime:
/// wait-free, allocates nothing. Safe on words that change or lie; what was gathered counts only
/// once the read was accepted, and only finite overlaps are kept.
void gather_touched(const collision::GridView& grid, const DisplayedMotion& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

}  // namespace stillgrid::rendering
