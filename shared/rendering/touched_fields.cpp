#include "shared/rendering/touched_fields.hpp"

#include "shared/collision/grid_query.hpp"
#include "shared/display/displayed_field.hpp"

namespace stillgrid::rendering {
namespace {

using display::DisplayedField;

/// Samples of fields that a gathering may still take.
struct SampleBudget {
  std::uint32_t left = kMaxFieldSamples;
  bool truncated = false;

  [[nodiscard]] bool spend() {
    truncated = truncated || left == 0;
    left -= left > 0 ? 1 : 0;
    return !truncated;
  }
};

/// A field in one tick, for all spheres of the tool.
struct Target {
  const publication::SceneField& field;
  std::uint32_t number;         // among the scene's
  const DisplayedField& shown;  // in this tick
};

void meet(const Target& target, std::uint32_t tool_sphere, const PlacedToolSphere& probe,
          SampleBudget& budget, TouchedSpheres& touched) {
  const auto& [field, number, shown] = target;
  const proto::FieldShape& shape = field.field.shape;
  const Eigen::Vector3d at_m = shown.into(probe.position_m);
  const double radius_m = double{shape.bounding_radius_m};
  const Eigen::Vector3d away_m =
      at_m - Eigen::Vector3d(shape.centre_m[0], shape.centre_m[1], shape.centre_m[2]);
  // Written so that a NaN does not pass.
  if (!(away_m.norm() < radius_m + probe.radius_m) || !budget.spend()) return;
  auto contact = collision::field_contact(field.field, at_m, probe.radius_m);
  if (contact && probe.device_m && collision::is_flat(*contact) && budget.spend() && budget.spend())
    contact = collision::flat_contact(field.field, *contact, at_m, shown.into(*probe.device_m),
                                      probe.radius_m);
  if (!contact || !(contact->depth_m > 0.0)) return;
  const Eigen::Vector3d normal = shown.orientation * contact->normal;
  const double distance_m = probe.radius_m + radius_m - contact->depth_m;
  const Eigen::Vector3d centre_m = probe.position_m - distance_m * normal;
  const Eigen::Vector3d contact_m =
      centre_m + radius_m / (probe.radius_m + radius_m) * distance_m * normal;
  touched.add({.position_m = centre_m,
               .velocity_m_s = shown.velocity_at(contact_m),
               .radius_m = radius_m,
               .material = field.body.material,
               .tool_sphere = tool_sphere,
               .body = field.body.body,
               .presence = contact->stiffness_scale,
               .is_static = field.body.moving == 0,
               .field = number + 1,
               .energy_share = contact->map_scale / contact->stiffness_scale});
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
                          const collision::GridView& moving, const display::SnapshotWeights& shown,
                          std::span<const PlacedToolSphere> tool,
                          TouchedSpheres& touched) noexcept {
  SampleBudget budget;
  for (std::uint32_t i = 0; i < fields.size(); ++i) {
    if (fields[i].body.moving == 0) continue;
    const auto now = shown_field(fields[i], moving, shown);
    if (!now) continue;
    const Target target{fields[i], i, *now};
    for (std::uint32_t k = 0; k < tool.size(); ++k) meet(target, k, tool[k], budget, touched);
  }
  touched.truncated = touched.truncated || budget.truncated;
}

void gather_static_fields(std::span<const publication::SceneField> fields,
                          std::span<const PlacedToolSphere> tool,
                          TouchedSpheres& touched) noexcept {
  SampleBudget budget;
  for (std::uint32_t i = 0; i < fields.size(); ++i) {
    if (fields[i].body.moving != 0) continue;
    const DisplayedField rest = display::displayed(fields[i].body.rest);
    const Target target{fields[i], i, rest};
    for (std::uint32_t k = 0; k < tool.size(); ++k) meet(target, k, tool[k], budget, touched);
  }
  touched.truncated = touched.truncated || budget.truncated;
}

}  // namespace stillgrid::rendering
