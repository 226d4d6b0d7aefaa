#include "shared/dynamics/spring_table.hpp"

#include <algorithm>

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

#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
constexpr bool kHoldsAPlace = true;  // a vector is a Vector4
#else
constexpr bool kHoldsAPlace = false;
#endif

/// x, y and z of ends b less those of ends a, a spring a lane.
HWY_INLINE void Differences(const Vector4* values, const std::int32_t* a, const std::int32_t* b,
                            DoubleColumn& x, DoubleColumn& y, DoubleColumn& z) {
  const Doubles d;
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  const auto difference = [&](std::size_t lane) HWY_ATTR {
    return hn::Load(d, &values[b[lane]].x) - hn::Load(d, &values[a[lane]].x);
  };
  const auto v0 = difference(0), v1 = difference(1), v2 = difference(2), v3 = difference(3);
  const auto even0 = hn::InterleaveLower(d, v0, v1), even1 = hn::InterleaveLower(d, v2, v3);
  x = hn::ConcatLowerLower(d, even1, even0);
  y = hn::ConcatLowerLower(d, hn::InterleaveUpper(d, v2, v3), hn::InterleaveUpper(d, v0, v1));
  z = hn::ConcatUpperUpper(d, even1, even0);
#else
  Vector4 apart[kDoubleLanes];
  for (std::size_t lane = 0; lane < kDoubleLanes; ++lane)
    apart[lane] = values[b[lane]] - values[a[lane]];
  DoubleColumn w;
  hn::LoadInterleaved4(d, &apart[0].x, x, y, z, w);
#endif
}
HWY_INLINE void PutDoubles(DoubleColumn x, DoubleColumn y, DoubleColumn z, Vector4* v) {
  const Doubles d;
  hn::StoreInterleaved4(x, y, z, hn::Zero(d), d, &v[0].x);
}

/// Force along a spring: (k (1 - rest / length) + c (d . u) / length^2) d, on node a.
void PullSprings(const SpringTable::Arrays& springs, std::size_t first, std::size_t end,
                 const Vector4* position_m, const Vector4* velocity_m_s, Vector4* pulls_N) {
  const Doubles d;
  for (std::size_t i = first; i < end; i += kDoubleLanes) {
    DoubleColumn x, y, z, u, v, w;
    Differences(position_m, &springs.a[i], &springs.b[i], x, y, z);
    Differences(velocity_m_s, &springs.a[i], &springs.b[i], u, v, w);
    const auto square = hn::Max(x * x + y * y + z * z, hn::Set(d, 1e-300));
    const auto one = hn::Set(d, 1.0), inverse = one / square;
    const auto along = x * u + y * v + z * w;
    const auto stiffness = hn::LoadU(d, &springs.stiffness_N_per_m[i]);
    const auto damping = hn::LoadU(d, &springs.damping_N_s_per_m[i]);
    const auto rest = hn::LoadU(d, &springs.rest_m[i]);
    const auto pull = stiffness * (one - rest * hn::Sqrt(inverse)) + damping * along * inverse;
    PutDoubles(pull * x, pull * y, pull * z, &pulls_N[i]);
  }
}

/// Sums are kept in registers, two that do not wait for each other: springs that follow each other
/// share nodes, and would wait for each other's stores.
void SumPulls(std::span<const SpringTable::NodeEnds> nodes, const std::uint32_t* ends,
              const Vector4* pulls_N, Vector4* forces_N) {
  const Doubles d;
  for (const SpringTable::NodeEnds& node : nodes) {
    Vector4& force = forces_N[node.node];
    if constexpr (kHoldsAPlace) {
      auto begin = hn::Zero(d), end = begin;
      for (std::uint32_t k = node.first; k < node.first_ending; ++k)
        begin = begin + hn::Load(d, &pulls_N[ends[k]].x);
      for (std::uint32_t k = node.first_ending; k < node.end; ++k)
        end = end + hn::Load(d, &pulls_N[ends[k]].x);
      hn::Store(hn::Load(d, &force.x) + (begin - end), d, &force.x);
    } else {
      Vector4 begin, end;
      for (std::uint32_t k = node.first; k < node.first_ending; ++k)
        begin = begin + pulls_N[ends[k]];
      for (std::uint32_t k = node.first_ending; k < node.end; ++k) end = end + pulls_N[ends[k]];
      force = force + (begin - end);
    }
  }
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {

HWY_EXPORT(PullSprings);
HWY_EXPORT(SumPulls);

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
  ends_.resize(2 * used_);
  pulls_N_.resize(used_);
  nodes_.reserve(description.nodes.size());
  for (auto& next : next_) next.resize(description.nodes.size());
  list_ends();
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
  list_ends();
}

/// Springs of no stiffness pad vectors and pull nobody.
void SpringTable::list_ends() {
  for (auto& next : next_) std::fill(next.begin(), next.end(), 0U);
  const auto each_end = [&](const auto& visit) {
    for (std::uint32_t i = 0; i < used_; ++i) {
      if (arrays_.a[i] == arrays_.b[i]) continue;
      visit(i, next_[0][static_cast<std::size_t>(arrays_.a[i])]);
      visit(i, next_[1][static_cast<std::size_t>(arrays_.b[i])]);
    }
  };
  each_end([](std::uint32_t, std::uint32_t& count) { ++count; });
  nodes_.clear();
  std::uint32_t place = 0;
  for (std::size_t node = 0; node < next_[0].size(); ++node) {
    const std::uint32_t beginning = next_[0][node], ending = next_[1][node];
    next_[0][node] = place;
    next_[1][node] = place + beginning;
    if (beginning + ending == 0) continue;
    nodes_.push_back(
        {static_cast<std::int32_t>(node), place, place + beginning, place + beginning + ending});
    place += beginning + ending;
  }
  each_end([&](std::uint32_t spring, std::uint32_t& next) { ends_[next++] = spring; });
}

void SpringTable::add_forces(std::span<const Vector4> position_m,
                             std::span<const Vector4> velocity_m_s, std::span<Vector4> forces_N,
                             const WorkSharing& sharing) {
  constexpr std::size_t kSpringsAPart = 4096, kNodesAPart = 2048;  // whole vectors
  sharing.for_each_chunk(used_, kSpringsAPart, [&](std::size_t first, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(PullSprings)
    (arrays_, first, end, position_m.data(), velocity_m_s.data(), pulls_N_.data());
  });
  sharing.for_each_chunk(nodes_.size(), kNodesAPart, [&](std::size_t first, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(SumPulls)
    (std::span(nodes_).subspan(first, end - first), ends_.data(), pulls_N_.data(), forces_N.data());
  });
}

}  // namespace stillgrid::dynamics
#endif
