#include "shared/dynamics/spring_table.hpp"

// SVE has vectors of unknown size, which lambdas may not return.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2)
// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shared/dynamics/spring_table.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 4>;
using DoubleColumn = hn::Vec<Doubles>;
constexpr std::size_t kDoubleLanes = hn::MaxLanes(Doubles());

/// x, y and z of as many of v's as a vector has lanes.
HWY_INLINE void GetDoubles(const Vector4* v, DoubleColumn& x, DoubleColumn& y, DoubleColumn& z) {
  const Doubles d;
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  const auto v0 = hn::Load(d, &v[0].x), v1 = hn::Load(d, &v[1].x);
  const auto v2 = hn::Load(d, &v[2].x), v3 = hn::Load(d, &v[3].x);
  const auto even0 = hn::InterleaveLower(d, v0, v1), even1 = hn::InterleaveLower(d, v2, v3);
  x = hn::ConcatLowerLower(d, even1, even0);
  y = hn::ConcatLowerLower(d, hn::InterleaveUpper(d, v2, v3), hn::InterleaveUpper(d, v0, v1));
  z = hn::ConcatUpperUpper(d, even1, even0);
#else
  DoubleColumn w;
  hn::LoadInterleaved4(d, &v[0].x, x, y, z, w);
#endif
}
HWY_INLINE void PutDoubles(DoubleColumn x, DoubleColumn y, DoubleColumn z, Vector4* v) {
  const Doubles d;
  hn::StoreInterleaved4(x, y, z, hn::Zero(d), d, &v[0].x);
}

/// Force along a spring: (k (1 - rest / length) + c (d . u) / length^2) d, on node a.
void AddSpringForces(const SpringTable::Arrays& springs, std::size_t count,
                     const Vector4* position_m, const Vector4* velocity_m_s, Vector4* forces_N) {
  const Doubles d;
  for (std::size_t i = 0; i < count; i += kDoubleLanes) {
    Vector4 apart[kDoubleLanes], opens[kDoubleLanes];
    for (std::size_t lane = 0; lane < kDoubleLanes; ++lane) {
      const auto a = static_cast<std::size_t>(springs.a[i + lane]);
      const auto b = static_cast<std::size_t>(springs.b[i + lane]);
      apart[lane] = position_m[b] - position_m[a];
      opens[lane] = velocity_m_s[b] - velocity_m_s[a];
    }
    DoubleColumn x, y, z, u, v, w;
    GetDoubles(apart, x, y, z);
    GetDoubles(opens, u, v, w);
    const auto square = hn::Max(x * x + y * y + z * z, hn::Set(d, 1e-300));
    const auto along = x * u + y * v + z * w, one = hn::Set(d, 1.0);
    const auto stiffness = hn::LoadU(d, &springs.stiffness_N_per_m[i]);
    const auto damping = hn::LoadU(d, &springs.damping_N_s_per_m[i]);
    const auto rest = hn::LoadU(d, &springs.rest_m[i]);
    const auto pull = stiffness * (one - rest / hn::Sqrt(square)) + damping * along / square;
    PutDoubles(pull * x, pull * y, pull * z, apart);
    for (std::size_t lane = 0; lane < kDoubleLanes; ++lane) {
      const auto a = static_cast<std::size_t>(springs.a[i + lane]);
      const auto b = static_cast<std::size_t>(springs.b[i + lane]);
      forces_N[a] = forces_N[a] + apart[lane];
      forces_N[b] = forces_N[b] - apart[lane];
    }
  }
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {

HWY_EXPORT(AddSpringForces);

namespace {
constexpr std::size_t kPadding = 4;  // lanes of the widest vector
}

SpringTable::SpringTable(const Description& description) {
  std::vector<Description::Spring> springs = description.springs;
  while (springs.size() % kPadding != 0) springs.emplace_back();
  for (const Description::Spring& spring : springs) {
    arrays_.a.push_back(spring.a);
    arrays_.b.push_back(spring.b);
    arrays_.rest_m.push_back(spring.rest_length_m);
    arrays_.stiffness_N_per_m.push_back(spring.stiffness_N_per_m);
    arrays_.damping_N_s_per_m.push_back(spring.damping_N_s_per_m);
  }
  all_ = arrays_;
  used_ = arrays_.a.size();
}

void SpringTable::leave_out(std::span<const std::uint8_t> sleeping_nodes) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all_.a.size(); ++i) {
    if (sleeping_nodes[static_cast<std::size_t>(all_.a[i])] != 0) continue;
    arrays_.a[kept] = all_.a[i];
    arrays_.b[kept] = all_.b[i];
    arrays_.rest_m[kept] = all_.rest_m[i];
    arrays_.stiffness_N_per_m[kept] = all_.stiffness_N_per_m[i];
    arrays_.damping_N_s_per_m[kept++] = all_.damping_N_s_per_m[i];
  }
  used_ = (kept + kPadding - 1) / kPadding * kPadding;
  for (; kept < used_; ++kept) {
    arrays_.a[kept] = arrays_.b[kept] = 0;
    arrays_.stiffness_N_per_m[kept] = arrays_.damping_N_s_per_m[kept] = 0.0;
  }
}

void SpringTable::add_forces(std::span<const Vector4> position_m,
                             std::span<const Vector4> velocity_m_s,
                             std::span<Vector4> forces_N) const {
  HWY_DYNAMIC_DISPATCH(AddSpringForces)
  (arrays_, used_, position_m.data(), velocity_m_s.data(), forces_N.data());
}

}  // namespace stillgrid::dynamics
#endif
