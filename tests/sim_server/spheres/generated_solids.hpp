#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "tests/sim_server/mesh/solids.hpp"

namespace stillgrid::spheres {

/// A slab whose top is a sum of waves over a grid of columns x rows cells of 1 m; its bottom is
/// bottom_m. Waves that reach below that make it cut itself.
inline mesh::TriangleMesh slab_mesh(unsigned seed, int columns, int rows, double wave_m,
                                    double bottom_m) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  struct Wave {
    double height_m, along_x, along_y, phase;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 6; ++i)
    waves.push_back({between(0.25, 1.0) * wave_m, between(0.05, 0.45), between(0.05, 0.45),
                     between(0.0, 2.0 * std::numbers::pi)});
  const int nx = columns + 1, ny = rows + 1;
  mesh::TriangleMesh mesh;
  for (int top = 0; top < 2; ++top)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        double z_m = bottom_m;
        if (top == 1) {
          z_m = 0.0;
          for (const Wave& wave : waves)
            z_m += wave.height_m * std::sin(wave.along_x * i + wave.along_y * j + wave.phase);
        }
        mesh.vertices_m.emplace_back(i, j, z_m);
      }
  const auto at = [=](int i, int j, int top) { return (top * ny + j) * nx + i; };
  const auto quad = [&](int a, int b, int c, int d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      quad(at(i, j, 1), at(i + 1, j, 1), at(i + 1, j + 1, 1), at(i, j + 1, 1));
      quad(at(i, j, 0), at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0));
    }
  for (int i = 0; i < columns; ++i) {
    quad(at(i, 0, 0), at(i + 1, 0, 0), at(i + 1, 0, 1), at(i, 0, 1));
    quad(at(i + 1, rows, 0), at(i, rows, 0), at(i, rows, 1), at(i + 1, rows, 1));
  }
  for (int j = 0; j < rows; ++j) {
    quad(at(0, j + 1, 0), at(0, j, 0), at(0, j, 1), at(0, j + 1, 1));
    quad(at(columns, j, 0), at(columns, j + 1, 0), at(columns, j + 1, 1), at(columns, j, 1));
  }
  return mesh;
}

/// A ball of 1 m whose every vertex is moved along its ray by up to `rough` of its length: seen
/// whole from its centre.
inline mesh::TriangleMesh star_mesh(unsigned seed, double rough, int around = 14, int rows = 5) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> length(1.0 - rough, 1.0 + rough);
  mesh::TriangleMesh mesh = mesh::ball_mesh(1.0, around, rows);
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex *= length(random);
  return mesh;
}

/// A box with sides from thin to long, turned and moved anyhow.
inline mesh::TriangleMesh random_box(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> power(-1.0, 0.0), angle(0.0, 6.0);
  const Eigen::Vector3d high_m(std::pow(10.0, power(random)), std::pow(10.0, power(random)), 1.0);
  const Eigen::Vector3d axis(angle(random), angle(random), angle(random) + 1.0);
  return mesh::moved(mesh::box_mesh(Eigen::Vector3d::Zero(), high_m),
                     Eigen::AngleAxisd(angle(random), axis.normalized()).toRotationMatrix(),
                     Eigen::Vector3d(angle(random), angle(random), angle(random)));
}

}  // namespace stillgrid::spheres
