#include "sim_server/dynamics/contacts/contact_movers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stillgrid::dynamics {
namespace {

using Eigen::Vector3d;

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

void ContactMovers::clear(std::size_t spheres, const ExplicitState& state) {
  point_of_.resize(spheres);
  rigid_mover_.resize(state.rigid.size(), -1);
  node_mover_.resize(state.position_m.size(), -1);
  for (const Entry& entry : entries_)
    (entry.is_rigid ? rigid_mover_ : node_mover_)[at(entry.index)] = -1;
  entries_.clear();
  parent_.clear();
}

int ContactMovers::enter(const ContactSphere& sphere, int with, const ExplicitState& state) {
  if (sphere.rigid >= 0) return enter({sphere.rigid, true}, rigid_mover_[at(sphere.rigid)], with);
  const bodies::SphereBinding& binding = *sphere.binding;
  if (binding.rigid >= 0) return with;
  for (std::size_t i = 0; i < at(binding.node_count); ++i)
    if (state.inverse_mass_per_kg[at(binding.nodes[i])] > 0.0)
      with = enter({binding.nodes[i], false}, node_mover_[at(binding.nodes[i])], with);
  return with;
}

int ContactMovers::enter(Entry entry, int& number, int with) {
  if (number < 0) {
    number = static_cast<int>(entries_.size());
    entries_.push_back(entry);
    parent_.push_back(number);
  }
  if (with >= 0) parent_[at(root(with))] = root(number);
  return number;
}

int ContactMovers::root(int entry) {
  while (parent_[at(entry)] != entry) entry = parent_[at(entry)] = parent_[at(parent_[at(entry)])];
  return entry;
}

void ContactMovers::divide(std::span<const int> touched, std::vector<std::size_t>& place_of) {
  // Counts first, then where each island begins, then each in its place, in the order of touches.
  islands_.clear();
  island_of_.assign(entries_.size(), -1);
  place_of.clear();
  for (const int entry : touched) {
    int own = -1;
    int& island = entry < 0 ? own : island_of_[at(root(entry))];
    if (island < 0) {
      island = static_cast<int>(islands_.size());
      islands_.emplace_back();
    }
    ++islands_[at(island)].touches.last;
    place_of.push_back(at(island));
  }
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    island_of_[i] = island_of_[at(root(static_cast<int>(i)))];
    ContactIsland& island = islands_[at(island_of_[i])];
    ++(entries_[i].is_rigid ? island.rigid : island.nodes).last;
  }
  ContactIsland end;
  const auto begin_at = [](ContactIsland::Range& range, std::size_t& from) {
    range.first = from;
    from += range.last;
    range.last = range.first;
  };
  std::size_t chunks = 0;
  for (ContactIsland& island : islands_) {
    const std::size_t rigid = island.rigid.last, nodes = island.nodes.last;
    begin_at(island.touches, end.touches.first);
    begin_at(island.rigid, end.rigid.first);
    begin_at(island.nodes, end.nodes.first);
    island.first_chunk = chunks;
    chunks += Workers::chunks_of(rigid, kMoversAChunk) + Workers::chunks_of(nodes, kMoversAChunk);
  }
  for (std::size_t& place : place_of) place = islands_[place].touches.last++;
  residuals_.resize(chunks);
  bounds_.resize(chunks);
  rigid_movers_.resize(end.rigid.first);
  rigid_responses_.resize(end.rigid.first);
  node_movers_.resize(end.nodes.first);
  node_responses_.resize(end.nodes.first);
  node_impulse_N_s_.assign(node_movers_.size(), {});
  soft_.clear();
  std::fill(point_of_.begin(), point_of_.end(), 0);
  velocities_.assign(1 + rigid_movers_.size(), {});
  impulses_.assign(1 + rigid_movers_.size(), {});
  // In the order of bodies and nodes, or what touches would be far apart in memory.
  const auto number = [&](std::vector<int>& mover_of, auto range, const auto& begin) {
    for (std::size_t i = 0; i < mover_of.size(); ++i) {
      if (mover_of[i] < 0) continue;
      const std::size_t place = (islands_[at(island_of_[at(mover_of[i])])].*range).last++;
      mover_of[i] = static_cast<int>(place);
      begin(place, static_cast<int>(i));
    }
  };
  number(rigid_mover_, &ContactIsland::rigid,
         [&](std::size_t place, int rigid) { rigid_movers_[place].rigid = rigid; });
  number(node_mover_, &ContactIsland::nodes,
         [&](std::size_t place, int node) { node_movers_[place].node = node; });
}

int ContactMovers::point_of(int place, const ContactSphere& sphere) {
  if (sphere.rigid >= 0) return 1 + rigid_mover_[at(sphere.rigid)];
  const bodies::SphereBinding& binding = *sphere.binding;
  if (binding.rigid >= 0 || binding.node_count == 0) return 0;
  int& point = point_of_[at(place)];
  if (point == 0) {
    point = static_cast<int>(velocities_.size());
    velocities_.emplace_back();
    impulses_.emplace_back();
    SoftPoint& soft = soft_.emplace_back();
    soft.node_count = binding.node_count;
    soft.nodes = binding.nodes;
    soft.weights = binding.weights;
    for (std::size_t i = 0; i < at(binding.node_count); ++i) {
      const int mover = node_mover_[at(binding.nodes[i])];
      soft.movers[i] = mover >= 0 ? mover : static_cast<int>(node_movers_.size());
    }
    islands_[island_].soft.last = soft_.size();
  }
  return point;
}

void ContactMovers::begin_island(std::size_t island) {
  island_ = island;
  islands_[island].soft.first = islands_[island].soft.last = soft_.size();
}

void ContactMovers::note_sides(std::span<const ContactRows> rows) {
  const auto for_each_side = [&](const auto& visit) {
    for (std::size_t lane = 0; lane < rows.size() * ContactRows::kLanes; ++lane) {
      const ContactRows& own = rows[lane / ContactRows::kLanes];
      const std::size_t i = lane % ContactRows::kLanes;
      if (own.a[i] > 0) visit(at(own.a[i]), TouchSide{static_cast<std::uint32_t>(lane), false});
      if (own.b[i] > 0) visit(at(own.b[i]), TouchSide{static_cast<std::uint32_t>(lane), true});
    }
  };
  // Counts first, then where each point's begin, then each in its place.
  first_side_.assign(velocities_.size() + 1, 0);
  for_each_side([&](std::size_t point, TouchSide) { ++first_side_[point]; });
  std::uint32_t sides = 0;
  for (std::uint32_t& first : first_side_) first = std::exchange(sides, sides + first);
  sides_.resize(sides);
  for_each_side([&](std::size_t point, TouchSide side) { sides_[first_side_[point]++] = side; });
  for (std::size_t i = first_side_.size(); i-- > 1;) first_side_[i] = first_side_[i - 1];
  first_side_[0] = 0;
}

double ContactMovers::weight_sum(const ContactSphere& sphere) {
  if (sphere.rigid >= 0) return 1.0;
  const bodies::SphereBinding& binding = *sphere.binding;
  double sum = 0.0;
  for (std::size_t i = 0; binding.rigid < 0 && i < at(binding.node_count); ++i)
    sum += std::abs(binding.weights[i]);
  return sum;
}

}  // namespace stillgrid::dynamics
