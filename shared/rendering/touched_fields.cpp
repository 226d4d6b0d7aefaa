#include "shared/rendering/touched_fields.hpp"

#include <algorithm>
#include <cmath>

#include "shared/rendering/field_sweep.hpp"
#include "shared/rendering/tool_sweep.hpp"

namespace stillgrid::rendering {
namespace {

using display::DisplayedField;

/// A field in one tick, for all spheres of the tool.
struct Target {
  const publication::SceneField& field;
  std::uint32_t number;  // among the scene's
  const ShownField& shown;
  const DisplayedField& before;  // in the tick before, but for what has given way since
  const CompliantDisplay& compliant;
};

/// Whether a sphere can have met the solid, or come within slack_m, on a straight way.
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
  if (touched.count == TouchedSpheres::kCapacity ||
      touched.field_count == TouchedSpheres::kFieldCapacity) {
    touched.truncated = true;
    return;
  }
  const auto& [field, number, shown, before, compliant] = target;
  const double radius_m = double{field.body.shape.bounding_radius_m};
  const Eigen::Vector3d normal = shown.at.orientation * contact.normal;
  const double distance_m = probe.radius_m + radius_m - contact.depth_m;
  const Eigen::Vector3d centre_m = probe.position_m - distance_m * normal;
  const Eigen::Vector3d to_contact_m = radius_m / (probe.radius_m + radius_m) * distance_m * normal;
  const Eigen::Vector3d point_m = shown.at.into(centre_m + to_contact_m);
  const Eigen::Vector3d base_point_m = shown.base.out_of(point_m);

  TouchedField& own = touched.fields[touched.field_count++];
  own = {number, to_contact_m, point_m, contact.map_scale / contact.stiffness_scale};
  TouchedSphere& touch = touched.spheres[touched.count++];
  touch = {.position_m = centre_m,
           .velocity_m_s = shown.base.velocity_at(base_point_m),
           .radius_m = radius_m,
           .material = field.body.material,
           .tool_sphere = tool_sphere,
           .swept = is_swept,
           .body = field.body.body,
           .led_m_s = shown.led.velocity_at(base_point_m),
           .presence = contact.stiffness_scale,
           .is_static = field.body.moving == 0,
           .field = static_cast<std::uint32_t>(touched.field_count)};
  touch.base_m = touch.seen_m = centre_m;
  touch.base_m_s = touch.velocity_m_s;
  const auto response = shown.response_at(base_point_m, compliant.motion.largest_response);
  if (!response || touched.response_count == TouchedSpheres::kResponseCapacity) return;
  touched.responses[touched.response_count++] = *response;
  touch.response = static_cast<std::uint32_t>(touched.response_count);
  const display::ModeMotion& motion = compliant.motion;
  const Eigen::Vector3d way_m = response->cast<double>() * motion.displacements;
  touch.base_m -= way_m + motion.curved_m(touch.body, base_point_m);
  give_way(motion, *response, touch, to_contact_m);
}

void meet(const Target& target, std::uint32_t tool_sphere, const PlacedToolSphere& probe,
          SampleBudget& budget, TouchedSpheres& touched) {
  const collision::FieldView& field = target.field.field;
  const double slack_m = target.shown.response ? target.compliant.slack_m : 0.0;
  const Eigen::Vector3d from_m = target.before.into(probe.before_m),
                        to_m = target.shown.at.into(probe.position_m);
  if (!is_near(field.shape, from_m, to_m, probe.radius_m + slack_m) || !budget.spend()) return;
  const auto contact = collision::field_contact(field, to_m, probe.radius_m);
  if (contact && contact->depth_m > -slack_m)
    return add(target, *contact, false, tool_sphere, probe, touched);
  if (is_short_sweep((to_m - from_m).squaredNorm(), probe.radius_m)) return;
  if (const auto met = met_on_the_way(field, from_m, to_m, probe.radius_m, budget))
    add(target, *met, true, tool_sphere, probe, touched);
}

/// Where it is with what the hand has pushed it to, and what a switch has shifted it by.
void displace(const CompliantDisplay& compliant, std::uint32_t body,
              const std::optional<display::FieldResponse>& response, DisplayedField& field) {
  field.position_m += compliant.share * compliant.shifts.of(body);
  if (response) field = display::given_way(field, *response, compliant.motion.displacements);
}

}  // namespace

std::optional<display::ResponseMatrix> ShownField::response_at(
    const Eigen::Vector3d& point_m, double largest_response) const noexcept {
  if (!response) return std::nullopt;
  const display::ResponseMatrix own = response->at(point_m - base.position_m);
  // Written so that a NaN does not pass.
  if (!(static_cast<double>(own.squaredNorm()) <= largest_response * largest_response))
    return std::nullopt;
  return own;
}

std::optional<ShownField> shown_field(const publication::SceneField& field,
                                      const collision::GridView& moving,
                                      const display::SnapshotWeights& weights,
                                      const CompliantDisplay& compliant) noexcept {
  if (field.body.moving > moving.field_count) return std::nullopt;
  const proto::FieldRecord record = collision::load_field(moving, field.body.moving);
  const auto base = display::displayed(record, weights);
  if (!base) return std::nullopt;
  ShownField shown{.base = *base, .at = *base, .led = *base, .response = std::nullopt};
  shown.base.position_m += compliant.share * compliant.shifts.of(field.body.body);
  if (weights.prediction_s > 0.0) shown.led = display::led_on(shown.base, record);
  shown.response = display::response_of(moving, record, compliant.motion.largest_response);
  displace(compliant, field.body.body, shown.response, shown.at);
  return shown;
}

std::optional<display::ResponseMatrix> response_in(std::span<const publication::SceneField> fields,
                                                   const collision::GridView& moving,
                                                   const TouchedField& touched,
                                                   const display::SnapshotWeights& weights,
                                                   const CompliantDisplay& compliant) noexcept {
  const auto shown = shown_field(fields[touched.field], moving, weights, compliant);
  if (!shown) return std::nullopt;
  return shown->response_at(shown->base.out_of(touched.point_m), compliant.motion.largest_response);
}

std::optional<Eigen::Vector3d> displayed_m(std::span<const publication::SceneField> fields,
                                           const collision::GridView& moving,
                                           const TouchedField& touched,
                                           const display::SnapshotWeights& weights,
                                           const CompliantDisplay& compliant) noexcept {
  const auto shown = shown_field(fields[touched.field], moving, weights, compliant);
  if (!shown) return std::nullopt;
  return Eigen::Vector3d(shown->at.out_of(touched.point_m) - touched.to_contact_m);
}

void gather_moving_fields(std::span<const publication::SceneField> fields,
                          const collision::GridView& moving, const DisplayedMotion& shown,
                          std::span<const PlacedToolSphere> tool,
                          TouchedSpheres& touched) noexcept {
  const CompliantDisplay& compliant = shown.compliant_display;
  SampleBudget budget{kMaxFieldSamples};
  for (std::uint32_t i = 0; i < fields.size(); ++i) {
    if (fields[i].body.moving == 0) continue;
    const auto now = shown_field(fields[i], moving, shown.now, compliant);
    const auto before = shown_field(fields[i], moving, shown.before, compliant);
    if (!now) continue;
    const DisplayedField& at_before = before ? before->at : now->at;
    const Target target{fields[i], i, *now, at_before, compliant};
    for (std::uint32_t k = 0; k < tool.size(); ++k) meet(target, k, tool[k], budget, touched);
  }
  touched.truncated = touched.truncated || budget.truncated;
}

void gather_static_fields(std::span<const publication::SceneField> fields,
                          std::span<const PlacedToolSphere> tool,
                          TouchedSpheres& touched) noexcept {
  SampleBudget budget{kMaxFieldSamples};
  const CompliantDisplay stiff;
  for (std::uint32_t i = 0; i < fields.size(); ++i) {
    if (fields[i].body.moving != 0) continue;
    const DisplayedField rest = display::displayed(fields[i].body.rest);
    const ShownField still{.base = rest, .at = rest, .led = rest, .response = std::nullopt};
    const Target target{fields[i], i, still, rest, stiff};
    for (std::uint32_t k = 0; k < tool.size(); ++k) meet(target, k, tool[k], budget, touched);
  }
  touched.truncated = touched.truncated || budget.truncated;
}

}  // namespace stillgrid::rendering
