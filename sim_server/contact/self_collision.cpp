#include "sim_server/contact/self_collision.hpp"

#include <algorithm>
#include <span>

namespace stillgrid::contact {
namespace {

/// Spheres whose gap at rest is less than this part of the smaller radius are neighbours.
constexpr double kNearGap = 0.5;

std::span<const int> nodes_of(const bodies::SphereBinding& sphere) {
  return {sphere.nodes.data(), static_cast<std::size_t>(sphere.node_count)};
}

}  // namespace

SelfCollision::SelfCollision(const bodies::World& world)
    : first_neighbour_(world.nodes.size() + 1, 0) {
  for (std::size_t i = 0; i < world.nodes.size(); ++i) first_neighbour_[i + 1] = 1;
  for (const bodies::Spring& spring : world.springs)
    for (const int node : {spring.a, spring.b})
      ++first_neighbour_[static_cast<std::size_t>(node) + 1];
  for (std::size_t i = 0; i < world.nodes.size(); ++i)
    first_neighbour_[i + 1] += first_neighbour_[i];

  neighbours_.resize(first_neighbour_.back());
  std::vector<std::size_t> next(first_neighbour_.begin(), first_neighbour_.end() - 1);
  const auto note = [&](int node, int other) {
    neighbours_[next[static_cast<std::size_t>(node)]++] = other;
  };
  for (std::size_t i = 0; i < world.nodes.size(); ++i)
    note(static_cast<int>(i), static_cast<int>(i));
  for (const bodies::Spring& spring : world.springs) {
    note(spring.a, spring.b);
    note(spring.b, spring.a);
  }
  const auto at = [&](std::size_t i) {
    return neighbours_.begin() + static_cast<std::ptrdiff_t>(first_neighbour_[i]);
  };
  for (std::size_t i = 0; i < world.nodes.size(); ++i) std::sort(at(i), at(i + 1));
}

bool SelfCollision::are_apart_at_rest(const bodies::SphereBinding& a,
                                      const bodies::SphereBinding& b) noexcept {
  const double near_m = a.radius_m + b.radius_m + kNearGap * std::min(a.radius_m, b.radius_m);
  return (a.rest_position_m - b.rest_position_m).squaredNorm() > near_m * near_m;
}

bool SelfCollision::are_joined(const bodies::SphereBinding& a,
                               const bodies::SphereBinding& b) const noexcept {
  for (const int node : nodes_of(a)) {
    const auto i = static_cast<std::size_t>(node);
    const std::span neighbours(neighbours_.data() + first_neighbour_[i],
                               first_neighbour_[i + 1] - first_neighbour_[i]);
    for (const int other : nodes_of(b))
      if (std::binary_search(neighbours.begin(), neighbours.end(), other)) return true;
  }
  return false;
}

}  // namespace stillgrid::contact
