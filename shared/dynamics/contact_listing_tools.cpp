// Contacts of tools that have proxies.
#include <algorithm>
#include <utility>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/field_geometry.hpp"

namespace stillgrid::dynamics {
/// Keeps a tool's contact with what never moves out of the rows. Returns whether it is one.
bool ContactListing::add_fixture(std::int32_t place, std::int32_t other) {
  const NearSphere &a = near_spheres_[at(place)], &b = near_spheres_[at(other)];
  const bool is_a = a.is_tool && description_.is_fixture(b.rigid);
  if (!is_a && !(b.is_tool && description_.is_fixture(a.rigid))) return false;
  if (!is_a) std::swap(place, other);
  if (!has_proxy(place)) return true;
  const auto tool = std::ranges::lower_bound(tools_, order_[at(place)]) - tools_.begin();
  const auto spheres = static_cast<std::int32_t>(description_.spheres.size());
  fixtures_.push_back({static_cast<std::int32_t>(tool),
                       other < spheres
                           ? order_[at(other)]
                           : other + static_cast<std::int32_t>(description_.planes.size())});
  return true;
}

void ContactListing::add_tool_lane(std::size_t row, std::size_t lane, std::int32_t tool,
                                   std::int32_t other, bool is_a) {
  const RowPlace& place = rows_.places[row];
  ToolLane& added = tool_lanes_.emplace_back();
  added.row = static_cast<std::uint32_t>(row);
  added.lane = static_cast<std::uint32_t>(lane);
  added.tool = static_cast<std::int32_t>(std::ranges::lower_bound(tools_, order_[at(tool)]) -
                                         tools_.begin());
  added.is_a = is_a;
  added.apart_m = {place.apart_m[0][lane], place.apart_m[1][lane], place.apart_m[2][lane]};
  added.stiffness_N_per_m = place.stiffness_N_per_m[lane];
  added.damping_N_s_per_m = place.damping_N_s_per_m[lane];
  if (!is_field(other)) {
    added.other = order_[at(other)];
    return;
  }
  FieldLane& field = field_lanes_[at(other) - description_.spheres.size()];
  added.other = static_cast<std::int32_t>(description_.field_number(at(field.field)));
  field.tool_lane = static_cast<std::int32_t>(tool_lanes_.size()) - 1;
}

const ToolLane* ContactListing::tool_lane(std::size_t row, std::size_t lane) const {
  const auto order = [](const ToolLane& tool) { return std::pair(tool.row, tool.lane); };
  const std::pair sought(static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(lane));
  const auto found = std::ranges::lower_bound(tool_lanes_, sought, {}, order);
  return found != tool_lanes_.end() && order(*found) == sought ? &*found : nullptr;
}

double ContactListing::tool_depth_m(const ToolLane& lane, const SceneState& state) const {
  const Description::Sphere& tool = description_.spheres[at(tools_[at(lane.tool)])];
  const Description::Side other = description_.side(at(lane.other));
  const Eigen::Vector3d tool_m = sphere_position_m(tool, state).vector() + lane.shift_m;
  if (other.field != nullptr && !lane.is_held)
    return tangent_sphere(*other.field, field_pose(*other.field, state), tool_m, tool.radius_m)
        .depth_m;
  if (other.field != nullptr)
    return tool.radius_m + field_radius_m(*other.field) -
           (tool_m - field_pose(*other.field, state).out_of(lane.centre_m)).norm();
  return tool.radius_m + other.sphere->radius_m -
         (tool_m - sphere_position_m(*other.sphere, state).vector()).norm();
}

}  // namespace stillgrid::dynamics
