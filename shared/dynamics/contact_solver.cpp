#include "shared/dynamics/contact_solver.hpp"

// SSSE3 is no faster here than a scalar; SVE has vectors of unknown size, which no structure may
// hold.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2)
// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shared/dynamics/contact_solver.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#include "shared/dynamics/contact_law-inl.hpp"
#include "shared/dynamics/row_visits-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

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

/// The mean depth and the mean rate of a substep change by h / 4 and 1 / 2 of the velocity.
HWY_INLINE void NoteRates(const ContactRow& row, const RowPlace& place, std::size_t i,
                          ContactRates& rates) {
  const auto largest = [](Column values) {
    return static_cast<double>(hn::GetLane(hn::MaxOfLanes(Floats(), values)));
  };
  // Else the neighbours in a vector would decide whether a lane counts.
  const auto is_solved = hn::Ne(Get(row.depth_m, i), All(kApart_m));
  const Column mass = hn::IfThenElseZero(is_solved, Get(row.normal_mass_per_kg, i));
  rates.stiffness_per_s2 = std::max(rates.stiffness_per_s2,
                                    largest(All(0.25F) * mass * Get(place.stiffness_N_per_m, i)));
  rates.damping_per_s =
      std::max(rates.damping_per_s, largest(All(0.5F) * mass * Get(place.damping_N_s_per_m, i)));
}

/// The same of contacts that are solved in turn. Springs of a body act together: a quarter of their
/// number counts, or stacks of stiff boxes gain energy. Dampers lose it, and half of their rate
/// counts.
HWY_INLINE void NoteRatesInTurn(RowList& list, ContactBodies& bodies, LiveRows& live) {
  const auto each_lane = [&](const auto& visit) HWY_ATTR {
    const auto takes = [](const RowGroup& group) {
      return group.is_in_turn != 0 && !is_of_balls(group.a, group.b);
    };
    EachLiveRow(list, live, false, takes,
                [&](auto, auto, auto, const RowGroup&, std::size_t row) HWY_ATTR {
                  const ContactRow& contacts = list.rows[row];
                  for (std::size_t lane = 0; lane < kRowLanes; ++lane)
                    if (contacts.depth_m[lane] != kApart_m)
                      visit(contacts, list.places[row], lane,
                            static_cast<std::size_t>(contacts.mover_a[lane]),
                            static_cast<std::size_t>(contacts.mover_b[lane]));
                });
  };
  std::vector<std::int32_t>& count = bodies.in_turn;
  each_lane(
      [&](auto&, auto&, std::size_t, std::size_t a, std::size_t b) { count[a] = count[b] = 0; });
  each_lane(
      [&](auto&, auto&, std::size_t, std::size_t a, std::size_t b) { ++count[a], ++count[b]; });
  each_lane([&](const ContactRow& row, const RowPlace& place, std::size_t lane, std::size_t a,
                std::size_t b) {
    const double mass = double{row.normal_mass_per_kg[lane]};
    if (!(mass > 0.0)) return;  // two driven bodies
    const double of_a = double{bodies.movers[a].inverse_mass_per_kg},
                 of_b = double{bodies.movers[b].inverse_mass_per_kg};
    const double together = 0.25 * (of_a * count[a] + of_b * count[b]) / (of_a + of_b);
    live.rates.stiffness_per_s2 =
        std::max(live.rates.stiffness_per_s2,
                 0.25 * std::max(1.0, together) * mass * double{place.stiffness_N_per_m[lane]});
    live.rates.damping_per_s =
        std::max(live.rates.damping_per_s, 0.25 * mass * double{place.damping_N_s_per_m[lane]});
  });
}

template <class A, class B, bool InTurn>
HWY_INLINE void PrepareRow(RowList& list, ContactBodies& bodies, const RowGroup& group,
                           std::size_t index, float substep_s) {
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
               a.Prepare(row, place, side_a, normal, lever, InTurn);
               b.Prepare(row, place, side_b, normal, lever, InTurn);
               SetEquations(row, place, a.AtContact(normal, lever) - b.AtContact(normal, lever),
                            a.TurnRate(place, side_a, normal) + b.TurnRate(place, side_b, normal),
                            substep_s, i);
             });
}

/// Applies an impulse on both sides: now where contacts are solved in turn, else to the sums of
/// changes, in the order of lanes.
template <class A, class B, bool InTurn>
HWY_INLINE void Push(A& a, B& b, const Column3& impulse, const ContactRow& row,
                     const SideContext& side_a, const SideContext& side_b) {
  const Column3 normal = Get(row.normal, side_a.lane);
  const Column lever = Get(row.lever, side_a.lane);
  if constexpr (!InTurn) {
    a.Clear();
    b.Clear();
  }
  a.Push(impulse, normal, lever);
  b.Push(impulse, normal, lever);
  if constexpr (InTurn) {
    a.Store(row, side_a);
    b.Store(row, side_b);
  } else {
    const Column zero = All(0.0F);
    const auto pushes =
        hn::Or(hn::Or(hn::Ne(impulse.x, zero), hn::Ne(impulse.y, zero)), hn::Ne(impulse.z, zero));
    if (hn::AllFalse(Floats(), pushes)) return;
    alignas(64) float is_pushing[kColumnLanes];
    hn::Store(hn::IfThenElseZero(pushes, All(1.0F)), Floats(), is_pushing);
    a.ListChanges();
    b.ListChanges();
    for (std::size_t k = 0; k < kColumnLanes; ++k) {
      if (is_pushing[k] == 0.0F) continue;
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

template <class A, class B, bool InTurn>
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
               Push<A, B, InTurn>(a, b,
                                  push * Get(row.normal, i) + Get(row.friction_impulse_N_s, i), row,
                                  side_a, side_b);
             });
}

template <class A, class B, bool InTurn>
HWY_INLINE void SolveRow(RowList& list, ContactBodies& bodies, const RowGroup& group,
                         std::size_t index, float substep_s) {
  ContactRow& row = list.rows[index];
  const Column half_step = All(0.5F * substep_s);
  EachVector(list, bodies, group, index,
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
               const Column push =
                   SolvePush(row, un - Get(row.normal_mass_per_kg, i) * push_before, half_step, i);
               const Column3 drag_before = Get(row.friction_impulse_N_s, i);
               const Column3 slip =
                   (u - un * normal) - Get(row.across_mass_per_kg, i) * drag_before;
               const Column3 drag = SolveDrag(row, slip, push, i);
               Put(push, row.push_impulse_N_s, i);
               Put(drag, row.friction_impulse_N_s, i);
               Push<A, B, InTurn>(a, b, (push - push_before) * normal + (drag - drag_before), row,
                                  side_a, side_b);
             });
}

void PrepareRows(RowList& list, ContactBodies& bodies, float substep_s, LiveRows& live) {
  live.substep_s = substep_s;
  live.rates = {};
  live.rows.clear();
  live.group_end.clear();
  live.is_live.resize(list.rows.size());
  for (const std::int32_t mover : bodies.changed)
    bodies.movers[static_cast<std::size_t>(mover)].contacts = 0.0F;
  bodies.changed.clear();
  each_row(list, *live.sharing, [&](const RowGroup& group, std::size_t row) HWY_ATTR {
    bool is_live = false;
    for (std::size_t i = 0; i < kRowLanes; i += kColumnLanes)
      is_live = Locate(list.rows[row], list.places[row], bodies, group.b == SideKind::kPlane, i) ||
                is_live;
    live.is_live[row] = is_live ? 1 : 0;
    if (is_live && group.is_in_turn != 0)
      WithSides(group,
                [&]<class A, class B, bool InTurn>(A, B, std::bool_constant<InTurn>) HWY_ATTR {
                  if constexpr (InTurn)
                    PrepareRow<A, B, InTurn>(list, bodies, group, row, substep_s);
                });
  });
  for (const RowGroup& group : list.groups) {
    for (std::size_t row = group.first; row < group.end; ++row) {
      if (live.is_live[row] == 0) continue;
      live.rows.push_back(static_cast<std::uint32_t>(row));
      if (group.is_in_turn == 0) CountContacts(list, bodies, group, row);
    }
    live.group_end.push_back(live.rows.size());
  }
  // Contacts that are solved at once share the masses of their movers.
  const auto is_at_once = [](const RowGroup& group) { return group.is_in_turn == 0; };
  EachLiveRow(list, live, false, is_at_once,
              [&]<class A, class B, bool InTurn>(A, B, std::bool_constant<InTurn>,
                                                 const RowGroup& group, std::size_t row)
                  HWY_ATTR { PrepareRow<A, B, InTurn>(list, bodies, group, row, substep_s); });
  EachLiveRow(list, live, false, is_at_once,
              [&](auto, auto, auto, const RowGroup&, std::size_t row) HWY_ATTR {
                for (std::size_t i = 0; i < kRowLanes; i += kColumnLanes)
                  NoteRates(list.rows[row], list.places[row], i, live.rates);
              });
  NoteRatesInTurn(list, bodies, live);
}

void WarmStartRows(RowList& list, ContactBodies& bodies, const LiveRows& live) {
  const auto any = [](const RowGroup&) { return true; };
  EachLiveRow(list, live, false, any,
              [&]<class A, class B, bool InTurn>(A, B, std::bool_constant<InTurn>,
                                                 const RowGroup& group, std::size_t row)
                  HWY_ATTR { WarmStartRow<A, B, InTurn>(list, bodies, group, row); });
  ApplyChanges(bodies);
}

void SolveRows(RowList& list, ContactBodies& bodies, const LiveRows& live, int iteration) {
  const auto takes = [=](const RowGroup& group) { return iteration < group.iterations(); };
  EachLiveRow(list, live, iteration % 2 == 1, takes,
              [&]<class A, class B, bool InTurn>(A, B, std::bool_constant<InTurn>,
                                                 const RowGroup& group, std::size_t row)
                  HWY_ATTR { SolveRow<A, B, InTurn>(list, bodies, group, row, live.substep_s); });
  ApplyChanges(bodies);
}

HWY_INLINE void FinishRow(const ContactRow& row, RowPlace& place, float h) {
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

void FinishRows(RowList& list, float h, const LiveRows& live) {
  each_row(list, *live.sharing, [&](const RowGroup&, std::size_t row) HWY_ATTR {
    if (live.is_live[row] != 0) FinishRow(list.rows[row], list.places[row], h);
  });
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
void solve_rows(RowList& list, ContactBodies& bodies, const LiveRows& live, int iteration) {
  HWY_DYNAMIC_DISPATCH(SolveRows)(list, bodies, live, iteration);
}
void finish_rows(RowList& list, float substep_s, const LiveRows& live) {
  HWY_DYNAMIC_DISPATCH(FinishRows)(list, substep_s, live);
}

}  // namespace stillgrid::dynamics
#endif
