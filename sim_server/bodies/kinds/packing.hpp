#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

/// Spheres that cover a body: the largest distance between centres, and the radius. Zero means
/// "not given": completed() chooses it.
///
/// Centres are evenly spaced, and the first and the last are at the ends. A sheet has
/// ceil(length / spacing) + 1 spheres along each side, a thread as many along its length. A box,
/// rigid or soft, is filled with ceil((side - 2 radius) / spacing) + 1 spheres along each side.
/// Its outer spheres touch the faces. A side with one sphere has it in the middle.
struct SpherePacking {
  double spacing_m = 0.0;
  double radius_m = 0.0;
};

/// What a kind of body amounts to, known before it is made; doubles, for they may exceed every
/// integer.
struct BodyCounts {
  double spheres = 0.0;
  double nodes = 0.0;
  double springs = 0.0;      // about
  double field_bytes = 0.0;  // of its distance field, which is published once
};

/// A rigid body's resistance to turning, and how far it reaches.
struct RigidShape {
  Eigen::Vector3d inertia_kg_m2 = Eigen::Vector3d::Zero();  // principal, body frame
  double bounding_radius_m = 0.0;                           // farthest point from the centre
};

/// Reads `spheres`. Throws SceneError. Pre: longest_side_m is the body's.
[[nodiscard]] SpherePacking read_packing(toml::TableReader& table, double longest_side_m);

/// Returns the packing with both values set, the spacing at most the radius where one of them is
/// free: a lone spacing is also the radius, up to largest_radius_m, and a lone radius is also the
/// spacing. radius_m is the radius of a packing that has neither.
[[nodiscard]] SpherePacking completed(
    SpherePacking packing, double radius_m,
    double largest_radius_m = std::numeric_limits<double>::infinity());

/// Returns the completed packing of a box. The radius of a packing that has neither value is a
/// sixth of the longest side, at most a third of the shortest: at least two spheres along each
/// side.
[[nodiscard]] SpherePacking completed_for_box(const SpherePacking& packing,
                                              const Eigen::Vector3d& size_m);

/// Returns how many spheres stand along a length, ends included.
[[nodiscard]] double spheres_along(double length_m, double spacing_m);
[[nodiscard]] int count_along(double length_m, double spacing_m);

/// The i-th of n equal steps through [low, high]; the middle when there is one only.
[[nodiscard]] double spread(int i, int n, double low, double high);

/// A place among nodes in a row.
struct LinePoint {
  int lower;        // node below
  double fraction;  // towards the next
};
/// Where the i-th of `spheres` evenly spread along a row of nodes is.
[[nodiscard]] LinePoint among_nodes(int i, int spheres, int nodes);

/// Hangs a sphere on one node more. Pre: it has less than four.
void bind(SphereBinding& sphere, int node, double weight);

/// The balls that fill a box of the packing, in its frame.
[[nodiscard]] std::vector<spheres::Ball> balls_of_box(const Eigen::Vector3d& size_m,
                                                      const SpherePacking& packing);
[[nodiscard]] double ball_count_of_box(const Eigen::Vector3d& size_m, const SpherePacking& packing);

/// A ball of a body's frame as a sphere of the body that stands there, bound to nothing yet.
[[nodiscard]] SphereBinding placed_sphere(const spheres::Ball& ball,
                                          const Eigen::Vector3d& position_m,
                                          const Eigen::Quaterniond& orientation);

/// Balls of a body's frame as spheres fixed in a rigid body that stands there.
[[nodiscard]] std::vector<SphereBinding> fixed_spheres(std::span<const spheres::Ball> balls,
                                                       const Eigen::Vector3d& position_m,
                                                       const Eigen::Quaterniond& orientation);

}  // namespace stillgrid::bodies
