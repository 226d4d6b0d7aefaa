#include "sim_server/dynamics/forces/spring_forces.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/dynamics/forces/spring_forces.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#ifndef STILLGRID_SPRING_FORCES_ONCE
#define STILLGRID_SPRING_FORCES_ONCE
namespace stillgrid::dynamics {
namespace {

/// Added to squares of lengths, so that none is zero, m2.
constexpr double kShortest_m2 = 1e-30;

/// The ends of each kind, for the column at which it begins: row and columns to the right.
struct Ends {
  std::size_t a_row, a_column, b_row, b_column;
};
constexpr std::array<Ends, kSpringKinds> kEnds = {
    {{0, 0, 0, 1}, {0, 0, 1, 0}, {0, 0, 1, 1}, {0, 1, 1, 0}, {0, 0, 0, 2}, {0, 0, 2, 0}}};

}  // namespace
}  // namespace stillgrid::dynamics
#endif

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A vector may have no size that the compiler knows (SVE): none is kept in a structure.
using Tag = hn::CappedTag<double, contact::kLanes>;
using Vec = hn::Vec<Tag>;
using FloatTag = hn::Rebind<float, Tag>;
using FourTag = hn::CappedTag<double, 4>;
using Row = contact::VectorRow<double>;
using ConstRow = contact::VectorRow<const double>;

HWY_INLINE Vec Load(const ConstRow& row, std::size_t i) {
  return hn::Load(Tag(), row.aligned(i));
}
HWY_INLINE Vec LoadU(const ConstRow& row, std::size_t i) {
  return hn::LoadU(Tag(), row.at(i));
}
HWY_INLINE void Store(Vec v, const Row& row, std::size_t i) {
  hn::Store(v, Tag(), row.aligned(i));
}
HWY_INLINE void StoreU(Vec v, const Row& row, std::size_t i) {
  hn::StoreU(v, Tag(), row.at(i));
}
/// b - a.
HWY_INLINE Vec Apart(const ConstRow& a, const ConstRow& b, std::size_t i) {
  return hn::Sub(LoadU(b, i), LoadU(a, i));
}
/// a . b + more.
template <class V>
HWY_INLINE V Dot(V ax, V ay, V az, V bx, V by, V bz, V more) {
  return hn::MulAdd(az, bz, hn::MulAdd(ay, by, hn::MulAdd(ax, bx, more)));
}

/// An estimate of 1 / sqrt(square), good to 11 bits.
template <class D>
HWY_INLINE hn::Vec<hn::Rebind<float, D>> Near(D, hn::Vec<D> square) {
  const hn::Rebind<float, D> d;
  const auto rough = hn::DemoteTo(d, square), r = hn::ApproximateReciprocalSqrt(rough);
#if HWY_TARGET == HWY_SSSE3 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_AVX2 || \
    HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return r;
#else  // it is good to 8 bits only: a step of Newton's
  const auto half = hn::Mul(hn::Set(d, 0.5F), rough);
  const auto better = hn::Mul(r, hn::NegMulAdd(hn::Mul(half, r), r, hn::Set(d, 1.5F)));
  // Zero where a float ends, as the others estimate: of infinity it would be no number.
  return hn::IfThenElseZero(hn::Lt(rough, hn::Set(d, std::numeric_limits<float>::max())), better);
#endif
}

/// Springs' tension over length, k - push / length, and their dampers' power. With r near 1 /
/// length and e = 1 - length^2 r^2, 1 / length = r (1 + e/2 + 3 e^2/8 + 5 e^3/16) to 2^-43. along:
/// line . speed of the ends.
template <bool damped, class D, class V = hn::Vec<D>>
HWY_INLINE V Pull(D d, V square, hn::Vec<hn::Rebind<float, D>> near, V along, V stiffness, V push,
                  V damping, V& power) {
  const V r = hn::PromoteTo(d, near);
  const V e = hn::NegMulAdd(hn::Mul(square, r), r, hn::Set(d, 1.0));
  const V series =
      hn::MulAdd(hn::MulAdd(e, hn::Set(d, 0.3125), hn::Set(d, 0.375)), e, hn::Set(d, 0.5));
  const V pushed = hn::Mul(push, r);
  const V pull = hn::NegMulAdd(pushed, hn::Mul(series, e), hn::Sub(stiffness, pushed));
  if constexpr (!damped) return pull;
  const V exact = hn::MulAdd(hn::Mul(series, e), r, r);
  const V rate = hn::Mul(along, exact), force = hn::Mul(damping, rate);
  power = hn::MulAdd(force, rate, power);
  return hn::MulAdd(force, exact, pull);
}

/// Rows of x, y and z of the nodes of one row and of the two after it.
struct Stencil {
  Row x[3], v[3];
  Row own[3];   // forces
  Row next[2];  // against forces of the next column
  Row after;    // of the one after, of the first row
  Row pull;     // a row a kind
  Row squares, alongs;
  contact::VectorRow<float> nears;
  std::size_t stride = 0;
};

/// Tension over length of the springs of one kind that begin in one row, in two loops: one alone is
/// such a long chain that the processor would mostly wait. Beyond its last spring they are zero.
template <bool damped>
HWY_INLINE Vec PullKind(const Stencil& s, const Ends& ends, const Row& to,
                        const SpringKind& springs, std::size_t columns, Vec power) {
  const Tag d;
  const std::size_t y = s.stride, z = 2 * s.stride;
  const auto from = static_cast<std::ptrdiff_t>(ends.a_column);
  const auto end = static_cast<std::ptrdiff_t>(ends.b_column);
  const ConstRow a = s.x[ends.a_row] + from, b = s.x[ends.b_row] + end;
  const ConstRow a_v = s.v[ends.a_row] + from, b_v = s.v[ends.b_row] + end;
  for (std::size_t i = 0; i < columns; i += hn::Lanes(d)) {
    const Vec dx = Apart(a, b, i), dy = Apart(a, b, i + y), dz = Apart(a, b, i + z);
    const Vec square = Dot(dx, dy, dz, dx, dy, dz, hn::Set(d, kShortest_m2));
    Store(square, s.squares, i);
    hn::Store(Near(d, square), FloatTag(), s.nears.aligned(i));
    if (damped)
      Store(Dot(dx, dy, dz, Apart(a_v, b_v, i), Apart(a_v, b_v, i + y), Apart(a_v, b_v, i + z),
                hn::Zero(d)),
            s.alongs, i);
  }
  const Vec k = hn::Set(d, springs.stiffness_N_per_m), c = hn::Set(d, springs.damping_N_s_per_m);
  const Vec push = hn::Set(d, springs.stiffness_N_per_m * springs.rest_length_m);
  const std::size_t reach = std::max(ends.a_column, ends.b_column);
  const std::size_t count = columns > reach ? columns - reach : 0;
  const auto pull = [&](std::size_t i, Vec k_i, Vec push_i, Vec c_i) HWY_ATTR {
    const Vec square = Load(s.squares, i);
    const Vec along = damped ? Load(s.alongs, i) : square;
    const auto near = hn::Load(FloatTag(), s.nears.aligned(i));
    Store(Pull<damped>(d, square, near, along, k_i, push_i, c_i, power), to, i);
  };
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) pull(i, k, push, c);
  for (; i < columns; i += hn::Lanes(d)) {
    const auto there = hn::FirstN(d, count > i ? count - i : 0);
    pull(i, hn::IfThenElseZero(there, k), hn::IfThenElseZero(there, push),
         hn::IfThenElseZero(there, c));
  }
  return power;
}

/// What the springs that begin at one node pull at it and at the others, times their lines: of one
/// coordinate. All stores are where the same look loads, so that none waits for another: what
/// belongs to the next columns is kept apart until the row is done.
HWY_INLINE void AddForces(const Stencil& s, std::size_t i, Vec right_pull, Vec down_pull,
                          Vec diagonal_pull, Vec other_pull, Vec right2_pull, Vec down2_pull) {
  const Vec x00 = LoadU(s.x[0], i), x01 = LoadU(s.x[0] + 1, i), x10 = LoadU(s.x[1], i);
  const Vec right = hn::Mul(right_pull, hn::Sub(x01, x00));
  const Vec other = hn::Mul(other_pull, hn::Sub(x10, x01));
  StoreU(hn::Add(LoadU(s.next[0], i), hn::Sub(right, other)), s.next[0], i);
  const Vec down = hn::Mul(down_pull, hn::Sub(x10, x00));
  StoreU(hn::Sub(LoadU(s.own[1], i), hn::Add(down, other)), s.own[1], i);
  const Vec diagonal = hn::Mul(diagonal_pull, hn::Sub(LoadU(s.x[1] + 1, i), x00));
  StoreU(diagonal, s.next[1], i);
  const Vec right2 = hn::Mul(right2_pull, hn::Sub(LoadU(s.x[0] + 2, i), x00));
  StoreU(right2, s.after, i);
  const Vec up2 = hn::Mul(down2_pull, hn::Sub(x00, LoadU(s.x[2], i)));
  StoreU(up2, s.own[2], i);
  StoreU(hn::Add(hn::Add(LoadU(s.own[0], i), hn::Add(right, down)),
                 hn::Add(diagonal, hn::Sub(right2, up2))),
         s.own[0], i);
}

HWY_INLINE void AddForcesOfRow(const Stencil& s, std::size_t columns) {
  const std::size_t stride = s.stride;
  for (std::size_t i = 0; i < columns; i += hn::Lanes(Tag())) {
    const Vec right = Load(s.pull, i), down = Load(s.pull, i + stride);
    const Vec diagonal = Load(s.pull, i + 2 * stride), other = Load(s.pull, i + 3 * stride);
    const Vec right2 = Load(s.pull, i + 4 * stride), down2 = Load(s.pull, i + 5 * stride);
    for (std::size_t axis = 0; axis < 3; ++axis)
      AddForces(s, i + axis * stride, right, down, diagonal, other, right2, down2);
  }
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

/// Forces of a row whose springs are all done: of one coordinate.
HWY_INLINE Vec Force(const Stencil& s, std::size_t i) {
  return hn::Sub(hn::Sub(LoadU(s.own[0], i), LoadU(s.next[0] + -1, i)), LoadU(s.after + -2, i));
}

HWY_INLINE void PackForces(const Stencil& s, std::size_t columns, PackedVector* HWY_RESTRICT to) {
  const Tag d;
  for (std::size_t i = 0; i < columns; i += hn::Lanes(d)) {
    const Vec x = Force(s, i), y = Force(s, i + s.stride), z = Force(s, i + 2 * s.stride);
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
double PullSheet(SpringSheet& sheet, ExplicitState& state) {
  const SheetRows rows(sheet);
  const auto enter = [&](std::size_t row) HWY_ATTR {
    const std::size_t node = sheet.first_node + row * sheet.columns;
    Unpack(&state.position_m[node], sheet.columns, rows[SheetRows::kPositions + 3 * (row % 3)],
           sheet.stride);
    if (damped)
      Unpack(&state.velocity_m_s[node], sheet.columns, rows[SheetRows::kVelocities + 3 * (row % 3)],
             sheet.stride);
  };
  for (std::size_t row = 0; row < std::min<std::size_t>(2, sheet.rows); ++row) enter(row);
  std::fill(rows[SheetRows::kForces].at(0), rows[SheetRows::kPulls].at(0) - contact::kLanes, 0.0);
  Vec power = hn::Zero(Tag());
  for (std::size_t row = 0; row < sheet.rows; ++row) {
    if (row + 2 < sheet.rows) enter(row + 2);
    Stencil s;
    for (std::size_t ahead = 0; ahead < 3; ++ahead) {
      const std::size_t place = 3 * ((row + ahead) % 3);
      s.x[ahead] = rows[SheetRows::kPositions + place];
      s.v[ahead] = rows[SheetRows::kVelocities + place];
      s.own[ahead] = rows[SheetRows::kForces + place];
      if (ahead < 2) s.next[ahead] = rows[SheetRows::kNext + 3 * ((row + ahead) % 2)];
    }
    s.after = rows[SheetRows::kAfterNext];
    s.pull = rows[SheetRows::kPulls];
    s.squares = rows[SheetRows::kScratch];
    s.nears = rows.floats(SheetRows::kScratch + 1);
    s.alongs = rows[SheetRows::kScratch + 2];
    s.stride = sheet.stride;
    const SpringKind none;
    for (std::size_t kind = 0; kind < kSpringKinds; ++kind) {
      const bool fits = row + kEnds[kind].b_row < sheet.rows;
      power =
          PullKind<damped>(s, kEnds[kind], s.pull + static_cast<std::ptrdiff_t>(kind * s.stride),
                           fits ? sheet.kinds[kind] : none, sheet.columns, power);
    }
    AddForcesOfRow(s, sheet.columns);
    PackForces(s, sheet.columns, &state.force_N[sheet.first_node + row * sheet.columns]);
  }
  return hn::GetLane(hn::SumOfLanes(Tag(), power));
}

double PullAnySheet(SpringSheet& sheet, ExplicitState& state) {
  return sheet.damped ? PullSheet<true>(sheet, state) : PullSheet<false>(sheet, state);
}

/// The numbers of a node's vector from number k on, where a part of it is loaded.
template <class Packed>
HWY_INLINE auto* Part(Packed& vector, std::size_t k) {
  assert(reinterpret_cast<std::uintptr_t>(&vector) % (4 * sizeof(double)) == 0);
  return &vector.x + k;
}

HWY_INLINE void Difference(const PackedVector& to, const PackedVector& from,
                           PackedVector& difference) {
  const FourTag d;
  for (std::size_t k = 0; k < 4; k += hn::Lanes(d))
    hn::Store(hn::Sub(hn::Load(d, Part(to, k)), hn::Load(d, Part(from, k))), d,
              Part(difference, k));
}

/// Adds what one spring pulls: force = pull * line.
HWY_INLINE void AddForce(double pull, const PackedVector& line, PackedVector& a, PackedVector& b) {
  const FourTag d;
  for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) {
    const auto force = hn::Mul(hn::Set(d, pull), hn::Load(d, Part(line, k)));
    hn::Store(hn::Add(hn::Load(d, Part(a, k)), force), d, Part(a, k));
    hn::Store(hn::Sub(hn::Load(d, Part(b, k)), force), d, Part(b, k));
  }
}

template <bool damped>
double PullGroup(const SpringGroup& group, ExplicitState& state) {
  const FourTag d;  // as wide as what stores before it, or a load would wait until they are done
  using Four = hn::Vec<FourTag>;
  const ConstRow stiffness(group.stiffness_N_per_m.data(), group.stiffness_N_per_m);
  const ConstRow push(group.push_N.data(), group.push_N);
  const ConstRow dampings(group.damping_N_s_per_m.data(), group.damping_N_s_per_m);
  PackedVector lines[contact::kLanes], speeds[contact::kLanes];
  Look pulls;
  Four power = hn::Zero(d);
  for (std::size_t i = 0; i < group.a.size(); i += contact::kLanes) {
    for (std::size_t k = 0; k < contact::kLanes; ++k) {
      const std::size_t a = group.a[i + k], b = group.b[i + k];
      Difference(state.position_m[b], state.position_m[a], lines[k]);
      if (damped) Difference(state.velocity_m_s[b], state.velocity_m_s[a], speeds[k]);
    }
    for (std::size_t k = 0; k < contact::kLanes; k += hn::Lanes(d)) {
      Four x, y, z, zero;
      hn::LoadInterleaved4(d, &lines[k].x, x, y, z, zero);
      const Four square = Dot(x, y, z, x, y, z, hn::Set(d, kShortest_m2));
      Four along = zero, damping = zero;
      if (damped) {
        Four v_x, v_y, v_z;
        hn::LoadInterleaved4(d, &speeds[k].x, v_x, v_y, v_z, zero);
        along = Dot(x, y, z, v_x, v_y, v_z, zero);
        damping = hn::LoadU(d, dampings.at(i + k));
      }
      hn::Store(Pull<damped>(d, square, Near(d, square), along, hn::LoadU(d, stiffness.at(i + k)),
                             hn::LoadU(d, push.at(i + k)), damping, power),
                d, pulls.lanes + k);
    }
    for (std::size_t k = 0; k < contact::kLanes; ++k)
      AddForce(pulls.lanes[k], lines[k], state.force_N[group.a[i + k]],
               state.force_N[group.b[i + k]]);
  }
  return hn::GetLane(hn::SumOfLanes(d, power));
}

double PullAnyGroup(const SpringGroup& group, ExplicitState& state) {
  return group.damped ? PullGroup<true>(group, state) : PullGroup<false>(group, state);
}

void MoveAll(const Move& move, const PackedVector& gravity_m_s2, ExplicitState& state) {
  const FourTag d;
  const auto kick = hn::Set(d, move.kick_s), drift = hn::Set(d, move.drift_s);
  for (std::size_t i = 0; i < state.position_m.size(); ++i) {
    const auto inverse_mass = hn::Set(d, state.inverse_mass_per_kg[i]);
    const auto feels = hn::Gt(inverse_mass, hn::Zero(d));
    PackedVector &position = state.position_m[i], &velocity = state.velocity_m_s[i];
    for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) {
      const auto a = hn::MulAdd(inverse_mass, hn::Load(d, Part(state.force_N[i], k)),
                                hn::Load(d, Part(gravity_m_s2, k)));
      const auto x = hn::Load(d, Part(position, k)), v = hn::Load(d, Part(velocity, k));
      const auto faster = hn::MulAdd(kick, hn::IfThenElseZero(feels, a), v);
      const auto farther = hn::MulAdd(drift, hn::IfThenElseZero(feels, faster), x);
      hn::Store(faster, d, Part(velocity, k));
      hn::Store(farther, d, Part(position, k));
    }
  }
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {
namespace {
HWY_EXPORT(PullAnySheet);
HWY_EXPORT(PullAnyGroup);
HWY_EXPORT(MoveAll);

}  // namespace

SpringForces::SpringForces(const bodies::World& world) {
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (world.bodies[i].node_count == 0) continue;
    if (std::optional<SpringSheet> sheet = sheet_of(world, i))
      sheets_.push_back(std::move(*sheet));
    else
      groups_.push_back(group_of(world, i));
  }
}

double SpringForces::evaluate(const bodies::World& world, ExplicitState& state) {
  double power_W = 0.0;
  for (SpringSheet& sheet : sheets_)
    if (!world.bodies[sheet.body].is_sleeping)
      power_W += HWY_DYNAMIC_DISPATCH(PullAnySheet)(sheet, state);
  for (const SpringGroup& group : groups_) {
    const bodies::BodyRange& body = world.bodies[group.body];
    if (body.is_sleeping) continue;
    std::fill_n(state.force_N.begin() + body.first_node, body.node_count, PackedVector{});
    power_W += HWY_DYNAMIC_DISPATCH(PullAnyGroup)(group, state);
  }
  return power_W;
}

void move_nodes(const Move& move, const Eigen::Vector3d& gravity_m_s2, ExplicitState& state) {
  const PackedVector gravity{gravity_m_s2.x(), gravity_m_s2.y(), gravity_m_s2.z()};
  HWY_DYNAMIC_DISPATCH(MoveAll)(move, gravity, state);
}

}  // namespace stillgrid::dynamics
#endif
