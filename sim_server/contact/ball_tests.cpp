#include "sim_server/contact/ball_tests.hpp"

#include <cassert>

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/contact/ball_tests.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace stillgrid::contact::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// As many lanes as a mask of one byte has bits.
constexpr std::size_t kMaxLanes = 8;
using FloatTag = hn::CappedTag<float, kMaxLanes>;

#if HWY_TARGET != HWY_SCALAR
/// Pairs that are tested at once: as many as a vector has lanes for certain.
#if HWY_HAVE_SCALABLE  // known only when the program runs
constexpr std::size_t kPairs = 4;
#else
constexpr std::size_t kPairs = hn::MaxLanes(FloatTag());
#endif
using PairTag = hn::FixedTag<float, kPairs>;

/// The balls of pairs as one vector each, four floats a ball.
template <class Number>
HWY_INLINE auto LoadBalls(const SpherePair* pairs, const collision::SweptBound* balls,
                          Number number) {
  const auto load = [&](std::size_t k) HWY_ATTR {
    return hn::LoadU(hn::FixedTag<float, 4>(), balls[number(pairs[k])].centre_m.data());
  };
  if constexpr (kPairs == kMaxLanes)
    return hn::Combine(PairTag(), load(4), load(0));
  else
    return load(0);
}

/// kPairs pairs: each makes one row (dx, dy, dz, ra + rb) of matrices of four by four. Returns a
/// bit for each that overlaps.
HWY_INLINE std::uint32_t OverlappingBits(const SpherePair* pairs,
                                         const collision::SweptBound* balls) {
  const PairTag d;
  const hn::RepartitionToWide<PairTag> wide;
  alignas(16) constexpr float kSign[4] = {0.0F, 0.0F, 0.0F, -0.0F};
  const auto sign = hn::LoadDup128(d, kSign);
  const auto squares = [&](std::size_t k) HWY_ATTR {
    const auto a = LoadBalls(pairs + k, balls, [](const SpherePair& pair) { return pair.a; });
    const auto b = LoadBalls(pairs + k, balls, [](const SpherePair& pair) { return pair.b; });
    const auto row = hn::Sub(a, hn::Xor(b, sign));
    return hn::Mul(row, row);
  };
  const auto s0 = squares(0), s1 = squares(1), s2 = squares(2), s3 = squares(3);
  const auto xy01 = hn::BitCast(wide, hn::InterleaveLower(d, s0, s1));
  const auto xy23 = hn::BitCast(wide, hn::InterleaveLower(d, s2, s3));
  const auto zr01 = hn::BitCast(wide, hn::InterleaveUpper(d, s0, s1));
  const auto zr23 = hn::BitCast(wide, hn::InterleaveUpper(d, s2, s3));
  const auto x = hn::BitCast(d, hn::InterleaveLower(wide, xy01, xy23));
  const auto y = hn::BitCast(d, hn::InterleaveUpper(wide, xy01, xy23));
  const auto z = hn::BitCast(d, hn::InterleaveLower(wide, zr01, zr23));
  const auto bounding_radius = hn::BitCast(d, hn::InterleaveUpper(wide, zr01, zr23));
  std::uint8_t mask[8];
  hn::StoreMaskBits(d, hn::Lt(hn::Add(hn::Add(x, y), z), bounding_radius), mask);
  return mask[0];
}
#endif

std::size_t Overlapping(const SpherePair* pairs, std::size_t count,
                        const collision::SweptBound* balls, SpherePair* found) {
  std::size_t kept = 0, i = 0;
#if HWY_TARGET != HWY_SCALAR
  for (; i + kPairs <= count; i += kPairs, pairs += kPairs) {
    const std::uint32_t bits = OverlappingBits(pairs, balls);
    for (std::size_t k = 0; k < kPairs; ++k) {
      found[kept] = pairs[k];
      kept += (bits >> k) & 1U;
    }
  }
#endif
  for (; i < count; ++i, ++pairs) {
    const auto& [a, ra] = balls[pairs->a];
    const auto& [b, rb] = balls[pairs->b];
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2], bounding_radius = ra + rb;
    if (x * x + y * y + z * z < bounding_radius * bounding_radius) found[kept++] = *pairs;
  }
  return kept;
}

/// Whether each ball is within its swept bound, but for the slack that swept bounds have.
std::size_t FindEscaped(const collision::SweptBound* balls,
                        const collision::SweptBound* swept_bounds, std::size_t count,
                        std::uint32_t* escaped, std::size_t room) {
  const FloatTag d;
  const std::size_t lanes = hn::Lanes(d);
  const auto slack = hn::Set(d, 1.0F - 0.5F * kBoundSlack);
  std::size_t found = 0, i = 0;
  const auto add = [&](std::size_t number) HWY_ATTR {
    if (found < room) escaped[found] = static_cast<std::uint32_t>(number);
    ++found;
  };
  for (; i + lanes <= count && found <= room; i += lanes) {
    hn::Vec<FloatTag> x, y, z, radius, cx, cy, cz, bounding_radius;
    hn::LoadInterleaved4(d, balls[i].centre_m.data(), x, y, z, radius);
    hn::LoadInterleaved4(d, swept_bounds[i].centre_m.data(), cx, cy, cz, bounding_radius);
    x = hn::Sub(x, cx);
    y = hn::Sub(y, cy);
    z = hn::Sub(z, cz);
    const auto left = hn::Sub(hn::Mul(bounding_radius, slack), radius);
    const auto distance2 = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    const auto held = hn::And(hn::Le(distance2, hn::Mul(left, left)), hn::Ge(left, hn::Zero(d)));
    if (HWY_LIKELY(hn::AllTrue(d, held))) continue;
    std::uint8_t mask[8];
    hn::StoreMaskBits(d, held, mask);
    for (std::size_t k = 0; k < lanes; ++k)
      if (((mask[0] >> k) & 1U) == 0) add(i + k);
  }
  for (; i < count && found <= room; ++i)
    if (!holds(swept_bounds[i], balls[i])) add(i);
  return found;
}

}  // namespace stillgrid::contact::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::contact {
namespace {
HWY_EXPORT(Overlapping);
HWY_EXPORT(FindEscaped);
}  // namespace

bool holds(const collision::SweptBound& swept_bound, const collision::SweptBound& ball) noexcept {
  const auto& [c, bounding_radius_m] = swept_bound;
  const auto& [p, radius_m] = ball;
  const float x = p[0] - c[0], y = p[1] - c[1], z = p[2] - c[2];
  const float left_m = bounding_radius_m * (1.0F - 0.5F * kBoundSlack) - radius_m;
  return x * x + y * y + z * z <= left_m * left_m && left_m >= 0.0F;
}

std::size_t overlapping_pairs(std::span<const SpherePair> pairs,
                              std::span<const collision::SweptBound> balls,
                              std::span<SpherePair> found) {
  assert(found.size() >= pairs.size());
  return HWY_DYNAMIC_DISPATCH(Overlapping)(pairs.data(), pairs.size(), balls.data(), found.data());
}

std::size_t find_escaped(std::span<const collision::SweptBound> balls,
                         std::span<const collision::SweptBound> swept_bounds,
                         std::span<std::uint32_t> escaped) {
  assert(balls.size() == swept_bounds.size());
  return HWY_DYNAMIC_DISPATCH(FindEscaped)(balls.data(), swept_bounds.data(), balls.size(),
                                           escaped.data(), escaped.size());
}

}  // namespace stillgrid::contact
#endif
