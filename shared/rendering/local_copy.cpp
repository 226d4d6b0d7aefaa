#include "shared/rendering/local_copy.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>

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

}  // namespace

/// Moving spheres come first in a model. Fields: see moving_among().
LocalCopy::LocalCopy(const publication::SceneView& view)
    : scene_(view.model(), publication::copy_fields(view.fields(), view.reader().fixed_bytes()),
             std::max(view.scene().hand_count, 1U), view.scene().hand),
      records_(view.scene().moving_capacity),
      fields_(moving_among(view.fields())),
      field_words_(fields_.records().size_bytes() / 8) {
  const auto& spheres = scene_.description().spheres;
  const std::size_t count = view.scene().moving_capacity;
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
  loaded_.reserve(view.scene().state_capacity);
  positions_m_.resize(3 * count);
  velocities_m_s_.resize(3 * count);
}

void LocalCopy::show_spheres() {
  const dynamics::SceneState& state = scene_.state();
  for (std::size_t i = 0; i < positions_m_.size() / 3; ++i) {
    const dynamics::Description::Sphere& sphere = scene_.description().spheres[i];
    Eigen::Vector3d::Map(&positions_m_[3 * i]) =
        dynamics::sphere_position_m(sphere, state).vector();
    Eigen::Vector3d::Map(&velocities_m_s_[3 * i]) = dynamics::sphere_velocity_m_s(sphere, state);
  }
  records_.place(positions_m_.data(), velocities_m_s_.data(), dynamics::kTick_s);
}

void LocalCopy::show_fields() noexcept {
  fields_.show([&](std::size_t field) {
    return state_of(scene_.description().fields[field], scene_.state());
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
