#include "shared/dynamics/contact_solver.hpp"

// SSSE3 is no faster here than a scalar; SVE has vectors of unknown size, which no structure may
// hold.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2)
// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shared/dynamics/contact_solver.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#include <type_traits>

#include "shared/dynamics/sides-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

template <class A, class B>
constexpr bool kInTurn = std::is_same_v<A, BallSide<1>> &&
                         (std::is_same_v<B, BallSide<-1>> || std::is_same_v<B, PlaneSide>);

constexpr float kApart_m = -1e6F;  // depth of a lane that is not solved

/// Calls visit with the types of both sides of a group.
template <class Visit>
HWY_INLINE void WithSides(const RowGroup& group, const Visit& visit) {
  const auto with_b = [&](auto a) HWY_ATTR {
    switch (group.b) {
      case SideKind::kBall:
        return visit(a, BallSide<-1>());
      case SideKind::kRigid:
        return visit(a, RigidBodySide<-1>());
      case SideKind::kSoft:
        return visit(a, SoftBodySide<-1>());
      case SideKind::kPlane:
        return visit(a, PlaneSide());
    }
  };
  // Sides are listed in the order of their kinds, and no plane is side a.
  switch (group.a) {
    case SideKind::kBall:
      return with_b(BallSide<1>());
    case SideKind::kRigid:
      return with_b(RigidBodySide<1>());
    default:
      return with_b(SoftBodySide<1>());
  }
}

/// Calls visit(row, contexts of both sides) for every vector of a row.
template <class Visit>
HWY_INLINE void EachVector(RowList& list, ContactBodies& bodies, const RowGroup& group,
                           std::size_t row, const Visit& visit) {
  const std::size_t k = row - group.first;
  for (std::size_t i = 0; i < kRowLanes; i += kColumnLanes)
    visit(i, SideContext{&bodies, &list, group.first_side_a + k, i},
          SideContext{&bodies, &list, group.first_side_b + k, i});
}

/// Normals and depths at the middle of the substep; false where no lane may touch within it.
HWY_INLINE bool Locate(ContactRow& row, const RowPlace& place, const ContactBodies& bodies,
                       bool is_plane, std::size_t i) {
  Column3 normal;
  const SpherePlace* const places = bodies.places.data();
  const std::int32_t *const a = place.sphere_a + i, *const b = place.sphere_b + i;
  Column3 moved_a, moved_b;
  Column reach_a, reach_b = All(0.0F), distance;
  GetColumns([=](std::size_t k) { return places[a[k]].moved_m; }, moved_a, reach_a);
  Column3 apart = Get(place.apart_m, i) + moved_a;
  if (is_plane) {
    normal = Get(row.normal, i);
    distance = Dot(apart, normal);
  } else {
    GetColumns([=](std::size_t k) { return places[b[k]].moved_m; }, moved_b, reach_b);
    apart = apart - moved_b;
    distance = hn::Sqrt(Dot(apart, apart));
    normal = (All(1.0F) / hn::Max(distance, All(1e-12F))) * apart;
  }
  const Column radii = Get(place.radii_m, i);
  const Column depth = radii - distance;
  const auto may_touch = hn::Or(hn::Gt(depth + reach_a + reach_b, All(0.0F)),
                                hn::Gt(Get(row.push_impulse_N_s, i), All(0.0F)));
  // Else the neighbours in a vector would decide whether a lane is solved.
  Put(hn::IfThenElse(may_touch, depth, All(kApart_m)), row.depth_m, i);
  if (hn::AllFalse(Floats(), may_touch)) return false;
  Put(normal, row.normal, i);
  Put(distance / hn::Max(radii, All(1e-12F)), row.lever, i);
  return true;
}

/// Turns what friction holds with the normal, and keeps its length.
HWY_INLINE Column3 TurnedStretch(RowPlace& place, const Column3& normal, std::size_t i) {
  const Column3 before = Get(place.stretch_m, i);
  const Column3 across = before - Dot(before, normal) * normal;
  const Column was = Dot(before, before), is = hn::Max(Dot(across, across), All(1e-24F));
  const Column3 turned = hn::Min(All(2.0F), hn::Sqrt(was / is)) * across;
  Put(turned, place.stretch_m, i);
  return turned;
}

/// The equations of the substep. u0, u1: normal velocities at its start and end. The mean depth is
/// depth + (u0 - u1) h / 4, where depth is that of the middle; friction likewise.
HWY_INLINE void SetEquations(ContactRow& row, RowPlace& place, const Column3& velocity, float h,
                             std::size_t i) {
  const Column3 normal = Get(row.normal, i);
  const Column depth = Get(row.depth_m, i);
  const Column zero = All(0.0F), one = All(1.0F);
  const Column k = Get(place.stiffness_N_per_m, i), c = Get(place.damping_N_s_per_m, i);
  const Column mass = Get(row.normal_mass_per_kg, i);
  const Column u0 = Dot(velocity, normal);
  const Column start = depth + All(0.5F * h) * u0;
  Put(All(h) * k * (depth + All(0.25F * h) * u0), row.spring_impulse_N_s, i);
  Put(c * (depth - hn::Max(start, zero)), row.damper_impulse_N_s, i);
  const Column spring_part = All(0.25F * h * h) * k, damper_part = All(0.5F * h) * c;
  Put(spring_part, row.spring_slope_kg, i);
  Put(damper_part, row.damper_slope_kg, i);
  Put(one / (one + mass * spring_part), row.inverse_spring, i);
  Put(one / (one + mass * (spring_part + damper_part)), row.inverse_both, i);
  const Column3 stretch = TurnedStretch(place, normal, i), slip = velocity - u0 * normal;
  const auto sticks = hn::Eq(Get(row.viscous_s_per_m, i), zero);
  const Column slope = hn::IfThenElseZero(sticks, spring_part + damper_part);
  Put(slope, row.hold_slope_kg, i);
  Put((hn::IfThenElseZero(sticks, All(h) * k)) * stretch + slope * slip, row.held_impulse_N_s, i);
  const Column3 drag = Get(row.friction_impulse_N_s, i);
  Put(drag - Dot(drag, normal) * normal, row.friction_impulse_N_s, i);
}

/// Counts, for each mover, contacts that are solved at once and may push it.
HWY_INLINE void CountContacts(const RowList& list, ContactBodies& bodies, const RowGroup& group,
                              std::size_t index) {
  const ContactRow& row = list.rows[index];
  const auto count = [&](std::int32_t number) {
    Mover& mover = bodies.movers[static_cast<std::size_t>(number)];
    if (mover.inverse_mass_per_kg == 0.0F) return;
    if (mover.contacts == 0.0F) bodies.changed.push_back(number);
    mover.contacts += 1.0F;
  };
  const auto count_side = [&](SideKind kind, const RowIndices& movers, std::size_t side,
                              std::size_t lane) {
    if (kind != SideKind::kSoft) return count(movers[lane]);
    for (const RowIndices& node : list.soft_sides[side + index - group.first].node)
      count(node[lane]);
  };
  for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
    if (row.depth_m[lane] == kApart_m) continue;
    count_side(group.a, row.mover_a, group.first_side_a, lane);
    if (group.b != SideKind::kPlane) count_side(group.b, row.mover_b, group.first_side_b, lane);
  }
}

HWY_INLINE bool IsSolved(const ContactRow& row, std::size_t i) {
  return !hn::AllTrue(Floats(), hn::Eq(Get(row.depth_m, i), All(kApart_m)));
}

template <class A, class B>
HWY_INLINE void PrepareRow(RowList& list, ContactBodies& bodies, const RowGroup& group,
                           std::size_t index, float h) {
  ContactRow& row = list.rows[index];
  RowPlace& place = list.places[index];
  EachVector(list, bodies, group, index,
             [&](std::size_t i, const SideContext& side_a, const SideContext& side_b) HWY_ATTR {
               if (!IsSolved(row, i)) return;
               A a;
               B b;
               a.Load(row, side_a);
               b.Load(row, side_b);
               Put(All(0.0F), row.normal_mass_per_kg, i);
               Put(All(0.0F), row.across_mass_per_kg, i);
               const Column lever = Get(row.lever, i);
               const Column3 normal = Get(row.normal, i);
               a.Prepare(row, place, side_a, normal, lever, kInTurn<A, B>);
               b.Prepare(row, place, side_b, normal, lever, kInTurn<A, B>);
               SetEquations(row, place, a.AtContact(normal, lever) - b.AtContact(normal, lever), h,
                            i);
             });
}

/// Applies an impulse on both sides: now where contacts are solved in turn, else to the sums of
/// changes, in the order of lanes.
template <class A, class B>
HWY_INLINE void Push(A& a, B& b, const Column3& impulse, const ContactRow& row,
                     const SideContext& side_a, const SideContext& side_b) {
  const Column3 normal = Get(row.normal, side_a.lane);
  const Column lever = Get(row.lever, side_a.lane);
  if constexpr (!kInTurn<A, B>) {
    a.Clear();
    b.Clear();
  }
  a.Push(impulse, normal, lever);
  b.Push(impulse, normal, lever);
  if constexpr (kInTurn<A, B>) {
    a.Store(row, side_a);
    b.Store(row, side_b);
  } else {
    a.ListChanges();
    b.ListChanges();
    for (std::size_t k = 0; k < kColumnLanes; ++k) {
      a.AddLane(row, side_a, k);
      b.AddLane(row, side_b, k);
    }
  }
}

/// Adds the sums of changes to their movers.
HWY_INLINE void ApplyChanges(ContactBodies& bodies) {
  for (const std::int32_t number : bodies.changed) {
    Mover& mover = bodies.movers[static_cast<std::size_t>(number)];
    Mover& change = bodies.changes[static_cast<std::size_t>(number)];
    for (std::size_t k = 0; k < 3; ++k) {
      mover.velocity_m_s[k] += change.velocity_m_s[k];
      mover.spin[k] += change.spin[k];
    }
    change = {};
  }
}

template <class A, class B>
HWY_INLINE void WarmStartRow(RowList& list, ContactBodies& bodies, const RowGroup& group,
                             std::size_t index) {
  ContactRow& row = list.rows[index];
  EachVector(list, bodies, group, index,
             [&](std::size_t i, const SideContext& side_a, const SideContext& side_b) HWY_ATTR {
               const Column push = Get(row.push_impulse_N_s, i);
               if (!IsSolved(row, i) || hn::AllTrue(Floats(), hn::Eq(push, All(0.0F)))) return;
               A a;
               B b;
               a.Load(row, side_a);
               b.Load(row, side_b);
               Push(a, b, push * Get(row.normal, i) + Get(row.friction_impulse_N_s, i), row, side_a,
                    side_b);
             });
}

/// The normal impulse that the equations ask for, from the normal velocity without it. The damper
/// acts where the sides approach at the end that the spring alone leads to.
HWY_INLINE Column SolvePush(const ContactRow& row, Column velocity, std::size_t i) {
  const Column damper_part = Get(row.damper_slope_kg, i);
  const Column spring = Get(row.spring_impulse_N_s, i) - Get(row.spring_slope_kg, i) * velocity;
  const Column damper = Get(row.damper_impulse_N_s, i) - damper_part * velocity;
  const Column alone = spring * Get(row.inverse_spring, i);
  const Column both = (spring + damper) * Get(row.inverse_both, i);
  const Column left = damper - damper_part * Get(row.normal_mass_per_kg, i) * alone;
  const Column push = hn::IfThenElse(hn::Gt(left, All(0.0F)), both, alone);
  return hn::IfThenElseZero(hn::Gt(push, All(0.0F)), push);  // never a negative zero
}

/// The friction impulse that the equations ask for, from the slip without it.
HWY_INLINE Column3 SolveDrag(const ContactRow& row, const Column3& slip, Column push,
                             std::size_t i) {
  const Column most = Get(row.friction, i) * push;
  const Column slope = Get(row.hold_slope_kg, i) + most * Get(row.viscous_s_per_m, i);
  const Column3 asked = (All(1.0F) / (All(1.0F) + Get(row.across_mass_per_kg, i) * slope)) *
                        (Get(row.held_impulse_N_s, i) + slope * slip);
  const Column size = hn::Sqrt(hn::Max(Dot(asked, asked), All(1e-30F)));
  // The sum makes a negative zero a positive one, so that states are equal byte by byte.
  return Column3{All(0.0F), All(0.0F), All(0.0F)} - hn::Min(All(1.0F), most / size) * asked;
}

template <class A, class B>
HWY_INLINE void SolveRow(RowList& list, ContactBodies& bodies, const RowGroup& group,
                         std::size_t index) {
  ContactRow& row = list.rows[index];
  EachVector(
      list, bodies, group, index,
      [&](std::size_t i, const SideContext& side_a, const SideContext& side_b) HWY_ATTR {
        if (!IsSolved(row, i)) return;
        A a;
        B b;
        a.Load(row, side_a);
        b.Load(row, side_b);
        const Column3 normal = Get(row.normal, i);
        const Column lever = Get(row.lever, i);
        const Column3 u = a.AtContact(normal, lever) - b.AtContact(normal, lever);
        const Column un = Dot(u, normal), push_before = Get(row.push_impulse_N_s, i);
        const Column push = SolvePush(row, un - Get(row.normal_mass_per_kg, i) * push_before, i);
        const Column3 drag_before = Get(row.friction_impulse_N_s, i);
        const Column3 slip = (u - un * normal) - Get(row.across_mass_per_kg, i) * drag_before;
        const Column3 drag = SolveDrag(row, slip, push, i);
        Put(push, row.push_impulse_N_s, i);
        Put(drag, row.friction_impulse_N_s, i);
        Push(a, b, (push - push_before) * normal + (drag - drag_before), row, side_a, side_b);
      });
}

/// Calls visit<A, B>(group, row) for all live rows; without in_turn_too for those of contacts that
/// are solved at once.
template <class Visit>
HWY_INLINE void EachLiveRow(RowList& list, const LiveRows& live, bool is_backward, bool in_turn_too,
                            const Visit& visit) {
  const std::size_t groups = list.groups.size();
  for (std::size_t k = 0; k < groups; ++k) {
    const std::size_t g = is_backward ? groups - 1 - k : k;
    if (!in_turn_too && is_solved_in_turn(list.groups[g].a, list.groups[g].b)) continue;
    const std::size_t first = g == 0 ? 0 : live.group_end[g - 1], end = live.group_end[g];
    WithSides(list.groups[g], [&]<class A, class B>(A a, B b) HWY_ATTR {
      if (is_backward)
        for (std::size_t i = end; i-- > first;) visit(a, b, list.groups[g], live.rows[i]);
      else
        for (std::size_t i = first; i < end; ++i) visit(a, b, list.groups[g], live.rows[i]);
    });
  }
}

void PrepareRows(RowList& list, ContactBodies& bodies, float substep_s, LiveRows& live) {
  live.rows.clear();
  live.group_end.clear();
  for (const std::int32_t mover : bodies.changed)
    bodies.movers[static_cast<std::size_t>(mover)].contacts = 0.0F;
  bodies.changed.clear();
  for (const RowGroup& group : list.groups) {
    const bool is_plane = group.b == SideKind::kPlane;
    WithSides(group, [&]<class A, class B>(A, B) HWY_ATTR {
      for (std::size_t row = group.first; row < group.end; ++row) {
        bool is_live = false;
        for (std::size_t i = 0; i < kRowLanes; i += kColumnLanes)
          is_live = Locate(list.rows[row], list.places[row], bodies, is_plane, i) || is_live;
        if (!is_live) continue;
        live.rows.push_back(static_cast<std::uint32_t>(row));
        if constexpr (kInTurn<A, B>)
          PrepareRow<A, B>(list, bodies, group, row, substep_s);
        else
          CountContacts(list, bodies, group, row);
      }
    });
    live.group_end.push_back(live.rows.size());
  }
  // Contacts that are solved at once share the masses of their movers.
  EachLiveRow(list, live, false, false,
              [&]<class A, class B>(A, B, const RowGroup& group, std::size_t row)
                  HWY_ATTR { PrepareRow<A, B>(list, bodies, group, row, substep_s); });
}

void WarmStartRows(RowList& list, ContactBodies& bodies, const LiveRows& live) {
  EachLiveRow(list, live, false, true,
              [&]<class A, class B>(A, B, const RowGroup& group, std::size_t row)
                  HWY_ATTR { WarmStartRow<A, B>(list, bodies, group, row); });
  ApplyChanges(bodies);
}

void SolveRows(RowList& list, ContactBodies& bodies, const LiveRows& live, bool is_backward,
               bool with_balls) {
  EachLiveRow(list, live, is_backward, with_balls,
              [&]<class A, class B>(A, B, const RowGroup& group, std::size_t row)
                  HWY_ATTR { SolveRow<A, B>(list, bodies, group, row); });
  ApplyChanges(bodies);
}

void FinishRows(RowList& list, float h, const LiveRows& live) {
  for (const std::uint32_t index : live.rows) {
    const ContactRow& row = list.rows[index];
    RowPlace& place = list.places[index];
    for (std::size_t i = 0; i < kRowLanes; i += kColumnLanes) {
      const Column k = Get(place.stiffness_N_per_m, i), c = Get(place.damping_N_s_per_m, i);
      const auto holds = hn::And(hn::Gt(Get(row.push_impulse_N_s, i), All(0.0F)),
                                 hn::Eq(Get(row.viscous_s_per_m, i), All(0.0F)));
      // The mean force is k times the mean stretch and c times its mean rate.
      const Column per_force = All(2.0F) / hn::Max(k + All(2.0F / h) * c, All(1e-12F));
      const Column3 stretch = Get(place.stretch_m, i), drag = Get(row.friction_impulse_N_s, i);
      const Column3 end = stretch + per_force * (All(-1.0F / h) * drag - k * stretch);
      Put({hn::IfThenElseZero(holds, end.x), hn::IfThenElseZero(holds, end.y),
           hn::IfThenElseZero(holds, end.z)},
          place.stretch_m, i);
    }
  }
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {

HWY_EXPORT(PrepareRows);
HWY_EXPORT(WarmStartRows);
HWY_EXPORT(SolveRows);
HWY_EXPORT(FinishRows);

void prepare_rows(RowList& list, ContactBodies& bodies, float substep_s, LiveRows& live) {
  HWY_DYNAMIC_DISPATCH(PrepareRows)(list, bodies, substep_s, live);
}
void warm_start_rows(RowList& list, ContactBodies& bodies, const LiveRows& live) {
  HWY_DYNAMIC_DISPATCH(WarmStartRows)(list, bodies, live);
}
void solve_rows(RowList& list, ContactBodies& bodies, const LiveRows& live, bool is_backward,
                bool with_balls) {
  HWY_DYNAMIC_DISPATCH(SolveRows)(list, bodies, live, is_backward, with_balls);
}
void finish_rows(RowList& list, float substep_s, const LiveRows& live) {
  HWY_DYNAMIC_DISPATCH(FinishRows)(list, substep_s, live);
}

}  // namespace stillgrid::dynamics
#endif
