// Vectors of contacts, lane by lane; included once for every instruction set that Highway knows.
#if defined(STILLGRID_COLUMNS) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLGRID_COLUMNS
#undef STILLGRID_COLUMNS
#else
#define STILLGRID_COLUMNS
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "shared/dynamics/contact_row.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// No product is fused with a sum, and quotients and roots are exact: all targets round alike.
using Floats = hn::CappedTag<float, kRowLanes>;
using Column = hn::Vec<Floats>;
constexpr std::size_t kColumnLanes = hn::MaxLanes(Floats());

struct Column3 {
  Column x, y, z;
};

HWY_INLINE Column All(float value) {
  return hn::Set(Floats(), value);
}
HWY_INLINE Column Get(const RowFloats& lanes, std::size_t i) {
  return hn::Load(Floats(), lanes + i);
}
HWY_INLINE void Put(Column v, RowFloats& lanes, std::size_t i) {
  hn::Store(v, Floats(), lanes + i);
}
HWY_INLINE Column3 Get(const RowFloats (&lanes)[3], std::size_t i) {
  return {Get(lanes[0], i), Get(lanes[1], i), Get(lanes[2], i)};
}
HWY_INLINE void Put(const Column3& v, RowFloats (&lanes)[3], std::size_t i) {
  Put(v.x, lanes[0], i);
  Put(v.y, lanes[1], i);
  Put(v.z, lanes[2], i);
}

HWY_INLINE Column3 operator+(const Column3& a, const Column3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
HWY_INLINE Column3 operator-(const Column3& a, const Column3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
HWY_INLINE Column3 operator*(Column s, const Column3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
HWY_INLINE Column Dot(const Column3& a, const Column3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
HWY_INLINE Column3 Cross(const Column3& a, const Column3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

#if HWY_TARGET == HWY_SCALAR
template <class Address>
HWY_INLINE void GetColumns(const Address& at, Column3& v, Column& w) {
  const Floats d;
  v = {hn::Load(d, at(0)), hn::Load(d, at(0) + 1), hn::Load(d, at(0) + 2)};
  w = hn::Load(d, at(0) + 3);
}
template <class Address>
HWY_INLINE void PutColumns(const Column3& v, Column w, const Address& at) {
  const Floats d;
  hn::Store(v.x, d, at(0));
  hn::Store(v.y, d, at(0) + 1);
  hn::Store(v.z, d, at(0) + 2);
  hn::Store(w, d, at(0) + 3);
}
#else
/// Four numbers of each lane k with k modulo 4 = first, in blocks of 128 bits.
template <class D, class Address>
HWY_INLINE hn::Vec<D> LoadBlocks(D d, const Address& at, std::size_t first) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::Load(d, at(first));
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, LoadBlocks(half, at, first + hn::MaxLanes(half)),
                       LoadBlocks(half, at, first));
  }
}
template <class D, class Address>
HWY_INLINE void StoreBlocks(D d, hn::Vec<D> v, const Address& at, std::size_t first) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    hn::Store(v, d, at(first));
  } else {
    const hn::Half<D> half;
    StoreBlocks(half, hn::LowerHalf(half, v), at, first);
    StoreBlocks(half, hn::UpperHalf(half, v), at, first + hn::MaxLanes(half));
  }
}

/// 4 x 4 transpositions within blocks of 128 bits.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void Transpose(D d, V& q0, V& q1, V& q2, V& q3) {
  const hn::Repartition<double, D> pairs;
  const auto a = hn::BitCast(pairs, hn::InterleaveLower(d, q0, q1));
  const auto b = hn::BitCast(pairs, hn::InterleaveUpper(d, q0, q1));
  const auto c = hn::BitCast(pairs, hn::InterleaveLower(d, q2, q3));
  const auto e = hn::BitCast(pairs, hn::InterleaveUpper(d, q2, q3));
  q0 = hn::BitCast(d, hn::InterleaveLower(pairs, a, c));
  q1 = hn::BitCast(d, hn::InterleaveUpper(pairs, a, c));
  q2 = hn::BitCast(d, hn::InterleaveLower(pairs, b, e));
  q3 = hn::BitCast(d, hn::InterleaveUpper(pairs, b, e));
}

/// Four numbers of each lane; at(k) is the aligned address of those of lane k.
template <class Address>
HWY_INLINE void GetColumns(const Address& at, Column3& v, Column& w) {
  const Floats d;
  v.x = LoadBlocks(d, at, 0);
  v.y = LoadBlocks(d, at, 1);
  v.z = LoadBlocks(d, at, 2);
  w = LoadBlocks(d, at, 3);
  Transpose(d, v.x, v.y, v.z, w);
}
template <class Address>
HWY_INLINE void PutColumns(Column3 v, Column w, const Address& at) {
  const Floats d;
  Transpose(d, v.x, v.y, v.z, w);
  StoreBlocks(d, v.x, at, 0);
  StoreBlocks(d, v.y, at, 1);
  StoreBlocks(d, v.z, at, 2);
  StoreBlocks(d, w, at, 3);
}

#endif

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
