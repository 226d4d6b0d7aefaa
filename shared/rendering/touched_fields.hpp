#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "shared/display/displayed_field.hpp"
#include "shared/publication/published_fields.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Samples of fields that one gathering may take, whatever the segment says.
inline constexpr std::uint32_t kMaxFieldSamples = 2048;

/// A body with a field as a tick displays it.
struct ShownField {
  display::DisplayedField base;  // where it would be if it did not give way, and how it would move
  display::DisplayedField at;    // where it is
  display::DisplayedField led;   // at the velocities at which the snapshot is led on
  std::optional<display::FieldResponse> response;

  /// By how much the body's point that is at point_m without gives way in each mode.
  [[nodiscard]] std::optional<display::ResponseMatrix> response_at(
      const Eigen::Vector3d& point_m, double largest_response) const noexcept;
};

/// A field that moves, or nothing where its record is none. Realtime: yes.
/// Pre: field.body.moving != 0.
[[nodiscard]] std::optional<ShownField> shown_field(const publication::SceneField& field,
                                                    const collision::GridView& moving,
                                                    const display::SnapshotWeights& weights,
                                                    const CompliantDisplay& compliant) noexcept;

/// The same point of a body in another snapshot, which a switch compares: its response, and where
/// the sphere that is tangent there is displayed, as it is turned now. Nothing where there is none.
/// Realtime: yes. Pre: touched.field is one of `fields`, and moves.
[[nodiscard]] std::optional<display::ResponseMatrix> response_in(
    std::span<const publication::SceneField> fields, const collision::GridView& moving,
    const TouchedField& touched, const display::SnapshotWeights& weights,
    const CompliantDisplay& compliant) noexcept;
[[nodiscard]] std::optional<Eigen::Vector3d> displayed_m(
    std::span<const publication::SceneField> fields, const collision::GridView& moving,
    const TouchedField& touched, const display::SnapshotWeights& weights,
    const CompliantDisplay& compliant) noexcept;

/// Adds to `touched` a sphere for each of the tool's that meets a field where `shown` displays it,
/// or would if it gave way by less or more within the slack.
///
/// The sphere is tangent to the solid there, of the radius of the ball that holds the solid, and
/// fixed to the body: contact law, response and switches know spheres only. Depth and normal are
/// the field's own.
/// Swept: where the tool's sphere moved by more than half its radius since the tick before, seen
/// from the body, and overlaps at neither end, it is followed over that way, in steps that no
/// solid's crossing is shorter than, and touches where it was pushed back hardest before the
/// field turned to push it on.
/// Realtime: as gather_touched().
void gather_moving_fields(std::span<const publication::SceneField> fields,
                          const collision::GridView& moving, const DisplayedMotion& shown,
                          std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

/// The same of fields that never move.
void gather_static_fields(std::span<const publication::SceneField> fields,
                          std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept;

}  // namespace stillgrid::rendering
