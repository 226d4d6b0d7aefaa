// What rows hold of contacts: constants, and the history from listing to listing.
#include <algorithm>
#include <utility>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/contact_history.hpp"
#include "shared/dynamics/contact_listing.hpp"

namespace stillgrid::dynamics {
namespace {

bool is_zero(const ContactRow& row, const RowPlace& place, std::size_t lane) {
  return row.push_impulse_N_s[lane] == 0.0F && place.stretch_m[0][lane] == 0.0F &&
         place.stretch_m[1][lane] == 0.0F && place.stretch_m[2][lane] == 0.0F;
}

/// Of the other side: what acts across changes its sign.
ContactHistory reversed(ContactHistory history) {
  for (std::size_t k = 0; k < 3; ++k) {
    history.friction_impulse_N_s[k] = -history.friction_impulse_N_s[k];
    history.stretch_m[k] = -history.stretch_m[k];
  }
  return history;
}

}  // namespace

ContactListing::Key ContactListing::key(std::size_t row, std::size_t lane, bool is_plane) const {
  const RowPlace& place = rows_.places[row];
  const std::int32_t a = order_[at(place.sphere_a[lane])], b = place.sphere_b[lane];
  if (is_plane) return {a, static_cast<std::int32_t>(description_.spheres.size()) + b, false};
  if (is_field(b))
    return {a, static_cast<std::int32_t>(description_.planes.size()) + listed_other(b), false};
  const std::int32_t other = order_[at(b)];
  return a < other ? Key{a, other, false} : Key{other, a, true};
}

/// Sorts by counting, which keeps the order of rows among contacts of one sphere.
void ContactListing::remember(const WorkSharing& sharing) {
  keys_.resize(kRowLanes * rows_.rows.size());
  each_row(rows_, sharing, [&](const RowGroup& group, std::size_t row) {
    for (std::size_t lane = 0; lane < kRowLanes; ++lane)
      keys_[kRowLanes * row + lane] =
          is_used(row, lane) && !is_zero(rows_.rows[row], rows_.places[row], lane)
              ? key(row, lane, group.b == SideKind::kPlane)
              : Key{-1, -1, false};
  });
  first_known_.assign(description_.spheres.size() + 1, 0);
  for (const Key& key : keys_)
    if (key.first >= 0) ++first_known_[at(key.first) + 1];
  if (is_sleep_new_)
    for (const SleepingContact& contact : sleeping_contacts_) ++first_known_[at(contact.first) + 1];
  for (std::size_t s = 1; s < first_known_.size(); ++s) first_known_[s] += first_known_[s - 1];
  known_.resize(at(first_known_.back()));
  sleeping_contacts_.reserve(known_.capacity());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const Key& key = keys_[i];
    if (key.first < 0) continue;
    const std::size_t row = i / kRowLanes, lane = i % kRowLanes;
    const ContactHistory history = history_of(rows_.rows[row], rows_.places[row], lane);
    known_[at(first_known_[at(key.first)]++)] = {key.second,
                                                 key.is_reversed ? reversed(history) : history};
  }
  if (is_sleep_new_)
    for (const SleepingContact& contact : sleeping_contacts_)
      known_[at(first_known_[at(contact.first)]++)] = {contact.second, contact.history};
  std::copy_backward(first_known_.begin(), first_known_.end() - 1, first_known_.end());
  first_known_.front() = 0;
}

/// Whether a side of a contact stays where it is; numbers are those of Description::side().
bool ContactListing::is_still(std::int32_t number) const {
  const Description::Side side = description_.side(at(number));
  if (side.plane != nullptr || (side.sphere != nullptr && sleeps(number))) return true;
  const int rigid = side.rigid();
  return rigid >= 0 && (rigid_sleeps(rigid) || description_.is_fixture(rigid));
}

/// Keeps the history of contacts between two sides that stay.
void ContactListing::add_sleepers() {
  sleeping_contacts_.clear();
  for (std::int32_t first = 0; at(first) < description_.spheres.size(); ++first) {
    if (!is_still(first)) continue;
    for (std::int32_t k = first_known_[at(first)]; k < first_known_[at(first) + 1]; ++k)
      if (is_still(known_[at(k)].second))
        sleeping_contacts_.push_back({first, known_[at(k)].second, known_[at(k)].history});
  }
}

void ContactListing::list_sleeper_lanes() {
  sleeper_lanes_.clear();
  sleeper_lanes_.reserve(kRowLanes * rows_.rows.capacity());
  if (sleeps_.empty()) return;
  const auto sleeps_b = [&](std::int32_t b) {
    return is_field(b) ? rigid_sleeps(field_of(b).rigid) : sleeps(order_[at(b)]);
  };
  for (const RowGroup& group : rows_.groups) {
    if (group.b == SideKind::kPlane) continue;
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane)
        if (is_used(row, lane) && (sleeps(order_[at(rows_.places[row].sphere_a[lane])]) ||
                                   sleeps_b(rows_.places[row].sphere_b[lane])))
          sleeper_lanes_.push_back(
              {static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(lane)});
  }
}

double ContactListing::stiffness_N_per_m(std::int32_t first, std::int32_t second) const {
  const int a = description_.spheres[at(first)].material;
  const int b = description_.side(at(second)).material();
  return constants_[at(a) * description_.materials.size() + at(b)].stiffness_N_per_m;
}

void ContactListing::recall(const WorkSharing& sharing) {
  each_row(rows_, sharing, [&](const RowGroup& group, std::size_t row) {
    for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
      if (!is_used(row, lane)) continue;
      const Key contact = key(row, lane, group.b == SideKind::kPlane);
      const auto first = known_.begin() + first_known_[at(contact.first)];
      const auto end = known_.begin() + first_known_[at(contact.first) + 1];
      const auto found = std::find_if(
          first, end, [&](const KnownContact& known) { return known.second == contact.second; });
      if (found != end)
        set_history(contact.is_reversed ? reversed(found->history) : found->history,
                    rows_.rows[row], rows_.places[row], lane);
    }
  });
}

/// A tool has no material: its contacts have that of the other side.
ContactListing::PairConstants ContactListing::constants_of(const NearSphere& a,
                                                           const NearSphere& b) const {
  if (!a.is_tool && !b.is_tool)
    return constants_[at(a.material) * description_.materials.size() + at(b.material)];
  const float slip_speed = std::max(a.tool_slip_speed_m_s, b.tool_slip_speed_m_s);
  const auto material_of_other = at(a.is_tool ? b.material : a.material);
  if (slip_speed == 0.0F)
    return constants_[material_of_other * (description_.materials.size() + 1)];
  const collision::ContactMaterial material =
      collision::tool_material(description_.materials[material_of_other], slip_speed);
  return {static_cast<float>(material.stiffness_N_per_m),
          static_cast<float>(material.damping_N_s_per_m), static_cast<float>(material.friction),
          static_cast<float>(1.0 / material.slip_speed_m_s)};
}

void ContactListing::derive_lane(std::size_t index, std::size_t lane, bool is_plane) {
  ContactRow& row = rows_.rows[index];
  RowPlace& place = rows_.places[index];
  row.mover_a[lane] = row.mover_b[lane] = world();
  if (place.sphere_a[lane] < 0) {
    // Some sphere is read, and is too far for anything to come of it.
    place.sphere_a[lane] = place.sphere_b[lane] = 0;
    place.apart_m[0][lane] = 1e6F;
    row.normal[0][lane] = place.radii_m[lane] = 1.0F;
    return;
  }
  const NearSphere& a = near_spheres_[at(place.sphere_a[lane])];
  const Vector4& base_a = base_[at(place.sphere_a[lane])];
  row.mover_a[lane] = a.mover;
  const bool is_field = !is_plane && this->is_field(place.sphere_b[lane]);
  Vector4 apart;
  double radii = a.radius_m;
  PairConstants constants;
  if (is_plane) {
    const Description::Plane& plane = description_.planes[at(place.sphere_b[lane])];
    apart = Vector4((plane.normal.dot(base_a.vector()) - plane.offset_m) * plane.normal);
    for (std::size_t k = 0; k < 3; ++k)
      row.normal[k][lane] = static_cast<float>(plane.normal[static_cast<Eigen::Index>(k)]);
    constants = constants_[at(a.material) * description_.materials.size() + at(plane.material)];
  } else {
    const NearSphere& b = near_spheres_[at(place.sphere_b[lane])];
    row.mover_b[lane] = b.mover;
    if (!is_field) apart = base_a - base_[at(place.sphere_b[lane])];
    radii += b.radius_m;
    constants = constants_of(a, b);
  }
  place.apart_m[0][lane] = static_cast<float>(apart.x);
  place.apart_m[1][lane] = static_cast<float>(apart.y);
  place.apart_m[2][lane] = static_cast<float>(apart.z);
  place.radii_m[lane] = static_cast<float>(radii);
  place.stiffness_N_per_m[lane] = constants.stiffness_N_per_m;
  place.damping_N_s_per_m[lane] = constants.damping_N_s_per_m;
  row.friction[lane] = constants.friction;
  row.viscous_s_per_m[lane] = constants.viscous_s_per_m;
  if (is_field) add_field_lane(index, lane);
  if (has_proxy(place.sphere_a[lane]))
    add_tool_lane(index, lane, place.sphere_a[lane], place.sphere_b[lane], true);
  else if (!is_plane && !is_field && has_proxy(place.sphere_b[lane]))
    add_tool_lane(index, lane, place.sphere_b[lane], place.sphere_a[lane], false);
}

void ContactListing::derive_row(const RowGroup& group, std::size_t row) {
  const auto set_nodes = [&](SoftSide& side, std::size_t lane, std::int32_t place, bool is_used) {
    for (std::size_t k = 0; k < 4; ++k) side.node[k][lane] = world();
    if (!is_used) return;
    const Description::Sphere& sphere = description_.spheres[at(order_[at(place)])];
    for (std::size_t k = 0; k < at(sphere.node_count); ++k) {
      side.node[k][lane] = sphere.nodes[k];
      side.weight[k][lane] = static_cast<float>(sphere.weights[k]);
    }
  };
  const RowPlace kept = rows_.places[row];
  rows_.rows[row] = ContactRow{};
  rows_.places[row] = RowPlace{};
  for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
    rows_.places[row].sphere_a[lane] = kept.sphere_a[lane];
    rows_.places[row].sphere_b[lane] = kept.sphere_b[lane];
    derive_lane(row, lane, group.b == SideKind::kPlane);
    const bool is_used = kept.sphere_a[lane] >= 0;
    const std::size_t k = row - group.first;
    if (group.a == SideKind::kSoft)
      set_nodes(rows_.soft_sides[group.first_side_a + k], lane, kept.sphere_a[lane], is_used);
    if (group.b == SideKind::kSoft)
      set_nodes(rows_.soft_sides[group.first_side_b + k], lane, kept.sphere_b[lane], is_used);
  }
}

/// Pre: the places of rows hold their spheres, and everything else is theirs to compute.
void ContactListing::derive(const WorkSharing& sharing) {
  field_lanes_.clear();
  tool_lanes_.clear();
  std::size_t soft = 0, rigid = 0;
  const auto reserve = [&](SideKind kind, std::size_t count) {
    std::size_t& sides = kind == SideKind::kSoft ? soft : rigid;
    const std::size_t first = sides;
    if (kind == SideKind::kSoft || kind == SideKind::kRigid) sides += count;
    return first;
  };
  for (RowGroup& group : rows_.groups) {
    group.first_side_a = reserve(group.a, group.end - group.first);
    group.first_side_b = reserve(group.b, group.end - group.first);
  }
  // As many rows of other kinds may need more sides than these.
  rows_.soft_sides.reserve(2 * rows_.rows.capacity());
  rows_.rigid_sides.reserve(2 * rows_.rows.capacity());
  rows_.soft_sides.assign(soft, SoftSide{});
  rows_.rigid_sides.assign(rigid, RigidSide{});
  const auto is_alone = [](const RowGroup& group) { return is_of_balls(group.a, group.b); };
  each_row(rows_, sharing, [&](const RowGroup& group, std::size_t row) {
    if (is_alone(group)) derive_row(group, row);
  });
  // Those of tools and fields are listed one after another.
  each_row(rows_, WorkSharing::alone(), [&](const RowGroup& group, std::size_t row) {
    if (!is_alone(group)) derive_row(group, row);
  });
}

}  // namespace stillgrid::dynamics
