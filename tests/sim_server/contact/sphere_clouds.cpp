#include "tests/sim_server/contact/sphere_clouds.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stillgrid::contact {
namespace {

constexpr float kRadius_m = 0.005F;

float extent_for(Cloud cloud, std::size_t count) {
  const auto n = static_cast<float>(count);
  switch (cloud) {
    case Cloud::kSheet:
      return 2.0F * kRadius_m * std::sqrt(n);
    case Cloud::kThread:
      return 1.5F * kRadius_m * n;
    case Cloud::kWide:
      return 1000.0F;
    case Cloud::kTwoDecades:
      return 60.0F * kRadius_m * std::cbrt(n);
    default:
      return 3.3F * kRadius_m * std::cbrt(n);  // 0.95 overlaps each
  }
}

bool overlap(const collision::SweptBound& a, const collision::SweptBound& b) {
  const float x = a.centre_m[0] - b.centre_m[0], y = a.centre_m[1] - b.centre_m[1],
              z = a.centre_m[2] - b.centre_m[2],
              bounding_radius_m = a.bounding_radius_m + b.bounding_radius_m;
  return x * x + y * y + z * z < bounding_radius_m * bounding_radius_m;
}

bool is_before(const SpherePair& p, const SpherePair& q) {
  return p.a != q.a ? p.a < q.a : p.b < q.b;
}

}  // namespace

DriftingCloud::DriftingCloud(Cloud cloud, Drift drift, std::size_t count, std::uint64_t seed)
    : cloud_(cloud), drift_(drift), seed_(seed), random_(seed), edge_m_(extent_for(cloud, count)) {
  if (cloud == Cloud::kFarAway) origin_m_ = {-1e6F, -3e5F, 1e6F};
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (std::size_t i = 0; i < count; ++i) {
    float radius_m = kRadius_m;
    if (cloud == Cloud::kTwoDecades) radius_m *= std::pow(10.0F, unit(random_));
    if (cloud == Cloud::kFarAway) radius_m *= 100.0F;  // floats are 0.06 m apart there
    balls_.push_back({anywhere(), radius_m});
    float speed_m = 0.0F;
    if (drift == Drift::kSlow) speed_m = 0.05F * radius_m;
    if (drift == Drift::kFast || (drift == Drift::kMixed && i % 50 == 0)) speed_m = 2.0F * radius_m;
    moves_m_.push_back({speed_m * unit(random_), speed_m * unit(random_), speed_m * unit(random_)});
  }
  home_ = balls_;
}

std::array<float, 3> DriftingCloud::anywhere() {
  std::uniform_real_distribution<float> place_m(-0.5F * edge_m_, 0.5F * edge_m_);
  std::array<float, 3> at_m{place_m(random_), place_m(random_), place_m(random_)};
  if (cloud_ == Cloud::kSheet) at_m[2] = 0.0F;
  if (cloud_ == Cloud::kThread) at_m[1] = at_m[2] = 0.5F * at_m[0];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (cloud_ == Cloud::kOnBorders) at_m[axis] = kRadius_m * std::round(at_m[axis] / kRadius_m);
    if (cloud_ == Cloud::kCoincident)
      at_m[axis] = 10.0F * kRadius_m * std::round(0.1F * at_m[axis] / kRadius_m);
    at_m[axis] += origin_m_[axis];
  }
  return at_m;
}

void DriftingCloud::step() {
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::uniform_int_distribution<int> chance(0, 99);
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    if (drift_ == Drift::kTeleport && chance(random_) < 2) balls_[i].centre_m = anywhere();
    if (drift_ == Drift::kSlow && chance(random_) < 1)
      for (float& move_m : moves_m_[i]) move_m = -move_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float& x_m = balls_[i].centre_m[axis];
      if (drift_ == Drift::kTrembling)
        x_m = home_[i].centre_m[axis] + 0.004F * balls_[i].bounding_radius_m * unit(random_);
      else
        x_m += moves_m_[i][axis];
    }
  }
}

std::string DriftingCloud::description() const {
  return "cloud " + std::to_string(static_cast<int>(cloud_)) + ", drift " +
         std::to_string(static_cast<int>(drift_)) + ", " + std::to_string(balls_.size()) +
         " spheres, seed " + std::to_string(seed_);
}

std::vector<SpherePair> tested_pairs(std::span<const collision::SweptBound> balls) {
  std::vector<std::uint32_t> order(balls.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto low_m = [&](std::uint32_t i) {
    return balls[i].centre_m[0] - balls[i].bounding_radius_m;
  };
  const bool sweep = balls.size() > 1000;
  if (sweep)
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t i, std::uint32_t j) { return low_m(i) < low_m(j); });
  std::vector<SpherePair> pairs;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::uint32_t i = order[k];
    const float high_m = balls[i].centre_m[0] + 1.0001F * balls[i].bounding_radius_m;
    for (std::size_t l = k + 1; l < order.size(); ++l) {
      const std::uint32_t j = order[l];
      if (sweep && low_m(j) > high_m) break;
      if (overlap(balls[i], balls[j])) pairs.push_back({std::min(i, j), std::max(i, j)});
    }
  }
  return ascending(pairs);
}

std::vector<SpherePair> ascending(std::span<const SpherePair> pairs) {
  std::vector<SpherePair> sorted(pairs.begin(), pairs.end());
  std::sort(sorted.begin(), sorted.end(), is_before);
  return sorted;
}

}  // namespace stillgrid::contact
