// What rows hold of contacts: constants, and the history from listing to listing.
#include <algorithm>
#include <utility>

#include "shared/dynamics/contact_listing.hpp"

namespace stillgrid::dynamics {
namespace {

std::size_t at(std::int32_t index) {
  return static_cast<std::size_t>(index);
}

ContactHistory history_of(const ContactRow& row, const RowPlace& place, std::size_t lane) {
  ContactHistory history{.push_N_s = row.push_N_s[lane]};
  for (std::size_t k = 0; k < 3; ++k) {
    history.drag_N_s[k] = row.drag_N_s[k][lane];
    history.stretch_m[k] = place.stretch_m[k][lane];
  }
  return history;
}

void set_history(const ContactHistory& history, ContactRow& row, RowPlace& place,
                 std::size_t lane) {
  row.push_N_s[lane] = history.push_N_s;
  for (std::size_t k = 0; k < 3; ++k) {
    row.drag_N_s[k][lane] = history.drag_N_s[k];
    place.stretch_m[k][lane] = history.stretch_m[k];
  }
}

bool is_zero(const ContactHistory& history) {
  return history.push_N_s == 0.0F && history.stretch_m[0] == 0.0F &&
         history.stretch_m[1] == 0.0F && history.stretch_m[2] == 0.0F;
}

/// Of the other side: what acts across changes its sign.
ContactHistory reversed(ContactHistory history) {
  for (std::size_t k = 0; k < 3; ++k) {
    history.drag_N_s[k] = -history.drag_N_s[k];
    history.stretch_m[k] = -history.stretch_m[k];
  }
  return history;
}

}  // namespace

KnownContact ContactListing::known(std::size_t row, std::size_t lane, bool is_plane) const {
  const RowPlace& place = rows_.places[row];
  const std::int32_t a = order_[at(place.sphere_a[lane])], b = place.sphere_b[lane];
  const auto spheres = static_cast<std::int32_t>(description_.spheres.size());
  const ContactHistory history = history_of(rows_.rows[row], place, lane);
  if (is_plane) return {a, spheres + b, history};
  const std::int32_t other = order_[at(b)];
  if (a < other) return {a, other, history};
  return {other, a, reversed(history)};
}

/// Sorts by counting, which keeps the order of rows among contacts of one sphere.
void ContactListing::remember() {
  first_known_.assign(description_.spheres.size() + 1, 0);
  const auto each = [&](const auto& visit) {
    for (const RowGroup& group : rows_.groups)
      for (std::size_t row = group.first; row < group.end; ++row)
        for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
          if (!is_used(row, lane)) continue;
          const KnownContact contact = known(row, lane, group.b == SideKind::kPlane);
          if (!is_zero(contact.history)) visit(contact);
        }
  };
  each([&](const KnownContact& contact) { ++first_known_[at(contact.first) + 1]; });
  for (std::size_t s = 1; s < first_known_.size(); ++s) first_known_[s] += first_known_[s - 1];
  known_.resize(at(first_known_.back()));
  each([&](const KnownContact& contact) {
    known_[at(first_known_[at(contact.first)]++)] = contact;
  });
  std::copy_backward(first_known_.begin(), first_known_.end() - 1, first_known_.end());
  first_known_.front() = 0;
}

void ContactListing::recall() {
  for (const RowGroup& group : rows_.groups)
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
        if (!is_used(row, lane)) continue;
        const bool is_plane = group.b == SideKind::kPlane;
        const KnownContact contact = known(row, lane, is_plane);
        const auto first = known_.begin() + first_known_[at(contact.first)];
        const auto end = known_.begin() + first_known_[at(contact.first) + 1];
        const auto found = std::find_if(
            first, end, [&](const KnownContact& k) { return k.second == contact.second; });
        if (found == end) continue;
        const bool is_reversed = order_[at(rows_.places[row].sphere_a[lane])] != contact.first;
        set_history(is_reversed ? reversed(found->history) : found->history, rows_.rows[row],
                    rows_.places[row], lane);
      }
}

void ContactListing::derive_lane(std::size_t index, std::size_t lane, const RowGroup& group) {
  ContactRow& row = rows_.rows[index];
  RowPlace& place = rows_.places[index];
  const bool is_plane = group.b == SideKind::kPlane, is_used = place.sphere_a[lane] >= 0;
  const auto mover = [&](const Description::Sphere& sphere) {
    return sphere.rigid >= 0 ? mover_of_rigid_[at(sphere.rigid)] : sphere.nodes[0];
  };
  row.mover_a[lane] = row.mover_b[lane] = world();
  if (!is_used) {
    // Some sphere is read, and is too far for anything to come of it.
    place.sphere_a[lane] = place.sphere_b[lane] = 0;
    place.apart_m[0][lane] = 1e6F;
    row.normal[0][lane] = place.radii_m[lane] = 1.0F;
    return;
  }
  const std::size_t sa = at(order_[at(place.sphere_a[lane])]);
  const Description::Sphere& a = description_.spheres[sa];
  row.mover_a[lane] = mover(a);
  Vector4 apart;
  double radii = a.radius_m;
  collision::ContactMaterial material = description_.materials[at(a.material)];
  if (is_plane) {
    const Description::Plane& plane = description_.planes[at(place.sphere_b[lane])];
    apart = Vector4((plane.normal.dot(base_[sa].vector()) - plane.offset_m) * plane.normal);
    for (std::size_t k = 0; k < 3; ++k)
      row.normal[k][lane] = static_cast<float>(plane.normal[static_cast<Eigen::Index>(k)]);
    material = collision::pair_material(material, description_.materials[at(plane.material)]);
  } else {
    const std::size_t sb = at(order_[at(place.sphere_b[lane])]);
    const Description::Sphere& b = description_.spheres[sb];
    row.mover_b[lane] = mover(b);
    apart = base_[sa] - base_[sb];
    radii += b.radius_m;
    const collision::ContactMaterial& other = description_.materials[at(b.material)];
    const double tool = std::max(a.tool_slip_speed_m_s, b.tool_slip_speed_m_s);
    if (tool > 0.0) {
      material = collision::tool_material(a.tool_slip_speed_m_s > 0.0 ? other : material, tool);
      row.viscous_s_per_m[lane] = static_cast<float>(1.0 / material.slip_speed_m_s);
    } else {
      material = collision::pair_material(material, other);
    }
  }
  place.apart_m[0][lane] = static_cast<float>(apart.x);
  place.apart_m[1][lane] = static_cast<float>(apart.y);
  place.apart_m[2][lane] = static_cast<float>(apart.z);
  place.radii_m[lane] = static_cast<float>(radii);
  place.stiffness_N_per_m[lane] = static_cast<float>(material.stiffness_N_per_m);
  place.damping_N_s_per_m[lane] = static_cast<float>(material.damping_N_s_per_m);
  row.friction[lane] = static_cast<float>(material.friction);
}

/// Pre: the places of rows hold their spheres, and everything else is theirs to compute.
void ContactListing::derive() {
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
  rows_.soft_sides.assign(soft, SoftSide{});
  rows_.rigid_sides.assign(rigid, RigidSide{});
  const auto set_nodes = [&](SoftSide& side, std::size_t lane, std::int32_t place, bool is_used) {
    for (std::size_t k = 0; k < 4; ++k) side.node[k][lane] = world();
    if (!is_used) return;
    const Description::Sphere& sphere = description_.spheres[at(order_[at(place)])];
    for (std::size_t k = 0; k < at(sphere.node_count); ++k) {
      side.node[k][lane] = sphere.nodes[k];
      side.weight[k][lane] = static_cast<float>(sphere.weights[k]);
    }
  };
  for (const RowGroup& group : rows_.groups)
    for (std::size_t row = group.first; row < group.end; ++row) {
      const RowPlace kept = rows_.places[row];
      rows_.rows[row] = ContactRow{};
      rows_.places[row] = RowPlace{};
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
        rows_.places[row].sphere_a[lane] = kept.sphere_a[lane];
        rows_.places[row].sphere_b[lane] = kept.sphere_b[lane];
        derive_lane(row, lane, group);
        const bool is_used = kept.sphere_a[lane] >= 0;
        const std::size_t k = row - group.first;
        if (group.a == SideKind::kSoft)
          set_nodes(rows_.soft_sides[group.first_side_a + k], lane, kept.sphere_a[lane], is_used);
        if (group.b == SideKind::kSoft)
          set_nodes(rows_.soft_sides[group.first_side_b + k], lane, kept.sphere_b[lane], is_used);
      }
    }
}

void ContactListing::save(Saved& saved) const {
  saved.base = base_;
  saved.order = order_;
  saved.rigid_order = rigid_order_;
  saved.groups = rows_.groups;
  saved.sphere_a.clear();
  saved.sphere_b.clear();
  saved.history.clear();
  for (std::size_t row = 0; row < rows_.rows.size(); ++row)
    for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
      const RowPlace& place = rows_.places[row];
      saved.sphere_a.push_back(is_used(row, lane) ? place.sphere_a[lane] : -1);
      saved.sphere_b.push_back(is_used(row, lane) ? place.sphere_b[lane] : -1);
      saved.history.push_back(history_of(rows_.rows[row], place, lane));
    }
}

void ContactListing::load(const Saved& saved) {
  base_ = saved.base;
  order_ = saved.order;
  rigid_order_ = saved.rigid_order;
  mover_of_rigid_.resize(rigid_order_.size());
  for (std::size_t k = 0; k < rigid_order_.size(); ++k)
    mover_of_rigid_[at(rigid_order_[k])] =
        static_cast<std::int32_t>(description_.nodes.size() + k);
  rows_.groups = saved.groups;
  rows_.rows.resize(saved.sphere_a.size() / kRowLanes);
  rows_.places.resize(rows_.rows.size());
  const auto each = [&](const auto& visit) {
    for (std::size_t i = 0; i < saved.sphere_a.size(); ++i) visit(i / kRowLanes, i % kRowLanes, i);
  };
  each([&](std::size_t row, std::size_t lane, std::size_t i) {
    rows_.places[row].sphere_a[lane] = saved.sphere_a[i];
    rows_.places[row].sphere_b[lane] = saved.sphere_b[i];
  });
  derive();
  each([&](std::size_t row, std::size_t lane, std::size_t i) {
    set_history(saved.history[i], rows_.rows[row], rows_.places[row], lane);
  });
}

}  // namespace stillgrid::dynamics
