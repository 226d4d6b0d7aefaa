#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "sim_server/mesh/triangle_mesh.hpp"

namespace stillgrid::mesh {

/// A grid of columns x rows points, each mesh of four made of two triangles, counter-clockwise when
/// columns go right and rows go up; closed in both directions where asked.
inline TriangleMesh woven(int columns, int rows, bool rows_close,
                          const std::function<Eigen::Vector3d(int, int)>& point_m) {
  TriangleMesh mesh;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) mesh.vertices_m.push_back(point_m(i, j));
  for (int j = 0; j < (rows_close ? rows : rows - 1); ++j)
    for (int i = 0; i < columns; ++i) {
      const int right = (i + 1) % columns, up = (j + 1) % rows;
      const int a = i + columns * j, b = right + columns * j, c = right + columns * up,
                d = i + columns * up;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

inline TriangleMesh torus_mesh(double ring_m, double tube_m, int around, int across) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return woven(around, across, true, [=](int i, int j) -> Eigen::Vector3d {
    const double u = kTurn * i / around, v = kTurn * j / across;
    const double from_axis_m = ring_m + tube_m * std::cos(v);
    return {from_axis_m * std::cos(u), from_axis_m * std::sin(u), tube_m * std::sin(v)};
  });
}

/// A surface of revolution about z, through (radius, z) pairs from below to above, closed by a
/// point at each end.
inline TriangleMesh turned_mesh(const std::vector<Eigen::Vector2d>& profile_m, int around,
                                double bottom_m, double top_m) {
  const int rows = static_cast<int>(profile_m.size());
  TriangleMesh mesh = woven(around, rows, false, [&](int i, int j) -> Eigen::Vector3d {
    const double u = 2.0 * std::numbers::pi * i / around;
    const Eigen::Vector2d& p = profile_m[static_cast<std::size_t>(j)];
    return {p.x() * std::cos(u), p.x() * std::sin(u), p.y()};
  });
  const int bottom = static_cast<int>(mesh.vertices_m.size()), top = bottom + 1;
  mesh.vertices_m.push_back({0.0, 0.0, bottom_m});
  mesh.vertices_m.push_back({0.0, 0.0, top_m});
  for (int i = 0; i < around; ++i) {
    const int next = (i + 1) % around, last = around * (rows - 1);
    mesh.triangles.push_back({bottom, next, i});
    mesh.triangles.push_back({top, last + i, last + next});
  }
  return mesh;
}

/// A rod of length_m between the centres of its round ends, along z; a ball if that is zero.
inline TriangleMesh capsule_mesh(double length_m, double radius_m, int around, int rows) {
  std::vector<Eigen::Vector2d> profile_m;
  for (int half = 0; half < 2; ++half)
    for (int j = 1; j <= rows; ++j) {
      if (half == 1 && j == 1 && length_m == 0.0) continue;
      const double angle =
          0.5 * std::numbers::pi * (half == 0 ? j - rows : j - 1.0) / static_cast<double>(rows);
      const double z_m = radius_m * std::sin(angle) + (half - 0.5) * length_m;
      profile_m.push_back({radius_m * std::cos(angle), z_m});
    }
  const double end_m = 0.5 * length_m + radius_m;
  return turned_mesh(profile_m, around, -end_m, end_m);
}

inline TriangleMesh ball_mesh(double radius_m, int around = 48, int rows = 12) {
  return capsule_mesh(0.0, radius_m, around, rows);
}

inline TriangleMesh box_mesh(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices_m.push_back(
        {(i & 1 ? high_m : low_m).x(), (i & 2 ? high_m : low_m).y(), (i & 4 ? high_m : low_m).z()});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

inline TriangleMesh cube_mesh() {
  return box_mesh({0, 0, 0}, {1, 1, 1});
}

inline TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const int first = static_cast<int>(a.vertices_m.size());
  a.vertices_m.insert(a.vertices_m.end(), b.vertices_m.begin(), b.vertices_m.end());
  for (const Eigen::Vector3i& t : b.triangles) a.triangles.push_back(t.array() + first);
  return a;
}

inline TriangleMesh inside_out(TriangleMesh mesh) {
  for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[0], t[1]);
  return mesh;
}

inline TriangleMesh moved(TriangleMesh mesh, const Eigen::Matrix3d& turn,
                          const Eigen::Vector3d& by_m) {
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex = turn * vertex + by_m;
  return mesh;
}

}  // namespace stillgrid::mesh
