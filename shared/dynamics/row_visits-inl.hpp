// Visits rows by the kinds of their sides; included once for every instruction set that Highway
// knows.
#if defined(STILLGRID_ROW_VISITS) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLGRID_ROW_VISITS
#undef STILLGRID_ROW_VISITS
#else
#define STILLGRID_ROW_VISITS
#endif

#include <algorithm>
#include <type_traits>

#include "shared/dynamics/contact_solver.hpp"
#include "shared/dynamics/sides-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

/// Calls visit with the types of both sides of a group, and with whether it is solved in turn.
template <class Visit>
HWY_INLINE void WithSides(const RowGroup& group, const Visit& visit) {
  const auto with_turn = [&]<class A, class B>(A a, B b) HWY_ATTR {
    if constexpr (may_be_in_turn(A::kKind, B::kKind))
      if (group.is_in_turn != 0) return visit(a, b, std::true_type());
    if constexpr (!is_of_balls(A::kKind, B::kKind)) return visit(a, b, std::false_type());
  };
  const auto with_b = [&](auto a) HWY_ATTR {
    switch (group.b) {
      case SideKind::kBall:
        return with_turn(a, BallSide<-1>());
      case SideKind::kRigid:
        return with_turn(a, RigidBodySide<-1>());
      case SideKind::kSoft:
        return with_turn(a, SoftBodySide<-1>());
      case SideKind::kPlane:
        return with_turn(a, PlaneSide());
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

/// Calls visit<A, B, InTurn>(group, row) for all live rows of the groups that takes(group) takes.
/// Several threads visit groups that are beside each other.
template <class Takes, class Visit>
HWY_INLINE void EachLiveRow(RowList& list, const LiveRows& live, bool is_backward,
                            const Takes& takes, const Visit& visit) {
  const std::size_t groups = list.groups.size();
  const auto number = [=](std::size_t k) { return is_backward ? groups - 1 - k : k; };
  const auto each_of_group = [&](std::size_t g) HWY_ATTR {
    const std::size_t first = g == 0 ? 0 : live.group_end[g - 1], end = live.group_end[g];
    WithSides(list.groups[g], [&](auto a, auto b, auto in_turn) HWY_ATTR {
      if (is_backward)
        for (std::size_t i = end; i-- > first;) visit(a, b, in_turn, list.groups[g], live.rows[i]);
      else
        for (std::size_t i = first; i < end; ++i)
          visit(a, b, in_turn, list.groups[g], live.rows[i]);
    });
  };
  for (std::size_t k = 0, end = 0; k < groups; k = end) {
    for (end = k + 1; end < groups; ++end) {
      const std::size_t low = std::min(number(end - 1), number(end));
      if (!is_beside(list.groups[low], list.groups[low + 1])) break;
    }
    if (!takes(list.groups[number(k)])) continue;
    live.sharing->for_each_chunk(end - k, 1, [&](std::size_t first, std::size_t last) HWY_ATTR {
      for (std::size_t i = first; i < last; ++i) each_of_group(number(k + i));
    });
  }
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
