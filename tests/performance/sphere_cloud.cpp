#include "tests/performance/sphere_cloud.hpp"

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

namespace stillgrid {
namespace {

constexpr double kOverlaps = 0.95;

/// Edge of the cube in which `count` spheres have kOverlaps others within two radii each.
double edge_for(std::size_t count) {
  const double reach_m3 = 4.0 / 3.0 * std::numbers::pi * std::pow(2.0 * SphereCloud::kRadius_m, 3);
  return std::cbrt(static_cast<double>(count) * reach_m3 / kOverlaps);
}

}  // namespace

SphereCloud::SphereCloud(std::size_t count, unsigned seed, double move_m)
    : edge_m_(edge_for(count)), random_(seed) {
  std::uniform_real_distribution<double> place_m(-0.5 * edge_m_, 0.5 * edge_m_);
  std::normal_distribution<double> direction;
  for (std::size_t i = 0; i < count; ++i) {
    positions_m_.emplace_back(place_m(random_), place_m(random_), place_m(random_));
    const Eigen::Vector3d way(direction(random_), direction(random_), direction(random_));
    steps_m_.push_back(move_m * way.normalized());
  }
}

void SphereCloud::move() {
  for (std::size_t i = 0; i < positions_m_.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      double& x = positions_m_[i][axis];
      x += steps_m_[i][axis];
      if (std::abs(x) > 0.5 * edge_m_) steps_m_[i][axis] = std::copysign(steps_m_[i][axis], -x);
    }
}

void SphereCloud::write_to(std::span<Cover> balls) const {
  for (std::size_t i = 0; i < positions_m_.size(); ++i) {
    const Eigen::Vector3f p = positions_m_[i].cast<float>();
    balls[i] = {{p.x(), p.y(), p.z()}, static_cast<float>(kRadius_m)};
  }
}

void SphereCloud::write_to(std::span<proto::SphereRecord> records) const {
  for (std::size_t i = 0; i < positions_m_.size(); ++i) {
    const auto image = [&](int age) {
      const Eigen::Vector3f p = (positions_m_[i] - age * steps_m_[i]).cast<float>();
      const Eigen::Vector3f v = velocity_m_s(i).cast<float>();
      return proto::SphereImage{{p.x(), p.y(), p.z()}, {v.x(), v.y(), v.z()}};
    };
    records[i].newest = image(0);
    records[i].older = {image(1), image(2)};
    records[i].oldest_position_m = image(3).position_m;
    records[i].radius_m = static_cast<float>(kRadius_m);
  }
}

Eigen::Vector3d SphereCloud::velocity_m_s(std::size_t i) const {
  constexpr double kPeriod_s = 0.01;
  return steps_m_[i] / kPeriod_s;
}

Eigen::Vector3d SphereCloud::place_within() {
  std::uniform_real_distribution<double> place_m(-0.4 * edge_m_, 0.4 * edge_m_);
  return {place_m(random_), place_m(random_), place_m(random_)};
}

void CacheFlush::operator()() {
  for (std::size_t i = 0; i < bytes_.size(); i += 64) ++bytes_[i];
  benchmark::DoNotOptimize(bytes_.data());
  benchmark::ClobberMemory();
}

}  // namespace stillgrid
