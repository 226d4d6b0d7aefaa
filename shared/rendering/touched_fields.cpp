#include "shared/rendering/touched_fields.hpp"

#include <algorithm>
#include <cmath>

#include "shared/collision/grid_query.hpp"
#include "shared/display/displayed_field.hpp"
#include "shared/rendering/field_sweep.hpp"
#include "shared/rendering/tool_sweep.hpp"

namespace stillgrid::rendering {
namespace {

using display::DisplayedField;

/// A field in one tick, for all spheres of the tool.
struct Target {
  const publication::SceneField& field;
  std::uint32_t number;          // among the scene's
  const DisplayedField& shown;   // in this tick
  const DisplayedField& before;  // in the tick before
};

/// Whether a sphere can have met the solid on a straight way.
bool is_near(const proto::FieldShape& shape, const Eigen::Vector3d& from_m,
             const Eigen::Vector3d& to_m, double near_m) {
  const Eigen::Vector3d centre_m(shape.centre_m[0], shape.centre_m[1], shape.centre_m[2]);
  const Eigen::Vector3d way_m = to_m - from_m;
  const double share = (centre_m - from_m).dot(way_m) / way_m.squaredNorm();
  // Written so that a NaN, of no way, is at its start.
  const Eigen::Vector3d nearest_m =
      from_m + (share > 0.0 ? std::min(1.0, share) : 0.0) * way_m - centre_m;
  const double contact_distance_m = double{shape.bounding_radius_m} + near_m;
  return nearest_m.squaredNorm() < contact_distance_m * contact_distance_m;
}

void add(const Target& target, const collision::FieldContact& contact, bool is_swept,
         std::uint32_t tool_sphere, const PlacedToolSphere& probe, TouchedSpheres& touched) {
  const auto& [field, number, shown, before] = target;
  const double radius_m = double{field.body.shape.bounding_radius_m};
  const Eigen::Vector3d normal = shown.orientation * contact.normal;
  const double distance_m = probe.radius_m + radius_m - contact.depth_m;
  const Eigen::Vector3d centre_m = probe.position_m - distance_m * normal;
  const Eigen::Vector3d contact_m =
      centre_m + radius_m / (probe.radius_m + radius_m) * distance_m * normal;
  touched.add({.position_m = centre_m,
               .velocity_m_s = shown.velocity_at(contact_m),
               .radius_m = radius_m,
               .material = field.body.material,
               .tool_sphere = tool_sphere,
               .swept = is_swept,
               .body = field.body.body,
               .presence = contact.stiffness_scale,
               .is_static = field.body.moving == 0,
               .field = number + 1,
               .energy_share = contact.map_scale / contact.stiffness_scale});
}

void meet(const Target& target, std::uint32_t tool_sphere, const PlacedToolSphere& probe,
          SampleBudget& budget, TouchedSpheres& touched) {
  const collision::FieldView& field = target.field.field;
  const Eigen::Vector3d from_m = target.before.into(probe.before_m),
                        to_m = target.shown.into(probe.position_m);
  if (!is_near(field.shape, from_m, to_m, probe.radius_m) || !budget.spend()) return;
  const auto contact = collision::field_contact(field, to_m, probe.radius_m);
  if (contact && contact->depth_m > 0.0)
    return add(target, *contact, false, tool_sphere, probe, touched);
  if (is_short_sweep((to_m - from_m).squaredNorm(), probe.radius_m)) return;
  if (const auto met = met_on_the_way(field, from_m, to_m, probe.radius_m, budget))
    add(target, *met, true, tool_sphere, probe, touched);
}

/// A field that moves, or nothing where its record is none. Pre: field.body.moving != 0.
std::optional<DisplayedField> shown_field(const publication::SceneField& field,
                                          const collision::GridView& moving,
                                          const display::SnapshotWeights& weights) {
  if (field.body.moving > moving.field_count) return std::nullopt;
  return display::displayed(collision::load_field(moving, field.body.moving), weights);
}

}  // namespace

void gather_moving_fields(std::span<const publication::SceneField> fields,
                          const collision::GridView& moving, const DisplayedMotion& shown,
                          std::span<const PlacedToolSphere> tool,
                          TouchedSpheres& touched) noexcept {
  SampleBudget budget{kMaxFieldSamples};
  for (std::uint32_t i = 0; i < fields.size(); ++i) {
    if (fields[i].body.moving == 0) continue;
    const auto now = shown_field(fields[i], moving, shown.now);
    const auto before = shown_field(fields[i], moving, shown.before);
    if (!now) continue;
    const Target target{fields[i], i, *now, before ? *before : *now};
    for (std::uint32_t k = 0; k < tool.size(); ++k) meet(target, k, tool[k], budget, touched);
  }
  touched.truncated = touched.truncated || budget.truncated;
}

void gather_static_fields(std::span<const publication::SceneField> fields,
                          std::span<const PlacedToolSphere> tool,
                          TouchedSpheres& touched) noexcept {
  SampleBudget budget{kMaxFieldSamples};
  for (std::uint32_t i = 0; i < fields.size(); ++i) {
    if (fields[i].body.moving != 0) continue;
    const DisplayedField rest = display::displayed(fields[i].body.rest);
    const Target target{fields[i], i, rest, rest};
    for (std::uint32_t k = 0; k < tool.size(); ++k) meet(target, k, tool[k], budget, touched);
  }
  touched.truncated = touched.truncated || budget.truncated;
}

}  // namespace stillgrid::rendering
