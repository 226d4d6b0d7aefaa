#include "sim_server/spheres/ball_tree.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace stillgrid::spheres {

BallTree::BallTree(std::span<const Ball> balls) : balls_(balls), order_(balls.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  build(0, static_cast<std::uint32_t>(order_.size()));
}

void BallTree::build(std::uint32_t begin, std::uint32_t end) {
  constexpr std::uint32_t kLeaf = 8;
  const std::size_t place = nodes_.size();
  Node node{balls_[order_[begin]].centre_m, balls_[order_[begin]].centre_m, 0.0, begin, end, 0};
  for (std::uint32_t i = begin; i < end; ++i) {
    const Ball& ball = balls_[order_[i]];
    node.low_m = node.low_m.cwiseMin(ball.centre_m);
    node.high_m = node.high_m.cwiseMax(ball.centre_m);
    node.widest_m = std::max(node.widest_m, ball.radius_m);
  }
  nodes_.push_back(node);
  if (end - begin <= kLeaf) return;
  int axis = 0;
  (node.high_m - node.low_m).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::uint32_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return balls_[a].centre_m[axis] < balls_[b].centre_m[axis];
  });
  build(begin, middle);
  nodes_[place].right = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end);
}

double BallTree::least_possible_m(const Node& node, const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d outside_m =
      (node.low_m - point_m).cwiseMax(point_m - node.high_m).cwiseMax(0.0);
  return outside_m.norm() - node.widest_m;
}

double BallTree::gap_m(std::uint32_t ball, const Eigen::Vector3d& point_m) const {
  return (point_m - balls_[ball].centre_m).norm() - balls_[ball].radius_m;
}

double BallTree::least_gap_m(const Eigen::Vector3d& point_m) const {
  double least_m = std::numeric_limits<double>::infinity();
  std::vector<std::uint32_t> stack = {0};
  while (!stack.empty()) {
    const std::uint32_t place = stack.back();
    const Node& node = nodes_[place];
    stack.pop_back();
    if (least_possible_m(node, point_m) >= least_m) continue;
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        least_m = std::min(least_m, gap_m(order_[i], point_m));
      continue;
    }
    std::uint32_t nearer = place + 1, farther = node.right;
    if (least_possible_m(nodes_[farther], point_m) < least_possible_m(nodes_[nearer], point_m))
      std::swap(nearer, farther);
    stack.push_back(farther);
    stack.push_back(nearer);
  }
  return least_m;
}

std::vector<std::uint32_t> BallTree::balls_within(const Eigen::Vector3d& point_m,
                                                  double search_radius_m) const {
  std::vector<std::uint32_t> found, stack = {0};
  while (!stack.empty()) {
    const std::uint32_t place = stack.back();
    const Node& node = nodes_[place];
    stack.pop_back();
    if (least_possible_m(node, point_m) > search_radius_m) continue;
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        if (gap_m(order_[i], point_m) <= search_radius_m) found.push_back(order_[i]);
    } else {
      stack.push_back(node.right);
      stack.push_back(place + 1);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace stillgrid::spheres
