#include "tests/performance/sphere_cloud.hpp"

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

namespace stillgrid::performance {
namespace {

constexpr double kPairs = 0.95;  // that overlap, a sphere

/// Edge of the cube in which `count` spheres overlap 2 kPairs others each. The mean of (a + b)^3 is
/// 9 R^3: 2^3 of equal ones, and 3 * 2 times the sum's variance of 2 / 12.
double edge_for(std::size_t count) {
  const double bounding_volume_m3 =
      4.0 / 3.0 * std::numbers::pi * 9.0 * std::pow(SphereCloud::kRadius_m, 3);
  return std::cbrt(static_cast<double>(count) * bounding_volume_m3 / (2.0 * kPairs));
}

/// "32768K" as the kernel writes it; 0 if it is not there.
std::size_t kernel_cache_bytes(int index) {
  std::ifstream file("/sys/devices/system/cpu/cpu0/cache/index" + std::to_string(index) + "/size");
  std::size_t size = 0;
  char unit = ' ';
  if (!(file >> size)) return 0;
  file >> unit;
  return unit == 'K' ? size << 10 : unit == 'M' ? size << 20 : size;
}

}  // namespace

SphereCloud::SphereCloud(std::size_t count, unsigned seed, double move_m)
    : edge_m_(edge_for(count)), random_(seed) {
  std::uniform_real_distribution<double> place_m(-0.5 * edge_m_, 0.5 * edge_m_);
  std::uniform_real_distribution<double> radius_m(0.5 * kRadius_m, kLargest_m);
  std::normal_distribution<double> direction;
  for (std::size_t i = 0; i < count; ++i) {
    radii_m_.push_back(static_cast<float>(radius_m(random_)));
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

void SphereCloud::write_to(std::span<collision::SweptBound> balls) const {
  for (std::size_t i = 0; i < positions_m_.size(); ++i) {
    const Eigen::Vector3f p = positions_m_[i].cast<float>();
    balls[i] = {{p.x(), p.y(), p.z()}, radii_m_[i]};
  }
}

void SphereCloud::write_to(std::span<proto::SphereRecord> records) const {
  for (std::size_t i = 0; i < positions_m_.size(); ++i) {
    const auto snapshot = [&](int age) {
      const Eigen::Vector3f p = (positions_m_[i] - age * steps_m_[i]).cast<float>();
      const Eigen::Vector3f v = velocity_m_s(i).cast<float>();
      return proto::SphereState{{p.x(), p.y(), p.z()}, {v.x(), v.y(), v.z()}};
    };
    records[i].newest = snapshot(0);
    records[i].before = snapshot(1);
    records[i].radius_m = radii_m_[i];
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

std::size_t last_cache_bytes() {
  std::size_t most = 0;
  for (int index = 0; index < 8; ++index) most = std::max(most, kernel_cache_bytes(index));
  for (const int name : {_SC_LEVEL2_CACHE_SIZE, _SC_LEVEL3_CACHE_SIZE, _SC_LEVEL4_CACHE_SIZE})
    most = std::max(most, static_cast<std::size_t>(std::max(0L, ::sysconf(name))));
  return most > 0 ? most : std::size_t{64} << 20;
}

void CacheFlush::operator()() {
  for (std::size_t i = 0; i < bytes_.size(); i += 64) ++bytes_[i];
  benchmark::DoNotOptimize(bytes_.data());
  benchmark::ClobberMemory();
}

}  // namespace stillgrid::performance
