// Vectors of springs; included once for every instruction set that Highway knows.
#if defined(STILLGRID_SPRING_VECTORS) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLGRID_SPRING_VECTORS
#undef STILLGRID_SPRING_VECTORS
#else
#define STILLGRID_SPRING_VECTORS
#endif

#include <hwy/highway.h>

#include <limits>

#include "sim_server/contact/vector_row.hpp"
#include "sim_server/dynamics/forces/spring_layout.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A vector may have no size that the compiler knows (SVE): none is kept in a structure.
using Tag = hn::CappedTag<double, contact::kLanes>;
using Vec = hn::Vec<Tag>;
using FourTag = hn::CappedTag<double, 4>;

/// a . b + more.
template <class V>
HWY_INLINE V Dot(V ax, V ay, V az, V bx, V by, V bz, V more) {
  return hn::MulAdd(az, bz, hn::MulAdd(ay, by, hn::MulAdd(ax, bx, more)));
}

#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
/// An estimate of 1 / sqrt(square), good to 14 bits.
HWY_INLINE hn::Vec<Tag> Near(Tag, hn::Vec<Tag> square) {
  return {_mm512_rsqrt14_pd(square.raw)};
}
HWY_INLINE hn::Vec<FourTag> Near(FourTag, hn::Vec<FourTag> square) {
  return {_mm256_rsqrt14_pd(square.raw)};
}
#else
/// An estimate of 1 / sqrt(square), good to 11 bits.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V Near(D d, V square) {
  const hn::Rebind<float, D> d_float;
  const auto rough = hn::DemoteTo(d_float, square), r = hn::ApproximateReciprocalSqrt(rough);
#if HWY_TARGET == HWY_SSSE3 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_AVX2
  return hn::PromoteTo(d, r);
#else  // it is good to 8 bits only: a step of Newton's
  const auto half = hn::Mul(hn::Set(d_float, 0.5F), rough);
  const auto better = hn::Mul(r, hn::NegMulAdd(hn::Mul(half, r), r, hn::Set(d_float, 1.5F)));
  // Zero where a float ends, as the others estimate: of infinity it would be no number.
  const auto there = hn::Lt(rough, hn::Set(d_float, std::numeric_limits<float>::max()));
  return hn::PromoteTo(d, hn::IfThenElseZero(there, better));
#endif
}
#endif

/// With r near 1 / length, what 1 / length is more, over r: with e = 1 - length^2 r^2,
/// 1 / length = r (1 + e/2 + 3 e^2/8 + 5 e^3/16) to 2^-43.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V More(D d, V square, V r) {
  const V e = hn::NegMulAdd(hn::Mul(square, r), r, hn::Set(d, 1.0));
  const V series =
      hn::MulAdd(hn::MulAdd(e, hn::Set(d, 0.3125), hn::Set(d, 0.375)), e, hn::Set(d, 0.5));
  return hn::Mul(series, e);
}

/// Springs' tension over length, k - push / length, and their dampers' power. along: line . speed
/// of the ends.
template <bool damped, class D, class V = hn::Vec<D>>
HWY_INLINE V Pull(D d, V square, V along, V stiffness, V push, V damping, V& power) {
  const V r = Near(d, square), more = More(d, square, r);
  const V pushed = hn::Mul(push, r);
  const V pull = hn::NegMulAdd(pushed, more, hn::Sub(stiffness, pushed));
  if constexpr (!damped) return pull;
  const V exact = hn::MulAdd(more, r, r);
  const V rate = hn::Mul(along, exact), force = hn::Mul(damping, rate);
  power = hn::MulAdd(force, rate, power);
  return hn::MulAdd(force, exact, pull);
}

/// v + kick (f / m + g); where the inverse mass is zero, v.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V Kicked(D d, V inverse_mass, V force, V gravity, V kick, V v) {
  const V a = hn::MulAdd(inverse_mass, force, gravity);
  return hn::MulAdd(kick, hn::IfThenElseZero(hn::Gt(inverse_mass, hn::Zero(d)), a), v);
}

/// x + drift v; where the inverse mass is zero, x.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V Drifted(D d, V inverse_mass, V v, V drift, V x) {
  return hn::MulAdd(drift, hn::IfThenElseZero(hn::Gt(inverse_mass, hn::Zero(d)), v), x);
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
