#include "sim_server/dynamics/forces/sheet_forces.hpp"

#include <algorithm>
#include <cstddef>

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/dynamics/forces/sheet_forces.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#include "sim_server/dynamics/forces/sheet_stencil-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

/// Forces of a row whose springs are all done: of one coordinate.
HWY_INLINE Vec Force(const Stencil& s, std::size_t i) {
  return hn::Sub(hn::Sub(LoadU(s.own[0], i), LoadU(s.next[0] + -1, i)), LoadU(s.after + -2, i));
}

/// Transposes a row of nodes.
HWY_INLINE void Unpack(const PackedVector* HWY_RESTRICT from, std::size_t columns, const Row& to,
                       std::size_t stride) {
  const Tag d;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= columns; i += hn::Lanes(d)) {
    Vec x, y, z, zero;
    hn::LoadInterleaved4(d, &from[i].x, x, y, z, zero);
    StoreU(x, to, i);
    StoreU(y, to, i + stride);
    StoreU(z, to, i + 2 * stride);
  }
  for (; i < columns; ++i) {
    *to.at(i) = from[i].x;
    *to.at(i + stride) = from[i].y;
    *to.at(i + 2 * stride) = from[i].z;
  }
}

/// The other way round. from(i): of coordinates at i.
template <class From>
HWY_INLINE void Pack(const From& from, std::size_t columns, std::size_t stride,
                     PackedVector* HWY_RESTRICT to) {
  const Tag d;
  for (std::size_t i = 0; i < columns; i += hn::Lanes(d)) {
    const Vec x = from(i), y = from(i + stride), z = from(i + 2 * stride);
    if (i + hn::Lanes(d) <= columns) {
      hn::StoreInterleaved4(x, y, z, hn::Zero(d), d, &to[i].x);
    } else {
      PackedVector rest[contact::kLanes];
      hn::StoreInterleaved4(x, y, z, hn::Zero(d), d, &rest[0].x);
      std::copy(rest, rest + (columns - i), to + i);
    }
  }
}

template <bool damped>
double PullSheet(SpringSheet& sheet, const SpringNodes& nodes) {
  constexpr std::size_t kHeld = kSpan + 1;
  const SheetRows rows(sheet);
  const auto enter = [&](std::size_t row) HWY_ATTR {
    const std::size_t node = sheet.first_node + row * sheet.columns;
    const std::size_t to = SheetRows::of_nodes(row % kHeld);
    Unpack(nodes.position_m + node, sheet.columns, rows[to], sheet.stride);
    if (!damped) return;
    Unpack(nodes.velocity_m_s + node, sheet.columns, rows[to + 3], sheet.stride);
  };
  const auto done = [&](std::size_t row, const Stencil& s) HWY_ATTR {
    Pack([&](std::size_t i) HWY_ATTR { return Force(s, i); }, sheet.columns, sheet.stride,
         nodes.force_N + sheet.first_node + row * sheet.columns);
  };
  return PullRows<damped>(sheet, kHeld, enter, done);
}

double PullAnySheet(SpringSheet& sheet, const SpringNodes& nodes) {
  return sheet.damped ? PullSheet<true>(sheet, nodes) : PullSheet<false>(sheet, nodes);
}

void TakeNodes(const ExplicitState& state, SpringSheet& sheet) {
  const SheetRows rows(sheet);
  for (std::size_t row = 0; row < sheet.rows; ++row) {
    const std::size_t node = sheet.first_node + row * sheet.columns;
    const std::size_t to = SheetRows::of_nodes(row);
    Unpack(&state.position_m[node], sheet.columns, rows[to], sheet.stride);
    Unpack(&state.velocity_m_s[node], sheet.columns, rows[to + 3], sheet.stride);
    std::copy_n(&state.inverse_mass_per_kg[node], sheet.columns, rows[to + 6].at(0));
  }
}

void GiveNodes(SpringSheet& sheet, ExplicitState& state) {
  const SheetRows rows(sheet);
  for (std::size_t row = 0; row < sheet.rows; ++row) {
    const std::size_t node = sheet.first_node + row * sheet.columns;
    const ConstRow x = rows[SheetRows::of_nodes(row)], v = rows[SheetRows::of_nodes(row) + 3];
    Pack([&](std::size_t i) HWY_ATTR { return LoadU(x, i); }, sheet.columns, sheet.stride,
         &state.position_m[node]);
    Pack([&](std::size_t i) HWY_ATTR { return LoadU(v, i); }, sheet.columns, sheet.stride,
         &state.velocity_m_s[node]);
  }
}

HWY_INLINE void MoveRow(const Stencil& s, const Move& move, const double* gravity_m_s2) {
  const Tag d;
  const Vec kick = hn::Set(d, move.kick_s), drift = hn::Set(d, move.drift_s);
  for (std::size_t i = 0; i < s.columns; i += hn::Lanes(d)) {
    const Vec inverse_mass = LoadU(s.inverse_mass, i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t at = i + axis * s.stride;
      const Vec v = Kicked(d, inverse_mass, Force(s, at), hn::Set(d, gravity_m_s2[axis]), kick,
                           LoadU(s.v[0], at));
      StoreU(v, s.v[0], at);
      StoreU(Drifted(d, inverse_mass, v, drift, LoadU(s.x[0], at)), s.x[0], at);
    }
  }
}

double MoveSheet(SpringSheet& sheet, const Move& move, const double* gravity_m_s2) {
  const auto enter = [](std::size_t /*row*/) HWY_ATTR {};
  const auto done = [&](std::size_t /*row*/, const Stencil& s)
                        HWY_ATTR { MoveRow(s, move, gravity_m_s2); };
  const std::size_t held = sheet.rows + kSpan;
  return sheet.damped ? PullRows<true>(sheet, held, enter, done)
                      : PullRows<false>(sheet, held, enter, done);
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {
namespace {
HWY_EXPORT(PullAnySheet);
HWY_EXPORT(TakeNodes);
HWY_EXPORT(GiveNodes);
HWY_EXPORT(MoveSheet);
}  // namespace

double pull_sheet(SpringSheet& sheet, const SpringNodes& nodes) {
  return HWY_DYNAMIC_DISPATCH(PullAnySheet)(sheet, nodes);
}

void take_nodes(const ExplicitState& state, SpringSheet& sheet) {
  HWY_DYNAMIC_DISPATCH(TakeNodes)(state, sheet);
}

void give_nodes(SpringSheet& sheet, ExplicitState& state) {
  HWY_DYNAMIC_DISPATCH(GiveNodes)(sheet, state);
}

double move_sheet(SpringSheet& sheet, const Move& move, const Eigen::Vector3d& gravity_m_s2) {
  return HWY_DYNAMIC_DISPATCH(MoveSheet)(sheet, move, gravity_m_s2.data());
}

}  // namespace stillgrid::dynamics
#endif
