// Open surfaces as thin shells: what a tool feels of them, and what lies on them.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "shared/rendering/tool_proxies.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "tests/sim_server/mesh/solids.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::dynamics::shells_test {
namespace {

using Eigen::Vector3d;

constexpr double kStiffness_N_per_m = 500.0, kTool_m = 0.005, kTick_s = 1e-3, kBowl_m = 0.04;

mesh::TriangleMesh bowl() {
  return mesh::woven(96, 25, false, [](int i, int j) -> Vector3d {
    const double u = 2.0 * std::numbers::pi * i / 96.0, v = 0.5 * std::numbers::pi * j / 24.0;
    return kBowl_m * Vector3d(std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), -std::sin(v));
  });
}

mesh::TriangleMesh sheet() {
  return {{{-0.04, -0.04, 0}, {0.04, -0.04, 0}, {0.04, 0.04, 0}, {-0.04, 0.04, 0}},
          {{0, 1, 2}, {0, 2, 3}}};
}

/// A scene with a mesh that stands still, and what else its text says.
scene::SceneDescription scene_with(const mesh::TriangleMesh& mesh, const std::string& more = "") {
  const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                     ("stillgrid_shell_" + std::to_string(getpid()) + ".obj");
  std::ofstream file(path);
  for (const Vector3d& v : mesh.vertices_m) file << "v " << v.transpose() << '\n';
  for (const Eigen::Vector3i& t : mesh.triangles)
    file << "f " << (t.array() + 1).transpose() << '\n';
  file.close();
  scene::SceneDescription scene = scene::scene_of(
      "format = 2\nmaterial = [{ name = 'm', contact_stiffness_N_per_m = 500.0, "
      "contact_damping_N_s_per_m = 2.0 }]\n[[body]]\nname = 'shell'\nkind = 'mesh'\nmaterial = "
      "'m'\n"
      "motion = 'static'\nfile = '" +
      path.string() + "'\n" + more);
  std::filesystem::remove(path);
  return scene;
}

/// A tool of one sphere beside the first body of a scene.
class Probe {
 public:
  explicit Probe(const scene::SceneDescription& scene) {
    header_.material_count = 1;
    header_.materials[0] = {static_cast<float>(kStiffness_N_per_m), 0.0F, 0.0F, 1e-3F};
    header_.tool_sphere_count = 1;
    header_.tool[0].radius_m = static_cast<float>(kTool_m);
    const bodies::BodyDescription& body = scene.bodies.at(0);
    for (const spheres::Ball& ball : bodies::balls_of(body))
      balls_.push_back({body.position_m + body.orientation * ball.centre_m, ball.radius_m});
  }
  [[nodiscard]] double radius_m() const { return balls_.at(0).radius_m; }
  /// From the nearest middle of a sphere.
  [[nodiscard]] double apart_m(const Vector3d& place_m) const {
    double least_m = 1.0;
    for (const spheres::Ball& ball : balls_)
      least_m = std::min(least_m, (ball.centre_m - place_m).norm());
    return least_m;
  }

  /// Goes evenly, and stays for a while. Returns the force there.
  Vector3d go(const Vector3d& from_m, const Vector3d& to_m, double speed_m_s) {
    const double ticks = std::ceil((to_m - from_m).norm() / (speed_m_s * kTick_s));
    for (double k = 1.0; k <= ticks; k += 1.0) (void)at(from_m + k / ticks * (to_m - from_m));
    Vector3d force_N = Vector3d::Zero();
    for (int k = 0; k < 200; ++k) force_N = at(to_m);
    return force_N;
  }

 private:
  Vector3d at(const Vector3d& tool_m) {
    const rendering::ToolPose pose{.position_m = tool_m};
    proxies_.place(header_, pose);
    touched_.clear();
    const rendering::PlacedToolSphere& reach = proxies_.reach().front();
    for (const spheres::Ball& ball : balls_)
      if ((ball.centre_m - reach.position_m).norm() < reach.radius_m + ball.radius_m)
        touched_.add({.position_m = ball.centre_m,
                      .velocity_m_s = Vector3d::Zero(),
                      .radius_m = ball.radius_m,
                      .material = 0,
                      .tool_sphere = 0,
                      .is_static = true});
    return proxies_.press(header_, touched_, pose, kTick_s).force_N;
  }

  proto::SceneHeader header_{};
  std::vector<spheres::Ball> balls_;
  rendering::TouchedSpheres touched_;
  rendering::ToolProxies proxies_;
};

TakeTool tool_at(const Simulation& simulation, const Vector3d& place_m) {
  const auto now_ns = static_cast<std::uint64_t>((simulation.world().time_s + kTick_s) * 1e9);
  return [=]() -> std::optional<ToolSample> {
    return ToolSample{.time_ns = now_ns, .position_m = place_m};
  };
}

/// Presses from the side where the normal points.
void check_pressed(const scene::SceneDescription& scene, const Vector3d& surface_m,
                   const Vector3d& normal, double depth_m, double speed_m_s) {
  Probe probe(scene);
  const double touch_m = probe.radius_m() + kTool_m;
  CHECK(probe.apart_m(surface_m) <= probe.radius_m());
  const Vector3d force_N = probe.go(surface_m + (touch_m + 0.001) * normal,
                                    surface_m + (touch_m - depth_m) * normal, speed_m_s);
  INFO("at " << surface_m.transpose() << ", normal " << normal.transpose() << ", depth "
             << depth_m);
  INFO("force " << force_N.transpose() << ", speed " << speed_m_s);
  CHECK(force_N.dot(normal) == Approx(kStiffness_N_per_m * depth_m).epsilon(0.1));
}

TEST_CASE("An open surface is felt from both sides, stiffness times depth", "[shells]") {
  const scene::SceneDescription open_bowl = scene_with(bowl()), flat = scene_with(sheet());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-1.0, 1.0), deep(0.002, 0.006), speed(0.05, 1.0);
  for (int k = 0; k < 40; ++k) {
    const double side = k % 2 == 0 ? 1.0 : -1.0, depth_m = deep(random), speed_m_s = speed(random);
    const Vector3d from_middle =
        Vector3d(share(random), share(random), -1.2 - share(random)).normalized();
    check_pressed(open_bowl, kBowl_m * from_middle, side * from_middle, depth_m, speed_m_s);
    check_pressed(flat, {0.03 * share(random), 0.03 * share(random), 0.0}, side * Vector3d::UnitZ(),
                  depth_m, speed_m_s);
  }
}

TEST_CASE("A ball lies in an open bowl", "[shells]") {
  const scene::SceneDescription scene =
      scene_with(bowl(),
                 "[[body]]\nname = 'ball'\nkind = 'sphere'\nradius_m = 0.01\nmass_kg = 0.05\n"
                 "material = 'm'\nposition_m = [0.004, 0.002, -0.02]\n");
  Simulation simulation(scene);
  const TakeTool nobody = []() -> std::optional<ToolSample> { return std::nullopt; };
  for (int k = 0; k < 3000; ++k) (void)simulation.step(kTick_s, nobody);
  const bodies::RigidBody& ball = simulation.world().rigid_bodies.at(0);
  const double gap_m = kBowl_m - ball.position_m.norm() - 0.01;
  const double shell_m = bodies::balls_of(scene.bodies.at(0)).front().radius_m;
  CHECK(gap_m == Approx(shell_m).margin(0.0015));  // its weight presses it in by up to 1 mm
  CHECK(ball.velocity_m_s.norm() < 0.01);
}

/// What a tool that goes to the middle of a heavy free mesh of 0.1 m gives to it, J.
double given_J(const std::filesystem::path& file) {
  const Eigen::AlignedBox3d box_m = mesh::box_of(mesh::load_mesh(file, 1.0));
  const double scale = 0.1 / box_m.sizes().maxCoeff();
  const Vector3d middle_m = scale * box_m.center();
  std::ostringstream text;
  text << "format = 2\nmaterial = [{ name = 'm', contact_stiffness_N_per_m = 500.0 }]\n"
       << "world = { gravity_m_s2 = [0, 0, 0] }\n[[body]]\n"
       << "name = 'b'\nkind = 'mesh'\nmaterial = 'm'\nmass_kg = 100\nfile = '" << file.string()
       << "'\nscale = " << scale << '\n';
  Simulation simulation(scene::scene_of(text.str()));
  const double from_m = 0.07;
  double most_J = 0.0;
  for (const Vector3d& axis :
       {Vector3d::UnitX().eval(), Vector3d::UnitY().eval(), Vector3d::UnitZ().eval()})
    for (double z_m = from_m; z_m > 0.0; z_m -= 0.001)
      most_J = std::max(
          most_J,
          simulation.step(kTick_s, tool_at(simulation, middle_m + z_m * axis)).tools[0].work_J);
  return most_J;
}

TEST_CASE("Meshes made by others are felt", "[shells][real_data]") {
  const char* data = std::getenv("STILLGRID_DATA");
  const auto folder =
      (data ? std::filesystem::path(data)
            : std::filesystem::path(STILLGRID_SOURCE_DIR) / ".." / "shared" / "data") /
      "meshes";
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: no meshes in " << folder);
    return;
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    INFO(entry.path());
    CHECK(given_J(entry.path()) > 0.01);
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::shells_test
