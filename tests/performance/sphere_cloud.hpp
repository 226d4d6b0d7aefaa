#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <random>
#include <vector>

#include "shared/collision/voxel_grid.hpp"

namespace stillgrid::performance {

/// Spheres strewn evenly in a cube, in such density that 0.95 pairs a sphere overlap, but at the
/// cube's faces. Their radii are spread evenly from half to one and a half of kRadius_m. All move.
class SphereCloud {
 public:
  static constexpr double kRadius_m = 0.005;  // the mean
  static constexpr double kLargest_m = 1.5 * kRadius_m;

  /// move_m: length of a step; the default is a twentieth of the radius.
  explicit SphereCloud(std::size_t count, unsigned seed = 1, double move_m = 0.05 * kRadius_m);

  /// Moves every sphere a step on, in a direction of its own; the cube's faces turn it back.
  void move();

  /// Writes the spheres as they are.
  void write_to(std::span<collision::SweptBound> balls) const;

  /// Writes the spheres to a grid's records, as snapshots n to n - 3 of a history a step apart.
  void write_to(std::span<proto::SphereRecord> records) const;

  [[nodiscard]] double edge_m() const noexcept { return edge_m_; }
  [[nodiscard]] std::size_t count() const noexcept { return positions_m_.size(); }
  [[nodiscard]] Eigen::Vector3d position_m(std::size_t i) const { return positions_m_[i]; }
  [[nodiscard]] float radius_m(std::size_t i) const { return radii_m_[i]; }
  [[nodiscard]] Eigen::Vector3d velocity_m_s(std::size_t i) const;

  /// A place well inside.
  [[nodiscard]] Eigen::Vector3d place_within();

  /// One mean diameter, the paper's choice for equal ones.
  [[nodiscard]] static constexpr float voxel_m() { return 2.0F * static_cast<float>(kRadius_m); }

 private:
  double edge_m_;
  std::mt19937 random_;
  std::vector<Eigen::Vector3d> positions_m_, steps_m_;
  std::vector<float> radii_m_;
};

/// The last cache of this machine, bytes: the largest that the kernel or the processor tells of;
/// 64 MB where neither does.
[[nodiscard]] std::size_t last_cache_bytes();

/// Reads and writes as much as the last cache holds and a quarter more, so that caches hold nothing
/// of what a benchmark asks for next.
class CacheFlush {
 public:
  CacheFlush() : bytes_(last_cache_bytes() / 4 * 5, 1) {}
  void operator()();

 private:
  std::vector<unsigned char> bytes_;
};

/// Seconds that a call takes.
template <class Call>
double seconds_of(Call&& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace stillgrid::performance
