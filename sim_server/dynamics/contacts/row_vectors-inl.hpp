// Vectors of contacts, lane by lane; included once for every instruction set that Highway knows.
#if defined(STILLGRID_ROW_VECTORS) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLGRID_ROW_VECTORS
#undef STILLGRID_ROW_VECTORS
#else
#define STILLGRID_ROW_VECTORS
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>

#include "sim_server/dynamics/contacts/contact_rows.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Four lanes at most, as many as a point's vector has. No product is fused with a sum, so that
// every target rounds alike.
using Tag = hn::CappedTag<double, 4>;
using Vec = hn::Vec<Tag>;
using Lane = ContactRows::Lane;
using Vector = ContactRows::Vector;
constexpr std::size_t kLanes = ContactRows::kLanes;

HWY_INLINE Vec Number(double value) {
  return hn::Set(Tag(), value);
}
HWY_INLINE Vec Get(const Lane& lane, std::size_t i) {
  return hn::Load(Tag(), lane.data() + i);
}
HWY_INLINE void Put(Vec v, Lane& lane, std::size_t i) {
  hn::Store(v, Tag(), lane.data() + i);
}
HWY_INLINE void Get(const Vector& from, std::size_t i, Vec& x, Vec& y, Vec& z) {
  x = Get(from[0], i);
  y = Get(from[1], i);
  z = Get(from[2], i);
}
HWY_INLINE void Put(Vec x, Vec y, Vec z, Vector& to, std::size_t i) {
  Put(x, to[0], i);
  Put(y, to[1], i);
  Put(z, to[2], i);
}
HWY_INLINE Vec Dot(Vec ax, Vec ay, Vec az, Vec bx, Vec by, Vec bz) {
  return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}
/// a * d - b * c.
HWY_INLINE Vec Minor(Vec a, Vec d, Vec b, Vec c) {
  return hn::Sub(hn::Mul(a, d), hn::Mul(b, c));
}

/// The vectors of as many lanes as a register has, coordinate by coordinate.
template <class Place>
HWY_INLINE void Gather(const Place& place, std::size_t i, Vec& x, Vec& y, Vec& z) {
  const Tag d;
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  const Vec v0 = hn::Load(d, &place(i)->x), v1 = hn::Load(d, &place(i + 1)->x);
  const Vec v2 = hn::Load(d, &place(i + 2)->x), v3 = hn::Load(d, &place(i + 3)->x);
  const Vec even0 = hn::InterleaveLower(d, v0, v1), even1 = hn::InterleaveLower(d, v2, v3);
  x = hn::ConcatLowerLower(d, even1, even0);
  y = hn::ConcatLowerLower(d, hn::InterleaveUpper(d, v2, v3), hn::InterleaveUpper(d, v0, v1));
  z = hn::ConcatUpperUpper(d, even1, even0);
#else
  std::array<PackedVector, 4> lanes;
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) lanes[k] = *place(i + k);
  Vec zero;
  hn::LoadInterleaved4(d, &lanes[0].x, x, y, z, zero);
#endif
}

/// The other way round.
HWY_INLINE void Spread(Vec x, Vec y, Vec z, PackedVector* HWY_RESTRICT lanes) {
  hn::StoreInterleaved4(x, y, z, hn::Zero(Tag()), Tag(), &lanes[0].x);
}

/// linear + angular x arm.
template <class Point>
HWY_INLINE void VelocityOf(const Point& point, const Vector& arm_m, std::size_t i, Vec& x, Vec& y,
                           Vec& z) {
  Vec wx, wy, wz, rx, ry, rz;
  Gather([&](std::size_t k) { return &point(k).linear; }, i, x, y, z);
  Gather([&](std::size_t k) { return &point(k).angular; }, i, wx, wy, wz);
  Get(arm_m, i, rx, ry, rz);
  x = hn::Add(x, Minor(wy, rz, wz, ry));
  y = hn::Add(y, Minor(wz, rx, wx, rz));
  z = hn::Add(z, Minor(wx, ry, wy, rx));
}

/// Of a's point of contact from b's.
HWY_INLINE void RelativeVelocity(const ContactRows& rows, const ContactPoint* HWY_RESTRICT points,
                                 std::size_t i, Vec& x, Vec& y, Vec& z) {
  Vec bx, by, bz, gx, gy, gz;
  VelocityOf(
      [&](std::size_t k) -> auto& { return points[rows.a[k]]; }, rows.arm_a_m, i, x, y, z);
  VelocityOf(
      [&](std::size_t k) -> auto& { return points[rows.b[k]]; }, rows.arm_b_m, i, bx, by, bz);
  Get(rows.given_m_s, i, gx, gy, gz);
  x = hn::Sub(hn::Sub(x, bx), gx);
  y = hn::Sub(hn::Sub(y, by), gy);
  z = hn::Sub(hn::Sub(z, bz), gz);
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
