#include "sim_server/contact/predicted_contacts.hpp"

#include <algorithm>
#include <limits>

#include "proto/scene_segment.hpp"
#include "shared/collision/grid_query.hpp"

namespace stillgrid::contact {

void PredictedContacts::take(const bodies::World& world, const Detection& detection,
                             std::span<const std::uint32_t> spheres, double step_s) {
  if (!moving_ || !std::equal(spheres.begin(), spheres.end(), spheres_.begin(), spheres_.end())) {
    spheres_.assign(spheres.begin(), spheres.end());
    motion_.resize(spheres.size());
    ways_.resize(spheres.size());
    moving_ = std::make_unique<MovingSpheres>(spheres.size(), 0.0F, groups_of(world, spheres));
    has_body_.assign(world.bodies.size(), 0);
    for (const std::uint32_t sphere : spheres)
      has_body_[static_cast<std::size_t>(world.spheres[sphere].body)] = 1;
  }
  bodies::SphereMotions motion_of(world.nodes, world.rigid_bodies);
  for (std::size_t k = 0; k < spheres_.size(); ++k) {
    const bodies::SphereBinding& sphere = world.spheres[spheres_[k]];
    motion_[k] = motion_of(sphere);
    ways_[k] = way_bound(world, sphere, motion_[k], detection.moves(spheres_[k]) ? step_s : 0.0);
  }
  if (!fields_) fields_.emplace(world.fields.size());
  fields_->take(world, step_s);
}

/// What they meet but the tool.
void PredictedContacts::add_fields(const bodies::World& world, const Detection& detection) {
  for (std::size_t field = 0; field < fields_->size(); ++field) {
    const FieldWay& way = (*fields_)[field];
    if (!is_known(world, field)) continue;
    find_ascending(moving_->grid(), way.ball, met_);
    for (const std::uint32_t k : met_) {
      const std::uint32_t sphere = spheres_[k];
      if (world.spheres[sphere].body != world.fields[field].body &&
          (detection.is_free(sphere) || way.is_free) && (detection.moves(sphere) || way.moves) &&
          bodies::may_collide(world, world.spheres[sphere].body, world.fields[field].body) &&
          fields_->may_meet(world, field, ways_[k]))
        fields_->add_sphere(world, field, mover(k), contacts_);
    }
    if (way.is_free && way.moves)
      fields_->add_static(world, field, detection.static_grid(), met_, contacts_);
  }
}

/// A field whose body does not move, or is among those that are predicted.
bool PredictedContacts::is_known(const bodies::World& world, std::size_t field) const {
  const bodies::FieldBody& own = world.fields[field];
  return own.rigid < 0 || has_body_[static_cast<std::size_t>(own.body)] != 0;
}

bool PredictedContacts::find(const bodies::World& world, const Detection& detection,
                             std::span<const std::uint32_t> spheres, double step_s,
                             const std::vector<ToolSphereMotion>& tool) {
  contacts_.clear();
  if (spheres.empty()) return true;
  take(world, detection, spheres, step_s);
  const auto may_collide = [&](std::uint32_t k, std::uint32_t l) {
    return detection.may_collide(world, spheres_[k], spheres_[l]);
  };
  bool is_any_fast = false;
  for (std::size_t k = 0; k < spheres_.size(); ++k)
    is_any_fast = is_any_fast || is_fast(ways_[k], world.spheres[spheres_[k]].radius_m);
  constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();
  const auto pairs =
      moving_->find_at_most(ways_, may_collide, is_any_fast ? most_pairs(spheres.size()) : kAny);
  if (!pairs || (is_any_fast && pairs->size() > most_contacts(spheres.size()))) return false;
  for (const auto& [k, l] : *pairs)
    if (detection.moves(spheres_[k]) || detection.moves(spheres_[l]))
      add_pair(world, mover(k), mover(l), contacts_);
  const auto feels = [&](std::uint32_t k) { return detection.is_free(spheres_[k]); };
  const auto count = static_cast<std::uint32_t>(spheres_.size());
  for (std::uint32_t k = 0; k < count; ++k) {
    if (!feels(k) || !detection.moves(spheres_[k])) continue;
    if (!world.spheres[spheres_[k]].is_field_point)
      add_static(world, detection.static_grid(), mover(k), contacts_);
    for (const bodies::StaticPlane& plane : world.planes)
      if (may_touch(world, plane, mover(k), step_s)) add_plane(world, plane, mover(k), contacts_);
  }
  add_fields(world, detection);
  for (std::size_t number = 0; number < tool.size(); ++number) {
    collision::SweptBound way = bound_of(tool[number]);
    way.bounding_radius_m +=
        static_cast<float>(proto::kPredictionPeriods * step_s * tool[number].velocity_m_s.norm());
    find_ascending(moving_->grid(), way, met_);
    for (const std::uint32_t k : met_)
      if (feels(k) && !world.spheres[spheres_[k]].is_field_point && collision::meet(ways_[k], way))
        add_tool(world, mover(k), tool[number], static_cast<int>(number), contacts_);
    for (std::size_t field = 0; field < fields_->size(); ++field)
      if ((*fields_)[field].is_free && is_known(world, field))
        fields_->add_tool(world, field, tool[number], way, static_cast<int>(number), contacts_);
  }
  return true;
}

}  // namespace stillgrid::contact
