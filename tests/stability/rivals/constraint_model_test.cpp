#include "tests/laboratory/rivals/constraint_model.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::laboratory::constraint_model_test {
namespace {

constexpr double kPeriod_s = 0.033, kMass_kg = 0.5, kRadius_m = 0.05, kTool_m = 0.005;
constexpr double kStiffness_N_per_m = 2000.0;
constexpr std::uint64_t kPeriod_ns = 33'000'000;

scene::SceneDescription scene_with(const std::string& body) {
  return scene::read_scene(R"(
format = 2
[world]
gravity_m_s2 = [0.0, 0.0, 0.0]
[simulation]
period_s = 0.033
[[material]]
name = "touched"
contact_stiffness_N_per_m = 2000.0
[[body]]
name = "body"
material = "touched"
)" + body,
                           "constraints.toml");
}

const std::string kBall = R"(
kind = "sphere"
radius_m = 0.05
mass_kg = 0.5
)";

const std::string kHung = R"(
kind = "thread"
nodes = 2
from_m = [0.0, 0.0, 0.0]
to_m = [0.0, 0.0, -0.03]
pinned = "end"
spheres = { spacing_m = 0.03, radius_m = 0.005 }
mass_kg = 1.0
spring_stiffness_N_per_m = { structural = 1000.0 }
)";

/// After a step without a tool, from which nothing moves.
std::unique_ptr<dynamics::Simulation> stepped(const std::string& body) {
  auto simulation = std::make_unique<dynamics::Simulation>(scene_with(body));
  simulation->step(kPeriod_s, [] { return std::nullopt; });
  return simulation;
}

TEST_CASE("What a step makes of a newton is the compliance that is handed over", "[constraints]") {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const auto compliance = [](const std::string& body,
                             std::initializer_list<ShippedSteps::Push> pushes) {
    ShippedSteps steps;
    steps.take(*stepped(body));
    return steps.compliance_m_per_N(kPeriod_ns, pushes);
  };
  const double free_m_per_N = kPeriod_s * kPeriod_s / kMass_kg;
  Eigen::Matrix2d pinched;
  pinched << free_m_per_N, -free_m_per_N, -free_m_per_N, free_m_per_N;
  CHECK(compliance(kBall, {{0, up}, {0, -up}}).isApprox(pinched, 1e-6));

  const double hung_m_per_N = kPeriod_s * kPeriod_s / (0.5 + kPeriod_s * kPeriod_s * 1000.0);
  CHECK(compliance(kHung, {{0, up}})(0, 0) == Approx(hung_m_per_N).epsilon(1e-5));
}

TEST_CASE("Of a step that was not handed over nothing gives way", "[constraints]") {
  ShippedSteps steps;
  steps.take(*stepped(kBall));
  const std::array pushes = {ShippedSteps::Push{0, Eigen::Vector3d::UnitZ()}};
  CHECK(steps.compliance_m_per_N(2 * kPeriod_ns, pushes).isZero(0.0));
}

/// The tool above a ball that was so deep in it when the step ended, and its force later.
class Pressed {
 public:
  Pressed(double depth_m, bool is_shipped) {
    fixed_->material_count = 1;
    fixed_->materials[0] = {static_cast<float>(kStiffness_N_per_m), 0.0F, 0.0F, 1.0F};
    fixed_->tool_sphere_count = 1;
    patch_->spheres[0] = {.position_m = Eigen::Vector3d::Zero(),
                          .velocity_m_s = Eigen::Vector3d::Zero(),
                          .radius_m = kRadius_m,
                          .material = 0,
                          .tool_sphere = 0,
                          .swept = false};
    patch_->count = 1;
    if (is_shipped) model_.after_step(*stepped(kBall));
    at(depth_m, [this](const PlacedTool& tool) {
      model_.update({*fixed_, *patch_, kPeriod_ns, 1}, tool, tool, true);
    });
  }

  double force_N(double depth_m) {
    double force_N = 0.0;
    at(depth_m, [&](const PlacedTool& tool) {
      force_N = model_.force({.fixed = *fixed_, .patch = *patch_}, tool).force_N.z();
    });
    return force_N;
  }

 private:
  template <class Ask>
  static void at(double depth_m, Ask ask) {
    const rendering::ToolPose pose{.position_m = {0.0, 0.0, kRadius_m + kTool_m - depth_m}};
    const std::array spheres = {
        rendering::PlacedToolSphere{pose.position_m, kTool_m, pose.position_m}};
    ask({pose, spheres});
  }

  std::unique_ptr<proto::SceneHeader> fixed_ = std::make_unique<proto::SceneHeader>();
  std::unique_ptr<rendering::TouchedSpheres> patch_ = std::make_unique<rendering::TouchedSpheres>();
  ConstraintModel model_;
};

TEST_CASE("At the sample the force is the step's, and a body gives way from there",
          "[constraints]") {
  constexpr double kDepth_m = 0.001, kDeeper_m = 0.003;
  Pressed ball(kDepth_m, true);
  CHECK(ball.force_N(kDepth_m) == Approx(kStiffness_N_per_m * kDepth_m));
  const double softened_N_per_m =
      1.0 / (1.0 / kStiffness_N_per_m + kPeriod_s * kPeriod_s / kMass_kg);
  CHECK(ball.force_N(kDeeper_m) ==
        Approx(kStiffness_N_per_m * kDepth_m + softened_N_per_m * (kDeeper_m - kDepth_m)));
  // It pushes only; where the ball went to without it, the tool has left it.
  const double parting_m = kDepth_m - kStiffness_N_per_m * kDepth_m / softened_N_per_m;
  CHECK(ball.force_N(parting_m + 1e-5) > 0.0);
  CHECK(ball.force_N(parting_m - 1e-5) == 0.0);
  CHECK(ball.force_N(kDepth_m) == Approx(kStiffness_N_per_m * kDepth_m));
}

TEST_CASE("What does not give way is a wall of the coupling's stiffness", "[constraints]") {
  Pressed fixed(-0.001, false);
  CHECK(fixed.force_N(-0.0005) == 0.0);
  CHECK(fixed.force_N(0.002) == Approx(kStiffness_N_per_m * 0.002));
}

}  // namespace
}  // namespace stillgrid::laboratory::constraint_model_test
