#include <catch2/catch.hpp>
#include <random>

#include "shared/collision/contact_law.hpp"
#include "shared/rendering/tool_force.hpp"

namespace stillgrid::rendering::tool_torque_test {
namespace {

constexpr double kSlipSpeed_m_s = 0.01;

/// A floor at z = 0 of one material.
proto::SceneHeader floor_of(float stiffness_N_per_m, float friction) {
  proto::SceneHeader scene{};
  scene.material_count = 1;
  scene.materials[0] = {stiffness_N_per_m, 0.0F, friction, 1e-3F};
  scene.tool_slip_speed_m_s = static_cast<float>(kSlipSpeed_m_s);
  scene.plane_count = 1;
  scene.planes[0] = {{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0};
  return scene;
}

std::vector<PlacedToolSphere> placed(const ToolPose& pose,
                                     const std::vector<Eigen::Vector3d>& spheres_m,
                                     double radius_m) {
  std::vector<PlacedToolSphere> tool;
  for (const Eigen::Vector3d& p : spheres_m) {
    const Eigen::Vector3d at_m = pose.position_m + pose.orientation * p;
    tool.push_back({at_m, radius_m});
  }
  return tool;
}

TEST_CASE("The torque of a symmetric press is zero", "[tool_torque]") {
  const ToolPose pose{.position_m = {0.3, -0.2, 0.004}};
  const ToolForce force =
      tool_force(floor_of(1000.0F, 0.3F), {},
                 placed(pose, {{0.02, 0.0, 0.0}, {-0.02, 0.0, 0.0}, {0.0, 0.0, 0.0}}, 0.005), pose);
  CHECK(force.contacts == 3);
  CHECK(force.force_N.z() == Approx(3.0));
  CHECK(force.torque_N_m.norm() < 1e-15);
}

TEST_CASE("A force off the origin turns the tool by its lever", "[tool_torque]") {
  ToolPose pose{.position_m = {0.3, -0.2, 0.004}};
  pose.orientation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ());
  const ToolForce force =
      tool_force(floor_of(1000.0F, 0.0F), {}, placed(pose, {{0.03, 0.0, 0.0}}, 0.005), pose);
  const Eigen::Vector3d arm_m = pose.orientation * Eigen::Vector3d(0.03, 0.0, 0.0);
  CHECK((force.force_N - Eigen::Vector3d(0.0, 0.0, 1.0)).norm() < 1e-12);
  CHECK((force.torque_N_m - arm_m.cross(force.force_N)).norm() < 1e-12);
}

TEST_CASE("Friction opposes the slip of a tool that turns on a floor", "[tool_torque]") {
  const double radius_m = 0.005, press_N = 1.0;
  ToolPose pose{.position_m = {0.0, 0.0, 0.004}};
  pose.angular_velocity_rad_s = {100.0, 0.0, 0.0};  // the lowest point goes along y at 0.5 m/s
  const ToolForce force = tool_force(floor_of(1000.0F, 0.3F), {},
                                     placed(pose, {Eigen::Vector3d::Zero()}, radius_m), pose);
  CHECK((force.force_N - Eigen::Vector3d(0.0, -0.3 * press_N, press_N)).norm() < 1e-7);
  CHECK((force.torque_N_m - Eigen::Vector3d(-0.3 * press_N * radius_m, 0.0, 0.0)).norm() < 1e-9);
  CHECK(force.torque_N_m.dot(pose.angular_velocity_rad_s) < 0.0);
}

TEST_CASE("A tool that rolls on a floor feels no friction", "[tool_torque]") {
  ToolPose pose{.position_m = {0.0, 0.0, 0.005 - 1e-6}};
  pose.angular_velocity_rad_s = {0.0, 20.0, 0.0};
  pose.velocity_m_s = {0.1, 0.0, 0.0};
  const ToolForce force =
      tool_force(floor_of(1e6F, 0.3F), {}, placed(pose, {Eigen::Vector3d::Zero()}, 0.005), pose);
  CHECK(force.force_N.z() == Approx(1.0));
  CHECK(force.force_N.head<2>().norm() < 1e-12);
}

TEST_CASE("Tool and touched sphere get opposite forces at one point, whoever is called the tool",
          "[tool_torque]") {
  proto::SceneHeader scene = floor_of(800.0F, 0.4F);
  scene.plane_count = 0;
  scene.materials[0].damping_N_s_per_m = 3.0F;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  const auto any = [&] { return Eigen::Vector3d(share(random), share(random), share(random)); };
  for (int i = 0; i < 200; ++i) {
    const double radius_a_m = 0.01 + 0.005 * share(random),
                 radius_b_m = 0.01 + 0.005 * share(random);
    const Eigen::Vector3d a_m = 0.1 * any(), b_m = a_m + 0.015 * any().normalized();
    const Eigen::Vector3d velocity_a_m_s = any(), velocity_b_m_s = any();
    const auto wrench_on = [&](const Eigen::Vector3d& tool_m, double tool_radius_m,
                               const Eigen::Vector3d& tool_m_s, const Eigen::Vector3d& other_m,
                               double other_radius_m, const Eigen::Vector3d& other_m_s) {
      const ToolPose pose{.position_m = Eigen::Vector3d::Zero(), .velocity_m_s = tool_m_s};
      TouchedSpheres touched;
      touched.spheres[0] = {other_m, other_m_s, other_radius_m, 0, 0, false};
      touched.count = 1;
      const std::array<PlacedToolSphere, 1> tool{{{tool_m, tool_radius_m}}};
      return tool_force(scene, touched, tool, pose);  // moments about the scene's origin
    };
    const ToolForce on_a =
        wrench_on(a_m, radius_a_m, velocity_a_m_s, b_m, radius_b_m, velocity_b_m_s);
    const ToolForce on_b =
        wrench_on(b_m, radius_b_m, velocity_b_m_s, a_m, radius_a_m, velocity_a_m_s);
    REQUIRE(on_a.contacts == on_b.contacts);
    REQUIRE((on_a.force_N + on_b.force_N).norm() < 1e-10);
    REQUIRE((on_a.torque_N_m + on_b.torque_N_m).norm() < 1e-11);
  }
}

}  // namespace
}  // namespace stillgrid::rendering::tool_torque_test
