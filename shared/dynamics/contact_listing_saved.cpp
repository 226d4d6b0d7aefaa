// A listing as part of a saved state.
#include <cmath>
#include <stdexcept>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/contact_history.hpp"
#include "shared/dynamics/contact_listing.hpp"

namespace stillgrid::dynamics {
namespace {

void require(bool is_right) {
  if (!is_right) throw std::invalid_argument("the block is not a listing of this scene");
}

/// Whether the numbers are 0 to size - 1, each once. seen: scratch.
bool is_permutation(const std::vector<std::int32_t>& numbers, std::size_t size,
                    std::vector<std::uint8_t>& seen) {
  seen.assign(size, 0);
  for (const std::int32_t number : numbers) {
    if (number < 0 || at(number) >= size || seen[at(number)] != 0) return false;
    seen[at(number)] = 1;
  }
  return numbers.size() == size;
}

}  // namespace

void ContactListing::check_rows(const Saved& saved) const {
  const std::size_t spheres = description_.spheres.size(), lanes = saved.sphere_a.size();
  require(saved.base.size() == spheres && is_permutation(saved.order, spheres, seen_));
  for (const Vector4& base : saved.base)
    require(std::isfinite(base.x + base.y + base.z) && base.w > 0.0 && std::isfinite(base.w));
  require(lanes % kRowLanes == 0 && saved.sphere_b.size() == lanes &&
          saved.history.size() == lanes);
  require(saved.field_base.size() == description_.fields.size());
  for (const FieldBase& base : saved.field_base) {
    const FieldPose pose = base.pose();
    require(pose.position_m.allFinite() && pose.axes.allFinite() && base.position_m.w > 0.0 &&
            std::isfinite(base.position_m.w));
  }
  std::size_t end = 0;
  for (const RowGroup& group : saved.groups) {
    require(group.first == end && group.end > end && group.end <= lanes / kRowLanes);
    require(group.a < SideKind::kPlane && group.b <= SideKind::kPlane);
    require(is_of_balls(group.a, group.b) ? group.is_in_turn == 1
                                          : group.is_in_turn <= may_be_in_turn(group.a, group.b));
    end = group.end;
    const bool is_plane = group.b == SideKind::kPlane;
    const std::size_t others =
        is_plane ? description_.planes.size() : spheres + description_.fields.size();
    // Else threads might write the same body.
    const auto is_of_part = [&](std::size_t a, std::size_t b) {
      return group.part ==
             (is_of_balls(group.a, group.b) ? part_of(spheres, a, is_plane ? a : b) : 0);
    };
    for (std::size_t i = kRowLanes * group.first; i < kRowLanes * end; ++i) {
      if (saved.sphere_a[i] < 0) continue;
      require(at(saved.sphere_a[i]) < spheres && saved.sphere_b[i] >= 0 &&
              at(saved.sphere_b[i]) < others);
      require(kinds_[at(saved.order[at(saved.sphere_a[i])])] == group.a &&
              is_of_part(at(saved.sphere_a[i]), at(saved.sphere_b[i])));
      const bool is_field = at(saved.sphere_b[i]) >= spheres;
      require(is_plane || (is_field ? SideKind::kRigid
                                    : kinds_[at(saved.order[at(saved.sphere_b[i])])]) == group.b);
    }
  }
  require(end == lanes / kRowLanes);
}

void ContactListing::check(const Saved& saved, bool is_stale) const {
  const std::size_t spheres = description_.spheres.size();
  for (const SleepingContact& contact : saved.sleeping)
    require(contact.first >= 0 && at(contact.first) < spheres && contact.second > contact.first &&
            at(contact.second) < description_.field_number(description_.fields.size()));
  const bool is_empty = saved.base.empty() && saved.order.empty() && saved.groups.empty() &&
                        saved.sphere_a.empty() && saved.field_base.empty();
  for (const ToolFixture& fixture : saved.fixtures) {
    require(fixture.tool >= 0 && at(fixture.tool) < tools_.size() && fixture.other >= 0 &&
            at(fixture.other) < description_.field_number(description_.fields.size()));
    require(description_.side(at(fixture.other)).plane == nullptr);
  }
  if (is_stale && is_empty) return;  // nothing was listed yet
  check_rows(saved);
}

void ContactListing::save(Saved& saved) const {
  saved.sphere_a.clear();
  saved.sphere_b.clear();
  saved.history.clear();
  // With the room too: a block of another state, with more contacts, is loaded into it.
  const auto copy = [](const auto& from, auto& to) {
    to.reserve(from.capacity());
    to = from;
  };
  copy(sleeping_contacts_, saved.sleeping);
  copy(base_, saved.base);
  copy(order_, saved.order);
  copy(rows_.groups, saved.groups);
  copy(field_base_, saved.field_base);
  copy(fixtures_, saved.fixtures);
  for (const RowGroup& group : rows_.groups)
    for (std::size_t i = kRowLanes * group.first; i < kRowLanes * group.end; ++i) {
      const std::size_t row = i / kRowLanes, lane = i % kRowLanes;
      const RowPlace& place = rows_.places[row];
      const std::int32_t b = place.sphere_b[lane];
      const bool is_plane = group.b == SideKind::kPlane;
      saved.sphere_a.push_back(is_used(row, lane) ? place.sphere_a[lane] : -1);
      saved.sphere_b.push_back(!is_used(row, lane) ? -1 : is_plane ? b : listed_other(b));
      saved.history.push_back(history_of(rows_.rows[row], place, lane));
    }
}

void ContactListing::load(const Saved& saved) {
  pairs_.forget();  // they are of another state
  sleeping_contacts_ = saved.sleeping;
  is_sleep_new_ = true;  // bodies may have woken since the saved listing
  base_ = saved.base;
  order_ = saved.order;
  field_base_ = saved.field_base;
  fixtures_ = saved.fixtures;
  order_movers();
  collect_near();
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
  derive(WorkSharing::alone());
  each([&](std::size_t row, std::size_t lane, std::size_t i) {
    set_history(saved.history[i], rows_.rows[row], rows_.places[row], lane);
  });
  list_sleeper_lanes();
}

std::vector<ContactListing::Stretched> ContactListing::stretched() const {
  std::vector<Stretched> all;
  for (const RowGroup& group : rows_.groups)
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
        const RowPlace& place = rows_.places[row];
        const ContactHistory history = history_of(rows_.rows[row], place, lane);
        const Eigen::Vector3d stretch_m(history.stretch_m[0], history.stretch_m[1],
                                        history.stretch_m[2]);
        if (!is_used(row, lane) || stretch_m.isZero(0.0)) continue;
        Stretched one{.sphere_a = order_[at(place.sphere_a[lane])],
                      .stiffness_N_per_m = double{place.stiffness_N_per_m[lane]},
                      .stretch_m = stretch_m};
        const std::int32_t b = place.sphere_b[lane];
        if (group.b == SideKind::kPlane) {
          one.plane = b;
        } else if (is_field(b)) {
          const FieldLane& field = field_lanes_[at(b) - description_.spheres.size()];
          one.field = field.field;
          one.stiffness_N_per_m = double{field.stiffness_N_per_m};
        } else {
          one.sphere_b = order_[at(b)];
        }
        all.push_back(one);
      }
  return all;
}

}  // namespace stillgrid::dynamics
