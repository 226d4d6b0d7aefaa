// The stencil of a sheet's springs; included once for every instruction set that Highway knows.
#if defined(STILLGRID_SHEET_STENCIL) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLGRID_SHEET_STENCIL
#undef STILLGRID_SHEET_STENCIL
#else
#define STILLGRID_SHEET_STENCIL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "sim_server/dynamics/forces/spring_layout.hpp"
#include "sim_server/dynamics/forces/spring_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

using Row = contact::VectorRow<double>;
using ConstRow = contact::VectorRow<const double>;

/// The ends of each kind, for the column at which it begins: row and columns to the right.
struct Ends {
  std::size_t a_row, a_column, b_row, b_column;
};
constexpr std::array<Ends, kSpringKinds> kEnds = {
    {{0, 0, 0, 1}, {0, 0, 1, 0}, {0, 0, 1, 1}, {0, 1, 1, 0}, {0, 0, 0, 2}, {0, 0, 2, 0}}};
constexpr std::size_t kSpan = 2;  // columns, at most

/// Constants of the springs of one kind that begin in one row.
struct Constants {
  double stiffness_N_per_m, push_N, damping_N_s_per_m;
};
using RowConstants = std::array<Constants, kSpringKinds>;

HWY_INLINE Vec LoadU(const ConstRow& row, std::size_t i) {
  return hn::LoadU(Tag(), row.at(i));
}
HWY_INLINE void StoreU(Vec v, const Row& row, std::size_t i) {
  hn::StoreU(v, Tag(), row.at(i));
}

/// Rows of x, y and z of the nodes of one row and of the two after it.
struct Stencil {
  Row x[3], v[3], inverse_mass;
  Row own[3];   // forces
  Row next[2];  // against forces of the next column
  Row after;    // of the one after, of the first row
  std::size_t stride = 0, columns = 0;
};

HWY_INLINE Stencil StencilAt(const SpringSheet& sheet, const SheetRows& rows, std::size_t row,
                             std::size_t held) {
  Stencil s;
  for (std::size_t ahead = 0; ahead < 3; ++ahead) {
    const std::size_t node_rows = SheetRows::of_nodes((row + ahead) % held);
    s.x[ahead] = rows[node_rows];
    s.v[ahead] = rows[node_rows + 3];
    if (ahead == 0) s.inverse_mass = rows[node_rows + 6];
    s.own[ahead] = rows[SheetRows::kForces + 3 * ((row + ahead) % 4)];
    if (ahead < 2) s.next[ahead] = rows[SheetRows::kNext + 3 * ((row + ahead) % 3)];
  }
  s.after = rows[SheetRows::kAfterNext + 3 * (row % 2)];
  s.stride = sheet.stride;
  s.columns = sheet.columns;
  return s;
}

/// b - a of the ends of springs that begin at columns i and after.
HWY_INLINE void Line(const Row* rows, const Ends& ends, std::size_t i, std::size_t stride, Vec& x,
                     Vec& y, Vec& z) {
  const ConstRow a = rows[ends.a_row] + static_cast<std::ptrdiff_t>(ends.a_column);
  const ConstRow b = rows[ends.b_row] + static_cast<std::ptrdiff_t>(ends.b_column);
  x = hn::Sub(LoadU(b, i), LoadU(a, i));
  y = hn::Sub(LoadU(b, i + stride), LoadU(a, i + stride));
  z = hn::Sub(LoadU(b, i + 2 * stride), LoadU(a, i + 2 * stride));
}

/// What the springs of one kind that begin at columns i and after pull at where they begin. Beyond
/// the last of them it is zero; whole: none is.
template <std::size_t kind, bool damped, bool whole>
HWY_INLINE void PullKind(const Stencil& s, const RowConstants& constants, std::size_t i, Vec& x,
                         Vec& y, Vec& z, Vec& power) {
  const Tag d;
  constexpr Ends kOwn = kEnds[kind];
  constexpr std::size_t kColumns = std::max(kOwn.a_column, kOwn.b_column);
  const auto there = hn::FirstN(d, s.columns > i + kColumns ? s.columns - i - kColumns : 0);
  const Vec k = hn::Set(d, constants[kind].stiffness_N_per_m);
  const Vec push = hn::Set(d, constants[kind].push_N);
  Vec c = hn::Set(d, constants[kind].damping_N_s_per_m);
  Line(s.x, kOwn, i, s.stride, x, y, z);
  const Vec square = Dot(x, y, z, x, y, z, hn::Set(d, kShortest_m2));
  Vec along = hn::Zero(d);
  if (damped) {
    Vec v_x, v_y, v_z;
    Line(s.v, kOwn, i, s.stride, v_x, v_y, v_z);
    along = Dot(x, y, z, v_x, v_y, v_z, along);
    if (!whole) c = hn::IfThenElseZero(there, c);
  }
  Vec pull = Pull<damped>(d, square, along, k, push, c, power);
  if (!whole) pull = hn::IfThenElseZero(there, pull);
  x = hn::Mul(pull, x);
  y = hn::Mul(pull, y);
  z = hn::Mul(pull, z);
}

/// Adds what the springs that begin at one node pull at it and at the others: of one coordinate.
/// All stores are where the same look loads, so that none waits for another: what belongs to the
/// next columns is kept apart until the row after is done.
HWY_INLINE void AddForces(const Stencil& s, std::size_t i, Vec right, Vec down, Vec diagonal,
                          Vec other, Vec right2, Vec down2) {
  StoreU(hn::Add(LoadU(s.next[0], i), hn::Sub(right, other)), s.next[0], i);
  StoreU(hn::Sub(LoadU(s.own[1], i), hn::Add(down, other)), s.own[1], i);
  StoreU(diagonal, s.next[1], i);
  StoreU(right2, s.after, i);
  StoreU(hn::Neg(down2), s.own[2], i);
  StoreU(hn::Add(hn::Add(LoadU(s.own[0], i), hn::Add(right, down)),
                 hn::Add(diagonal, hn::Add(right2, down2))),
         s.own[0], i);
}

/// The springs that begin at columns i and after, in one look: each line is measured once.
template <bool damped, bool whole>
HWY_INLINE void PullLook(const Stencil& s, const RowConstants& constants, std::size_t i,
                         Vec& power) {
  Vec right_x, right_y, right_z, down_x, down_y, down_z, diagonal_x, diagonal_y, diagonal_z;
  Vec other_x, other_y, other_z, right2_x, right2_y, right2_z, down2_x, down2_y, down2_z;
  PullKind<0, damped, whole>(s, constants, i, right_x, right_y, right_z, power);
  PullKind<1, damped, whole>(s, constants, i, down_x, down_y, down_z, power);
  PullKind<2, damped, whole>(s, constants, i, diagonal_x, diagonal_y, diagonal_z, power);
  PullKind<3, damped, whole>(s, constants, i, other_x, other_y, other_z, power);
  PullKind<4, damped, whole>(s, constants, i, right2_x, right2_y, right2_z, power);
  PullKind<5, damped, whole>(s, constants, i, down2_x, down2_y, down2_z, power);
  AddForces(s, i, right_x, down_x, diagonal_x, other_x, right2_x, down2_x);
  AddForces(s, i + s.stride, right_y, down_y, diagonal_y, other_y, right2_y, down2_y);
  AddForces(s, i + 2 * s.stride, right_z, down_z, diagonal_z, other_z, right2_z, down2_z);
}

/// Calls enter(row) for each row of nodes before it is looked at, and done(row, its rows) when its
/// forces are complete and the row after has been looked at as well: what was stored last is then
/// no longer under way. held: rows of nodes that are kept at once.
template <bool damped, class Enter, class Done>
HWY_INLINE double PullRows(SpringSheet& sheet, std::size_t held, const Enter& enter,
                           const Done& done) {
  const SheetRows rows(sheet);
  for (std::size_t row = 0; row < 9; ++row) {  // of the others what is there is not looked at
    double* const first =
        rows[row < 6 ? SheetRows::kForces + row : SheetRows::kNext + row - 6].at(0);
    std::fill_n(first, sheet.stride - contact::kLanes, 0.0);
  }
  for (std::size_t row = 0; row < std::min(kSpan, sheet.rows); ++row) enter(row);
  Vec power = hn::Zero(Tag());
  Stencil before;
  for (std::size_t row = 0; row < sheet.rows; ++row) {
    if (row + kSpan < sheet.rows) enter(row + kSpan);
    const Stencil s = StencilAt(sheet, rows, row, held);
    RowConstants constants{};
    for (std::size_t kind = 0; kind < kSpringKinds; ++kind) {
      if (row + kEnds[kind].b_row >= sheet.rows) continue;
      const SpringKind& springs = sheet.kinds[kind];
      constants[kind] = {springs.stiffness_N_per_m,
                         springs.stiffness_N_per_m * springs.rest_length_m,
                         springs.damping_N_s_per_m};
    }
    std::size_t i = 0;
    for (; i + hn::Lanes(Tag()) + kSpan <= sheet.columns; i += hn::Lanes(Tag()))
      PullLook<damped, true>(s, constants, i, power);
    for (; i < sheet.columns; i += hn::Lanes(Tag()))
      PullLook<damped, false>(s, constants, i, power);
    if (row > 0) done(row - 1, before);
    before = s;
  }
  done(sheet.rows - 1, before);
  return hn::GetLane(hn::SumOfLanes(Tag(), power));
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
