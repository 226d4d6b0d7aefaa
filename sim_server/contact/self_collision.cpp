#include "sim_server/contact/self_collision.hpp"

#include <algorithm>
#include <numeric>
#include <span>

namespace stillgrid::contact {
namespace {

/// Spheres whose gap at rest is less than this part of the smaller radius are neighbours.
constexpr double kNearGap = 0.5;

/// Pairs of spheres of a body that are near at rest, by sorting along an axis.
template <class Visit>
void each_pair_near_at_rest(std::span<const bodies::SphereBinding> spheres, const Visit& visit) {
  std::vector<int> order(spheres.size());
  std::iota(order.begin(), order.end(), 0);
  const auto sphere = [&](int i) -> const bodies::SphereBinding& {
    return spheres[static_cast<std::size_t>(i)];
  };
  std::ranges::sort(order, {}, [&](int i) { return sphere(i).rest_position_m.x(); });
  double most_m = 0.0;
  for (const bodies::SphereBinding& one : spheres) most_m = std::max(most_m, one.radius_m);
  const double distance_m = (2.0 + kNearGap) * most_m;
  for (std::size_t k = 0; k < order.size(); ++k)
    for (std::size_t l = k + 1; l < order.size(); ++l) {
      const Eigen::Vector3d apart_m =
          sphere(order[l]).rest_position_m - sphere(order[k]).rest_position_m;
      if (apart_m.x() > distance_m) break;
      if (apart_m.squaredNorm() <= distance_m * distance_m) visit(order[k], order[l]);
    }
}

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

std::vector<std::pair<int, int>> SelfCollision::apart_spheres(const bodies::World& world) const {
  std::vector<std::vector<int>> spheres_of(world.nodes.size());
  for (int i = 0; i < static_cast<int>(world.spheres.size()); ++i)
    for (const int node : nodes_of(world.spheres[static_cast<std::size_t>(i)]))
      spheres_of[static_cast<std::size_t>(node)].push_back(i);
  std::vector<std::pair<int, int>> pairs;
  for (const bodies::BodyRange& body : world.bodies) {
    if (body.rigid >= 0) continue;
    const auto first = static_cast<std::size_t>(body.first_sphere);
    each_pair_near_at_rest(
        std::span(world.spheres).subspan(first, static_cast<std::size_t>(body.sphere_count)),
        [&](int i, int j) {
          const auto [a, b] = std::minmax(i, j);
          if (!may_collide(world.spheres[first + static_cast<std::size_t>(a)],
                           world.spheres[first + static_cast<std::size_t>(b)]))
            pairs.emplace_back(body.first_sphere + a, body.first_sphere + b);
        });
  }
  // Joined ones need not be near at rest.
  for (std::size_t i = 0; i < world.nodes.size(); ++i)
    for (std::size_t k = first_neighbour_[i]; k < first_neighbour_[i + 1]; ++k)
      for (const int a : spheres_of[i])
        for (const int b : spheres_of[static_cast<std::size_t>(neighbours_[k])])
          if (a < b) pairs.emplace_back(a, b);
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
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
