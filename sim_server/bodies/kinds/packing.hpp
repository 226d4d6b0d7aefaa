#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

/// Spheres that cover a body: a distance between centres and a radius; zero means "chosen
/// for the body".
///
/// Centres are evenly spaced, the first and the last at the ends, so the spacing is met only
/// nearly. A sheet has round(length / spacing) + 1 of them along each side, a thread as many
/// along its length. A box, rigid or soft, is filled, with round((side - 2 radius) / spacing)
/// + 1 along each side, and its outer spheres touch the faces; along a side with one sphere it
/// is in the middle.
struct SpherePacking {
  double spacing_m = 0.0;
  double radius_m = 0.0;
};

/// What a kind of body amounts to, known before it is made; doubles, for they may exceed every
/// integer.
struct BodyCounts {
  double spheres = 0.0;
  double nodes = 0.0;
  double springs = 0.0;         // about
  double factor_entries = 0.0;  // of its Jacobian's factor, by nested dissection
  double field_bytes = 0.0;     // of its distance field, which is published once
};

/// A rigid body's resistance to turning, and how far it reaches.
struct RigidShape {
  Eigen::Vector3d inertia_kg_m2 = Eigen::Vector3d::Zero();  // principal, body frame
  double bounding_radius_m = 0.0;                           // farthest point from the centre
};

/// Reads `spheres`. Throws SceneError. Pre: longest_side_m is the body's.
[[nodiscard]] SpherePacking read_packing(toml::TableReader& table, double longest_side_m);

/// The packing, with what it leaves open chosen: a spacing, and a radius as a part of the spacing.
[[nodiscard]] SpherePacking completed(SpherePacking packing, double spacing_m,
                                      double radius_per_spacing);

/// Spheres along a length, ends included.
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
