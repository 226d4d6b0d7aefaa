#include "sim_server/dynamics/spring_forces.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/dynamics/spring_forces.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#ifndef STILLGRID_SPRING_FORCES_ONCE
#define STILLGRID_SPRING_FORCES_ONCE
namespace stillgrid {
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
}  // namespace stillgrid
#endif

HWY_BEFORE_NAMESPACE();
namespace stillgrid::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, kLook>;
using Vec = hn::Vec<Tag>;
using FloatTag = hn::Rebind<float, Tag>;
using FourTag = hn::CappedTag<double, 4>;

struct Vec3 {
  Vec x, y, z;
};
/// Where x, y and z of a column are: after the first of a row of x, which rows of y and z follow.
struct Place {
  std::size_t x, y, z;

  HWY_INLINE Place(std::size_t column, std::size_t stride)
      : x(column), y(column + stride), z(column + 2 * stride) {}
};
HWY_INLINE Vec3 Load3(const double* row, const Place& at) {
  const Tag d;
  return {hn::LoadU(d, row + at.x), hn::LoadU(d, row + at.y), hn::LoadU(d, row + at.z)};
}
HWY_INLINE Vec3 Minus(const Vec3& a, const Vec3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec3 Plus(const Vec3& a, const Vec3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
/// a . b + more.
HWY_INLINE Vec Dot(const Vec3& a, const Vec3& b, Vec more) {
  return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::MulAdd(a.x, b.x, more)));
}
HWY_INLINE Vec3 Times(Vec s, const Vec3& a) {
  return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}

/// An estimate of 1 / sqrt(square), good to 11 bits.
HWY_INLINE hn::Vec<FloatTag> Near(Vec square) {
  return hn::ApproximateReciprocalSqrt(hn::DemoteTo(FloatTag(), square));
}

/// Springs' tension over length, k - push / length, and their dampers' power. With r near 1 /
/// length and e = 1 - length^2 r^2, 1 / length = r (1 + e/2 + 3 e^2/8 + 5 e^3/16) to 2^-43. along:
/// line . speed of the ends.
template <bool damped>
HWY_INLINE Vec Pull(Vec square, hn::Vec<FloatTag> near, Vec along, Vec stiffness, Vec push,
                    Vec damping, Vec& power) {
  const Tag d;
  const Vec r = hn::PromoteTo(d, near);
  const Vec e = hn::NegMulAdd(hn::Mul(square, r), r, hn::Set(d, 1.0));
  const Vec series =
      hn::MulAdd(hn::MulAdd(e, hn::Set(d, 0.3125), hn::Set(d, 0.375)), e, hn::Set(d, 0.5));
  const Vec pushed = hn::Mul(push, r);
  const Vec pull = hn::NegMulAdd(pushed, hn::Mul(series, e), hn::Sub(stiffness, pushed));
  if constexpr (!damped) return pull;
  const Vec exact = hn::MulAdd(hn::Mul(series, e), r, r);
  const Vec rate = hn::Mul(along, exact), force = hn::Mul(damping, rate);
  power = hn::MulAdd(force, rate, power);
  return hn::MulAdd(force, exact, pull);
}

/// Rows of x, y and z of the nodes of one row and of the two after it.
struct Stencil {
  const double* x[3];
  const double* v[3];
  double* own[3];   // forces
  double* next[2];  // against forces of the next column
  double* after;    // of the one after, of the first row
  double* pull;     // a row a kind
  double *squares, *alongs, *nears;
  std::size_t stride;
};

HWY_INLINE void Store3(const Vec3& v, double* row, const Place& at) {
  const Tag d;
  hn::StoreU(v.x, d, row + at.x);
  hn::StoreU(v.y, d, row + at.y);
  hn::StoreU(v.z, d, row + at.z);
}

/// Tension over length of the springs of one kind that begin in one row, in two loops: one alone is
/// such a long chain that the processor would mostly wait. Beyond its last spring they are zero.
template <bool damped>
HWY_INLINE Vec PullKind(const Stencil& s, const Ends& ends, double* HWY_RESTRICT to,
                        const SpringKind& springs, std::size_t columns, Vec power) {
  const Tag d;
  const std::size_t stride = s.stride;
  const double* const HWY_RESTRICT a = s.x[ends.a_row] + ends.a_column;
  const double* const HWY_RESTRICT b = s.x[ends.b_row] + ends.b_column;
  const double* const HWY_RESTRICT a_v = s.v[ends.a_row] + ends.a_column;
  const double* const HWY_RESTRICT b_v = s.v[ends.b_row] + ends.b_column;
  double* const HWY_RESTRICT squares = s.squares;
  double* const HWY_RESTRICT alongs = s.alongs;
  auto* const HWY_RESTRICT nears = reinterpret_cast<float*>(s.nears);
  for (std::size_t i = 0; i < columns; i += hn::Lanes(d)) {
    const Place at(i, stride);
    const Vec3 line = Minus(Load3(b, at), Load3(a, at));
    const Vec square = Dot(line, line, hn::Set(d, kShortest_m2));
    hn::Store(square, d, squares + i);
    hn::Store(Near(square), FloatTag(), nears + i);
    if (damped)
      hn::Store(Dot(line, Minus(Load3(b_v, at), Load3(a_v, at)), hn::Zero(d)), d, alongs + i);
  }
  const Vec k = hn::Set(d, springs.stiffness_N_m), c = hn::Set(d, springs.damping_N_s_m);
  const Vec push = hn::Set(d, springs.stiffness_N_m * springs.rest_length_m);
  const std::size_t reach = std::max(ends.a_column, ends.b_column);
  const std::size_t count = columns > reach ? columns - reach : 0;
  const auto pull = [&](std::size_t i, Vec k_i, Vec push_i, Vec c_i) HWY_ATTR {
    const Vec square = hn::Load(d, squares + i);
    const Vec along = damped ? hn::Load(d, alongs + i) : square;
    hn::Store(Pull<damped>(square, hn::Load(FloatTag(), nears + i), along, k_i, push_i, c_i, power),
              d, to + i);
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

/// Makes forces of them. All stores are where the same look loads, so that none waits for another:
/// what belongs to the next columns is kept apart until the row is done.
HWY_INLINE void AddForces(const Stencil& s, std::size_t columns) {
  const Tag d;
  const double *const HWY_RESTRICT x0 = s.x[0], *const HWY_RESTRICT x1 = s.x[1],
                                   *const HWY_RESTRICT x2 = s.x[2];
  double *const HWY_RESTRICT own0 = s.own[0], *const HWY_RESTRICT own1 = s.own[1],
                             *const HWY_RESTRICT own2 = s.own[2],
                             *const HWY_RESTRICT after = s.after;
  double *const HWY_RESTRICT next0 = s.next[0], *const HWY_RESTRICT next1 = s.next[1];
  const std::size_t stride = s.stride;
  const double *const HWY_RESTRICT pulls = s.pull, *const HWY_RESTRICT more = pulls + 3 * stride;
  for (std::size_t i = 0; i < columns; i += hn::Lanes(d)) {
    const Place at(i, stride);
    const Vec3 x00 = Load3(x0, at), x01 = Load3(x0 + 1, at), x10 = Load3(x1, at);
    const auto force = [&](const double* pull, std::size_t place, const Vec3& from, const Vec3& to)
                           HWY_ATTR { return Times(hn::Load(d, pull + place), Minus(to, from)); };
    const Vec3 right = force(pulls, at.x, x00, x01), other = force(more, at.x, x01, x10);
    Store3(Plus(Load3(next0, at), Minus(right, other)), next0, at);
    const Vec3 down = force(pulls, at.y, x00, x10);
    Store3(Minus(Load3(own1, at), Plus(down, other)), own1, at);
    const Vec3 diagonal = force(pulls, at.z, x00, Load3(x1 + 1, at));
    Store3(diagonal, next1, at);
    const Vec3 right2 = force(more, at.y, x00, Load3(x0 + 2, at));
    Store3(right2, after, at);
    const Vec3 up2 = force(more, at.z, Load3(x2, at), x00);
    Store3(up2, own2, at);
    Store3(Plus(Plus(Load3(own0, at), Plus(right, down)), Plus(diagonal, Minus(right2, up2))), own0,
           at);
  }
}

/// Transposes a row of nodes.
HWY_INLINE void Unpack(const PackedVector* HWY_RESTRICT from, std::size_t columns,
                       double* HWY_RESTRICT to, std::size_t stride) {
  const Tag d;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= columns; i += hn::Lanes(d)) {
    Vec x, y, z, zero;
    hn::LoadInterleaved4(d, &from[i].x, x, y, z, zero);
    Store3({x, y, z}, to, Place(i, stride));
  }
  for (; i < columns; ++i) {
    to[i] = from[i].x;
    to[i + stride] = from[i].y;
    to[i + 2 * stride] = from[i].z;
  }
}

/// Forces of a row whose springs are all done.
HWY_INLINE void PackForces(const Stencil& s, std::size_t columns, PackedVector* HWY_RESTRICT to) {
  const Tag d;
  const Vec zero = hn::Zero(d);
  const double *const HWY_RESTRICT own = s.own[0], *const HWY_RESTRICT next = s.next[0] - 1,
                                   *const HWY_RESTRICT after = s.after - 2;
  for (std::size_t i = 0; i < columns; i += hn::Lanes(d)) {
    const Place at(i, s.stride);
    const Vec3 sum = Minus(Minus(Load3(own, at), Load3(next, at)), Load3(after, at));
    if (i + hn::Lanes(d) <= columns) {
      hn::StoreInterleaved4(sum.x, sum.y, sum.z, zero, d, &to[i].x);
    } else {
      PackedVector rest[kLook];
      hn::StoreInterleaved4(sum.x, sum.y, sum.z, zero, d, &rest[0].x);
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
  std::fill(rows[SheetRows::kForces], rows[SheetRows::kPulls] - kLook, 0.0);
  Vec power = hn::Zero(Tag());
  for (std::size_t row = 0; row < sheet.rows; ++row) {
    if (row + 2 < sheet.rows) enter(row + 2);
    Stencil s{};
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
    s.nears = rows[SheetRows::kScratch + 1];
    s.alongs = rows[SheetRows::kScratch + 2];
    s.stride = sheet.stride;
    const SpringKind none;
    for (std::size_t kind = 0; kind < kSpringKinds; ++kind) {
      const bool fits = row + kEnds[kind].b_row < sheet.rows;
      power = PullKind<damped>(s, kEnds[kind], s.pull + kind * s.stride,
                               fits ? sheet.kinds[kind] : none, sheet.columns, power);
    }
    AddForces(s, sheet.columns);
    PackForces(s, sheet.columns, &state.force_N[sheet.first_node + row * sheet.columns]);
  }
  return hn::GetLane(hn::SumOfLanes(Tag(), power));
}

double PullAnySheet(SpringSheet& sheet, ExplicitState& state) {
  return sheet.damped ? PullSheet<true>(sheet, state) : PullSheet<false>(sheet, state);
}

/// The difference of two nodes' vectors.
HWY_INLINE void Difference(const PackedVector& to, const PackedVector& from, double* difference) {
  const FourTag d;
  for (std::size_t k = 0; k < 4; k += hn::Lanes(d))
    hn::Store(hn::Sub(hn::Load(d, &to.x + k), hn::Load(d, &from.x + k)), d, difference + k);
}

template <bool damped>
double PullGroup(const SpringGroup& group, ExplicitState& state) {
  const Tag d;
  const FourTag d4;
  Vec power = hn::Zero(d);
  alignas(64) double lines[4 * kLook], speeds[4 * kLook], pulls[kLook];
  for (std::size_t i = 0; i < group.a.size(); i += kLook) {
    for (std::size_t k = 0; k < kLook; ++k) {
      const std::size_t a = group.a[i + k], b = group.b[i + k];
      Difference(state.position_m[b], state.position_m[a], lines + 4 * k);
      if (damped) Difference(state.velocity_m_s[b], state.velocity_m_s[a], speeds + 4 * k);
    }
    for (std::size_t k = 0; k < kLook; k += hn::Lanes(d)) {
      Vec3 line, speed;
      Vec zero;
      hn::LoadInterleaved4(d, lines + 4 * k, line.x, line.y, line.z, zero);
      const Vec square = Dot(line, line, hn::Set(d, kShortest_m2));
      Vec along = zero, damping = zero;
      if (damped) {
        hn::LoadInterleaved4(d, speeds + 4 * k, speed.x, speed.y, speed.z, zero);
        along = Dot(line, speed, zero);
        damping = hn::LoadU(d, group.damping_N_s_m.data() + i + k);
      }
      hn::Store(Pull<damped>(square, Near(square), along,
                             hn::LoadU(d, group.stiffness_N_m.data() + i + k),
                             hn::LoadU(d, group.push_N.data() + i + k), damping, power),
                d, pulls + k);
    }
    for (std::size_t k = 0; k < kLook; ++k) {
      double* a = &state.force_N[group.a[i + k]].x;
      double* b = &state.force_N[group.b[i + k]].x;
      for (std::size_t l = 0; l < 4; l += hn::Lanes(d4)) {
        const auto force = hn::Mul(hn::Set(d4, pulls[k]), hn::Load(d4, lines + 4 * k + l));
        hn::Store(hn::Add(hn::Load(d4, a + l), force), d4, a + l);
        hn::Store(hn::Sub(hn::Load(d4, b + l), force), d4, b + l);
      }
    }
  }
  return hn::GetLane(hn::SumOfLanes(d, power));
}

double PullAnyGroup(const SpringGroup& group, ExplicitState& state) {
  return group.damped ? PullGroup<true>(group, state) : PullGroup<false>(group, state);
}

template <bool forward>
void MoveNodes(const Move& move, const PackedVector& gravity_m_s2, ExplicitState& state) {
  const FourTag d;
  const auto kick = hn::Set(d, move.kick_s), drift = hn::Set(d, move.drift_s);
  for (std::size_t i = 0; i < state.position_m.size(); ++i) {
    const auto per_mass = hn::Set(d, state.per_mass_kg[i]);
    const auto feels = hn::Gt(per_mass, hn::Zero(d));
    double *position = &state.position_m[i].x, *velocity = &state.velocity_m_s[i].x;
    for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) {
      const auto a = hn::MulAdd(per_mass, hn::Load(d, &state.force_N[i].x + k),
                                hn::Load(d, &gravity_m_s2.x + k));
      const auto x = hn::Load(d, position + k), v = hn::Load(d, velocity + k);
      const auto faster = hn::MulAdd(kick, hn::IfThenElseZero(feels, a), v);
      const auto farther = hn::MulAdd(drift, hn::IfThenElseZero(feels, forward ? v : faster), x);
      hn::Store(faster, d, velocity + k);
      hn::Store(farther, d, position + k);
    }
  }
}

void MoveAll(const Move& move, const PackedVector& gravity_m_s2, ExplicitState& state) {
  if (move.forward)
    MoveNodes<true>(move, gravity_m_s2, state);
  else
    MoveNodes<false>(move, gravity_m_s2, state);
}

}  // namespace stillgrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid {
namespace {
HWY_EXPORT(PullAnySheet);
HWY_EXPORT(PullAnyGroup);
HWY_EXPORT(MoveAll);

}  // namespace

SpringForces::SpringForces(const World& world) {
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (world.bodies[i].node_count == 0) continue;
    if (std::optional<SpringSheet> sheet = sheet_of(world, i))
      sheets_.push_back(std::move(*sheet));
    else
      groups_.push_back(group_of(world, i));
  }
}

double SpringForces::evaluate(const World& world, ExplicitState& state) {
  double power_W = 0.0;
  for (SpringSheet& sheet : sheets_)
    if (!world.bodies[sheet.body].asleep)
      power_W += HWY_DYNAMIC_DISPATCH(PullAnySheet)(sheet, state);
  for (const SpringGroup& group : groups_) {
    const BodyRange& body = world.bodies[group.body];
    if (body.asleep) continue;
    std::fill_n(state.force_N.begin() + body.first_node, body.node_count, PackedVector{});
    power_W += HWY_DYNAMIC_DISPATCH(PullAnyGroup)(group, state);
  }
  return power_W;
}

void move_nodes(const Move& move, const Eigen::Vector3d& gravity_m_s2, ExplicitState& state) {
  const PackedVector gravity{gravity_m_s2.x(), gravity_m_s2.y(), gravity_m_s2.z()};
  HWY_DYNAMIC_DISPATCH(MoveAll)(move, gravity, state);
}

}  // namespace stillgrid
#endif
