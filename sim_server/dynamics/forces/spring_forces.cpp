#include "sim_server/dynamics/forces/spring_forces.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/dynamics/forces/spring_forces.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#include "sim_server/dynamics/forces/sheet_forces.hpp"
#include "sim_server/dynamics/forces/spring_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

using ConstRow = contact::VectorRow<const double>;

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
double PullGroup(const SpringGroup& group, const SpringNodes& nodes) {
  const FourTag d;  // as wide as what stores before it, or a load would wait until they are done
  using Four = hn::Vec<FourTag>;
  const ConstRow stiffness(group.stiffness_N_per_m.data(), group.stiffness_N_per_m);
  const ConstRow pushes(group.push_N.data(), group.push_N);
  const ConstRow dampings(group.damping_N_s_per_m.data(), group.damping_N_s_per_m);
  PackedVector lines[contact::kLanes], speeds[contact::kLanes];
  Look pulls;
  Four power = hn::Zero(d);
  for (std::size_t i = 0; i < group.a.size(); i += contact::kLanes) {
    for (std::size_t k = 0; k < contact::kLanes; ++k) {
      const std::size_t a = group.a[i + k], b = group.b[i + k];
      Difference(nodes.position_m[b], nodes.position_m[a], lines[k]);
      if (damped) Difference(nodes.velocity_m_s[b], nodes.velocity_m_s[a], speeds[k]);
    }
    for (std::size_t k = 0; k < contact::kLanes; k += hn::Lanes(d)) {
      Four x, y, z, zero;
      hn::LoadInterleaved4(d, &lines[k].x, x, y, z, zero);
      const Four square = Dot(x, y, z, x, y, z, hn::Set(d, kShortest_m2));
      Four along = zero, c = zero;
      if (damped) {
        Four v_x, v_y, v_z;
        hn::LoadInterleaved4(d, &speeds[k].x, v_x, v_y, v_z, zero);
        along = Dot(x, y, z, v_x, v_y, v_z, zero);
        c = hn::LoadU(d, dampings.at(i + k));
      }
      const Four push = hn::LoadU(d, pushes.at(i + k));
      hn::Store(Pull<damped>(d, square, along, hn::LoadU(d, stiffness.at(i + k)), push, c, power),
                d, pulls.lanes + k);
    }
    for (std::size_t k = 0; k < contact::kLanes; ++k)
      AddForce(pulls.lanes[k], lines[k], nodes.force_N[group.a[i + k]],
               nodes.force_N[group.b[i + k]]);
  }
  return hn::GetLane(hn::SumOfLanes(d, power));
}

double PullAnyGroup(const SpringGroup& group, const SpringNodes& nodes) {
  return group.damped ? PullGroup<true>(group, nodes) : PullGroup<false>(group, nodes);
}

/// kicks, drifts: for longer than zero.
template <bool kicks, bool drifts>
HWY_INLINE void MoveNodes(const Move& move, const PackedVector& gravity_m_s2, NodeRange nodes,
                          ExplicitState& state) {
  const FourTag d;
  using Four = hn::Vec<FourTag>;
  const Four kick = hn::Set(d, move.kick_s), drift = hn::Set(d, move.drift_s);
  for (std::size_t i = nodes.first; i < nodes.last; ++i) {
    const Four inverse_mass = hn::Set(d, state.inverse_mass_per_kg[i]);
    PackedVector &position = state.position_m[i], &velocity = state.velocity_m_s[i];
    for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) {
      Four v = hn::Load(d, Part(velocity, k));
      if constexpr (kicks) {
        v = Kicked(d, inverse_mass, hn::Load(d, Part(state.force_N[i], k)),
                   hn::Load(d, Part(gravity_m_s2, k)), kick, v);
        hn::Store(v, d, Part(velocity, k));
      }
      if constexpr (drifts)
        hn::Store(Drifted(d, inverse_mass, v, drift, hn::Load(d, Part(position, k))), d,
                  Part(position, k));
    }
  }
}

void MoveRange(const Move& move, const PackedVector& gravity_m_s2, NodeRange nodes,
               ExplicitState& state) {
  if (move.drift_s == 0.0) return MoveNodes<true, false>(move, gravity_m_s2, nodes, state);
  if (move.kick_s == 0.0) return MoveNodes<false, true>(move, gravity_m_s2, nodes, state);
  MoveNodes<true, true>(move, gravity_m_s2, nodes, state);
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {
namespace {
HWY_EXPORT(PullAnyGroup);
HWY_EXPORT(MoveRange);

void move_range(const Move& move, const Eigen::Vector3d& gravity_m_s2, NodeRange nodes,
                ExplicitState& state) {
  const PackedVector gravity{gravity_m_s2.x(), gravity_m_s2.y(), gravity_m_s2.z()};
  HWY_DYNAMIC_DISPATCH(MoveRange)(move, gravity, nodes, state);
}

SpringNodes nodes_of(ExplicitState& state) {
  return {state.position_m.data(), state.velocity_m_s.data(), state.force_N.data()};
}

}  // namespace

SpringForces::SpringForces(const bodies::World& world) {
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (world.bodies[i].node_count == 0) continue;
    if (std::optional<SpringSheet> sheet = sheet_of(world, i)) {
      sheets_.push_back(std::move(*sheet));
      continue;
    }
    groups_.push_back(group_of(world, i));
    const auto first = static_cast<std::size_t>(world.bodies[i].first_node);
    if (in_groups_.empty() || in_groups_.back().last != first) in_groups_.push_back({first, first});
    in_groups_.back().last += static_cast<std::size_t>(world.bodies[i].node_count);
  }
}

double SpringForces::evaluate(const bodies::World& world, ExplicitState& state) {
  const SpringNodes nodes = nodes_of(state);
  double power_W = 0.0;
  for (SpringSheet& sheet : sheets_)
    if (!world.bodies[sheet.body].is_sleeping) power_W += pull_sheet(sheet, nodes);
  return power_W + pull_groups(world, nodes);
}

double SpringForces::pull_groups(const bodies::World& world, const SpringNodes& nodes) {
  double power_W = 0.0;
  for (const SpringGroup& group : groups_) {
    const bodies::BodyRange& body = world.bodies[group.body];
    if (body.is_sleeping) continue;
    std::fill_n(nodes.force_N + body.first_node, body.node_count, PackedVector{});
    power_W += HWY_DYNAMIC_DISPATCH(PullAnyGroup)(group, nodes);
  }
  return power_W;
}

void SpringForces::take(const bodies::World& world, const ExplicitState& state) {
  for (SpringSheet& sheet : sheets_)
    if (!world.bodies[sheet.body].is_sleeping) take_nodes(state, sheet);
}

double SpringForces::move(const bodies::World& world, const Move& move, ExplicitState& state) {
  double power_W = 0.0;
  for (SpringSheet& sheet : sheets_)
    if (!world.bodies[sheet.body].is_sleeping)
      power_W += move_sheet(sheet, move, world.gravity_m_s2);
  power_W += pull_groups(world, nodes_of(state));
  for (const NodeRange& nodes : in_groups_) move_range(move, world.gravity_m_s2, nodes, state);
  return power_W;
}

void SpringForces::give(const bodies::World& world, ExplicitState& state) {
  for (SpringSheet& sheet : sheets_)
    if (!world.bodies[sheet.body].is_sleeping) give_nodes(sheet, state);
}

void move_nodes(const Move& move, const Eigen::Vector3d& gravity_m_s2, ExplicitState& state) {
  move_range(move, gravity_m_s2, {0, state.position_m.size()}, state);
}

}  // namespace stillgrid::dynamics
#endif
