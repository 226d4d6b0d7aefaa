#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <random>
#include <vector>

#include "shared/collision/still_grid.hpp"

namespace stillgrid {

/// Equal spheres strewn evenly in a cube, in such density that each overlaps 0.95 others, but at
/// the cube's faces. All of them move.
class SphereCloud {
 public:
  static constexpr double kRadius_m = 0.005;

  /// move_m: length of a step; the default is a twentieth of the radius.
  explicit SphereCloud(std::size_t count, unsigned seed = 1, double move_m = 0.05 * kRadius_m);

  /// Moves every sphere a step on, in a direction of its own; the cube's faces turn it back.
  void move();

  /// Writes the spheres as they are.
  void write_to(std::span<Cover> balls) const;

  /// Writes the spheres to a grid's records, as images n to n - 3 of a history a step apart.
  void write_to(std::span<proto::SphereRecord> records) const;

  [[nodiscard]] double edge_m() const noexcept { return edge_m_; }
  [[nodiscard]] std::size_t count() const noexcept { return positions_m_.size(); }
  [[nodiscard]] Eigen::Vector3d position_m(std::size_t i) const { return positions_m_[i]; }
  [[nodiscard]] Eigen::Vector3d velocity_m_s(std::size_t i) const;

  /// A place well inside.
  [[nodiscard]] Eigen::Vector3d place_within();

  /// One diameter, the paper's choice.
  [[nodiscard]] static constexpr float voxel_m() { return 2.0F * static_cast<float>(kRadius_m); }

 private:
  double edge_m_;
  std::mt19937 random_;
  std::vector<Eigen::Vector3d> positions_m_, steps_m_;
};

/// Reads and writes 64 MB, so that caches hold nothing of what a benchmark asks for next.
class CacheFlush {
 public:
  CacheFlush() : bytes_(64 << 20, 1) {}
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

}  // namespace stillgrid
