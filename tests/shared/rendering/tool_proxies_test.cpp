// The laws of the tool's contact, over generated covers, paths and places.
#include "shared/rendering/tool_proxies.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "tests/sanitizer_cut.hpp"

namespace stillgrid::rendering::tool_proxies_test {
namespace {

using Catch::Detail::Approx;
using Eigen::Vector3d;

constexpr double kStiffness_N_per_m = 500.0, kTool_m = 0.005, kTick_s = 1e-3;

/// A tool of one sphere among static spheres and planes, tick by tick.
class Probe {
 public:
  explicit Probe(double friction = 0.0) {
    scene_.material_count = 1;
    scene_.materials[0] = {static_cast<float>(kStiffness_N_per_m), 0.0F,
                           static_cast<float>(friction), 1e-3F};
    scene_.tool_sphere_count = 1;
    scene_.tool[0].radius_m = static_cast<float>(kTool_m);
  }
  void add_sphere(const Vector3d& centre_m, double radius_m) {
    spheres_.push_back({.position_m = centre_m,
                        .velocity_m_s = Vector3d::Zero(),
                        .radius_m = radius_m,
                        .material = 0,
                        .tool_sphere = 0,
                        .is_static = true});
  }
  void bear(float crushing_force_N) {
    for (TouchedSphere& sphere : spheres_) sphere.crushing_force_N = crushing_force_N;
  }
  void add_plane(const Vector3d& normal, double offset_m) {
    const Eigen::Vector3f n = normal.cast<float>();
    scene_.planes[scene_.plane_count++] = {
        {n.x(), n.y(), n.z()}, static_cast<float>(offset_m), 0, 0};
  }
  /// A layer of spheres in z = 0, whose tops are in z = radius.
  void add_layer(double radius_m, double spacing_m, double half_m = 0.03) {
    const int n = static_cast<int>(half_m / spacing_m);
    for (int i = -n; i <= n; ++i)
      for (int k = -n; k <= n; ++k) add_sphere({i * spacing_m, k * spacing_m, 0.0}, radius_m);
  }
  ToolForce at(const Vector3d& tool_m) {
    const ToolPose pose{.position_m = tool_m};
    proxies_.place(scene_, pose);
    touched_.clear();
    const PlacedToolSphere& reach = proxies_.reach().front();
    for (const TouchedSphere& sphere : spheres_)
      if ((sphere.position_m - reach.position_m).norm() < reach.radius_m + sphere.radius_m)
        touched_.add(sphere);
    return proxies_.press(scene_, touched_, pose, kTick_s);
  }
  /// Goes evenly, and stays for a while.
  ToolForce go(const Vector3d& from_m, const Vector3d& to_m, double speed_m_s, int stay = 200) {
    const double ticks = std::ceil((to_m - from_m).norm() / (speed_m_s * kTick_s));
    for (double k = 1.0; k <= ticks; k += 1.0) (void)at(from_m + k / ticks * (to_m - from_m));
    ToolForce force;
    for (int k = 0; k < stay; ++k) force = at(to_m);
    return force;
  }

 private:
  proto::SceneHeader scene_{};
  std::vector<TouchedSphere> spheres_;
  TouchedSpheres touched_;
  ToolProxies proxies_;
};

Vector3d up(double z_m) {
  return {0.0, 0.0, z_m};
}

}  // namespace

TEST_CASE("The force at rest is stiffness times depth, however densely spheres cover a face",
          "[tool_proxies]") {
  constexpr double kRadius_m = 0.003;
  for (const double share : {1.0, 0.5, 0.25}) {
    Probe probe;
    probe.add_layer(kRadius_m, share * kRadius_m, 0.012);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-0.003, 0.003), deep(0.001, 0.006);
    for (int k = 0; k < 20 / tests::kCut; ++k) {
      const Vector3d aside(place(random), place(random), 0.0);
      const double depth_m = deep(random), top_m = kRadius_m + kTool_m;
      const ToolForce force = probe.go(aside + up(top_m + 0.001), aside + up(top_m - depth_m), 0.1);
      INFO("spacing " << share << " radii, depth " << depth_m);
      CHECK(force.force_N.z() == Approx(kStiffness_N_per_m * depth_m).epsilon(0.002));
      CHECK(force.force_N.head<2>().norm() < 0.01 * force.force_N.z());
      (void)probe.go(aside + up(top_m - depth_m), aside + up(top_m + 0.001), 0.1);
    }
  }
}

TEST_CASE("A press above the force that a body bears is told", "[tool_proxies]") {
  Probe probe;
  probe.add_layer(0.003, 0.0015);
  CHECK_FALSE(probe.go(up(0.01), up(0.004), 0.1).is_crushing);  // 2 N
  probe.bear(1.9F);
  CHECK(probe.go(up(0.01), up(0.004), 0.1).is_crushing);
  probe.bear(2.1F);
  CHECK_FALSE(probe.go(up(0.01), up(0.004), 0.1).is_crushing);
  // A wall beside it bears 3 N of the load.
  probe.add_plane(Vector3d::UnitX(), 0.0);
  CHECK_FALSE(probe.go({0.01, 0.0, 0.01}, {-0.001, 0.0, 0.004}, 0.1).is_crushing);
  probe.bear(1.9F);
  CHECK(probe.go({0.01, 0.0, 0.01}, {-0.001, 0.0, 0.004}, 0.1).is_crushing);
}

TEST_CASE("Faces of one plane are felt as one, walls of a corner as the sum of their vectors",
          "[tool_proxies]") {
  Probe seam;
  for (int k = 0; k < 4; ++k) seam.add_plane(Vector3d::UnitZ(), 0.0);
  CHECK(seam.go(up(0.006), up(0.003), 0.1).force_N.z() ==
        Approx(kStiffness_N_per_m * 0.002).epsilon(1e-6));
  Probe corner;
  corner.add_plane(Vector3d::UnitZ(), 0.0);
  corner.add_plane(Vector3d::UnitX(), 0.0);
  const Vector3d force_N = corner.go({0.01, 0.0, 0.01}, {0.004, 0.0, 0.002}, 0.1).force_N;
  CHECK(force_N.x() == Approx(kStiffness_N_per_m * 0.001).epsilon(1e-4));
  CHECK(force_N.z() == Approx(kStiffness_N_per_m * 0.003).epsilon(1e-4));
}

TEST_CASE("A tool stays on its side of a thin layer, at any depth and speed", "[tool_proxies]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.004, 0.004), speed(0.05, 8.0), deep(0.005, 0.05);
  for (int k = 0; k < 100 / tests::kCut; ++k) {
    Probe probe;
    probe.add_layer(0.002, 0.002);
    const Vector3d aside(place(random), place(random), 0.0);
    const double depth_m = deep(random);
    const ToolForce force = probe.go(aside + up(0.02), aside + up(0.007 - depth_m), speed(random));
    INFO("depth " << depth_m);
    CHECK(force.force_N.z() == Approx(kStiffness_N_per_m * depth_m).epsilon(0.08));
    CHECK(force.force_N.head<2>().norm() < 0.01 * force.force_N.z());
  }
}

TEST_CASE("Friction holds a load inside its cone and slides outside", "[tool_proxies]") {
  Probe probe(0.5);
  probe.add_plane(Vector3d::UnitZ(), 0.0);
  (void)probe.go(up(0.006), up(0.003), 0.1);  // 1 N
  const double held_N = -probe.go(up(0.003), {0.0009, 0.0, 0.003}, 0.01, 60'000).force_N.x();
  CHECK(held_N == Approx(kStiffness_N_per_m * 0.0009));  // after a minute
  const double slides_N = -probe.go({0.0009, 0.0, 0.003}, {0.02, 0.0, 0.003}, 0.01).force_N.x();
  CHECK(slides_N == Approx(0.5));
}

TEST_CASE("A closed path without friction gives no energy", "[tool_proxies]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-0.01, 0.01), height(0.0, 0.012);
  for (int k = 0; k < 10; ++k) {
    Probe probe;
    probe.add_layer(0.003, 0.003);
    const Vector3d start_m = up(0.02);
    std::vector<Vector3d> corners_m{start_m};
    for (int i = 0; i < 6; ++i) corners_m.push_back({place(random), place(random), height(random)});
    corners_m.push_back(start_m);
    double given_J = 0.0, most_J = 0.0;
    Vector3d before_m = start_m, before_N = Vector3d::Zero();
    for (std::size_t i = 1; i < corners_m.size(); ++i)
      for (int tick = 1; tick <= 400; ++tick) {
        const Vector3d at_m = corners_m[i - 1] + tick / 400.0 * (corners_m[i] - corners_m[i - 1]);
        const Vector3d force_N = probe.at(at_m).force_N;
        given_J += 0.5 * (force_N + before_N).dot(at_m - before_m);
        most_J = std::max(most_J, std::abs(given_J));
        before_m = at_m;
        before_N = force_N;
      }
    CHECK(given_J < 0.01 * most_J);
  }
}

}  // namespace stillgrid::rendering::tool_proxies_test
