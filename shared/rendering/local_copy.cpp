#include "shared/rendering/local_copy.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "shared/rendering/tool_force.hpp"

namespace stillgrid::rendering {
namespace {

/// Numbers of the fields that move. The fields of a segment and of its model are both in the order
/// of the simulation's World::fields (sim_server/published_scene.cpp, described_world.cpp), so one
/// number is of the same field in both.
std::vector<std::size_t> moving_among(std::span<const publication::SceneField> fields) {
  std::vector<std::size_t> moving;
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (fields[i].body.moving != 0) moving.push_back(i);
  return moving;
}

/// A field's frame, which has a pose in its rigid body.
proto::FieldState state_of(const dynamics::Description::Field& field,
                           const dynamics::SceneState& state) noexcept {
  const auto rigid = static_cast<std::size_t>(field.rigid);
  const Eigen::Quaterniond turn = state.orientation[rigid].quaternion();
  const Eigen::Vector3d arm_m = turn * field.position_m;
  const Eigen::Vector3d spin_rad_s = state.angular_velocity_rad_s[rigid].vector();
  return publication::field_state(
      state.rigid_position_m[rigid].vector() + arm_m, turn * field.orientation,
      state.rigid_velocity_m_s[rigid].vector() + spin_rad_s.cross(arm_m), spin_rad_s);
}

LocalCopy::Scene scene_of(const publication::SceneView& view) {
  const std::size_t hands = std::max(view.scene().hand_count, 1U), own = view.scene().hand;
  if (local::is_given_model(view.model()))
    return LocalCopy::Scene(std::in_place_type<local::GivenScene>, view.model(), hands, own);
  return LocalCopy::Scene(std::in_place_type<local::LocalScene>, view.model(),
                          publication::copy_fields(view.fields(), view.reader().fixed_bytes()),
                          hands, own);
}

}  // namespace

/// Moving spheres come first in a model. Fields: see moving_among().
LocalCopy::LocalCopy(const publication::SceneView& view)
    : scene_(scene_of(view)),
      records_(is_given() ? 0 : view.scene().moving_capacity),
      fields_(moving_among(view.fields())),
      field_words_(fields_.records().size_bytes() / 8) {
  loaded_.reserve(view.scene().state_capacity);
  if (!is_given()) declare(view.scene().moving_capacity);
}

void LocalCopy::declare(std::size_t count) {
  const auto& spheres = std::get<local::LocalScene>(scene_).description().spheres;
  if (count > spheres.size()) throw std::invalid_argument("the model has too few spheres");
  std::vector<double> radii_m;
  std::vector<std::uint32_t> materials, bodies;
  for (std::size_t i = 0; i < count; ++i) {
    radii_m.push_back(spheres[i].radius_m);
    materials.push_back(spheres[i].is_field_point
                            ? proto::kFieldPoint
                            : static_cast<std::uint32_t>(spheres[i].material));
    bodies.push_back(static_cast<std::uint32_t>(spheres[i].body));
  }
  records_.declare({.struct_size = sizeof(stillgrid_shapes),
                    .count = static_cast<std::uint32_t>(count),
                    .radii_m = radii_m.data(),
                    .materials = materials.data(),
                    .bodies = bodies.data(),
                    .positions_m = nullptr});
  for (std::size_t i = 0; i < count; ++i)
    records_.records()[i].crushing_force_N = static_cast<float>(spheres[i].crushing_force_N);
  positions_m_.resize(3 * count);
  velocities_m_s_.resize(3 * count);
}

void LocalCopy::replace(std::span<const PlacedToolSphere> tool,
                        TouchedSpheres& touched) const noexcept {
  const auto& scene = std::get<local::GivenScene>(scene_);
  const local::GivenBodies& given = scene.bodies();
  touched.remove_if([&](const TouchedSphere& sphere) {
    return std::ranges::binary_search(given.bodies(), sphere.body, {}, &local::GivenBody::number);
  });
  for (std::size_t k = 0; k < given.spheres().size(); ++k) {
    const local::GivenSphere& sphere = given.spheres()[k];
    TouchedSphere touch{.position_m = scene.position_m(k),
                        .velocity_m_s = Eigen::Vector3d::Zero(),
                        .radius_m = sphere.radius_m,
                        .material = sphere.material,
                        .tool_sphere = 0,
                        .number = sphere.number,
                        .body = given.bodies()[sphere.body].number};
    touch.is_given = true;
    for (std::uint32_t i = 0; i < tool.size(); ++i) {
      const double touching_m = gathered_within_m(tool[i], sphere.radius_m);
      // Written so that a NaN does not pass.
      if (!((touch.position_m - tool[i].position_m).squaredNorm() < touching_m * touching_m))
        continue;
      touch.tool_sphere = i;
      touch.velocity_m_s = given.velocity_m_s(sphere, contact_with(touch, tool[i]).point_m);
      touched.add(touch);
    }
  }
}

void LocalCopy::show_spheres() {
  const auto& scene = std::get<local::LocalScene>(scene_);
  const dynamics::SceneState& state = scene.state();
  for (std::size_t i = 0; i < positions_m_.size() / 3; ++i) {
    const dynamics::Description::Sphere& sphere = scene.description().spheres[i];
    Eigen::Vector3d::Map(&positions_m_[3 * i]) =
        dynamics::sphere_position_m(sphere, state).vector();
    Eigen::Vector3d::Map(&velocities_m_s_[3 * i]) = dynamics::sphere_velocity_m_s(sphere, state);
  }
  records_.place(positions_m_.data(), velocities_m_s_.data(), dynamics::kTick_s);
}

void LocalCopy::show_fields() noexcept {
  const auto& scene = std::get<local::LocalScene>(scene_);
  fields_.show([&](std::size_t field) {
    return state_of(scene.description().fields[field], scene.state());
  });
  if (!field_words_.empty())
    std::memcpy(field_words_.data(), fields_.records().data(), fields_.records().size_bytes());
}

void LocalCopy::show() {
  show_spheres();
  show_fields();
}

collision::GridView LocalCopy::view() const noexcept {
  collision::GridView view = records_.grid().view();
  view.fields = field_words_.data();
  view.field_count = static_cast<std::uint32_t>(fields_.records().size());
  return view;
}

}  // namespace stillgrid::rendering
