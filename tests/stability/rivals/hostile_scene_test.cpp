#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "tests/laboratory/rivals/rivals.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::laboratory::hostile_scene_test {
namespace {

/// A number that a faulty or hostile writer might leave.
float any_number(std::mt19937& random) {
  static constexpr float kSpecial[] = {0.0F,
                                       -0.0F,
                                       1e-30F,
                                       1e30F,
                                       -1e38F,
                                       std::numeric_limits<float>::infinity(),
                                       std::numeric_limits<float>::quiet_NaN(),
                                       std::numeric_limits<float>::denorm_min()};
  const auto word = static_cast<std::uint32_t>(random());
  if (word % 4 == 0) return kSpecial[(word / 4) % std::size(kSpecial)];
  if (word % 4 == 1) return 1e-9F * static_cast<float>(word) - 2.0F;
  return std::bit_cast<float>(static_cast<std::uint32_t>(random()));
}

/// Writes three such numbers into every record of the snapshot that was published last.
void spoil_latest(rendering::PublishedScene& scene, std::size_t spheres, std::mt19937& random) {
  const collision::GridLayout layout =
      collision::grid_layout(sizeof(proto::SnapshotHeader), spheres);
  std::uint64_t* payload =
      scene.writer().segment().buffer().payload[scene.writer().snapshot_id() % 2];
  constexpr std::size_t kNumbers = sizeof(proto::SphereRecord) / sizeof(float);
  auto* record = reinterpret_cast<unsigned char*>(payload + layout.records);
  for (std::size_t i = 0; i < spheres; ++i, record += sizeof(proto::SphereRecord))
    for (int j = 0; j < 3; ++j) {
      const float number = any_number(random);
      std::memcpy(record + sizeof number * (random() % kNumbers), &number, sizeof number);
    }
}

TEST_CASE("Whatever the spheres of a snapshot are, every model's force is finite and bounded work",
          "[hostile_scene]") {
  const auto model = GENERATE(as<std::string_view>(), "grid", "force_held", "force_jacobian",
                              "plane", "sphere", "proxy", "crossfade");
  CAPTURE(model);
  publication::StaticScene fixed = rendering::plain_scene(800.0F, 0.005F);
  fixed.materials[0] = {800.0F, 5.0F, 0.5F, 0.01F};
  fixed.planes = {{{0.0F, 0.0F, 1.0F}, -0.005F, 0, 0}};
  fixed.tool.push_back({{0.01F, 0.0F, 0.0F}, 0.004F});
  constexpr std::size_t kSpheres = 64;
  rendering::PublishedScene scene(fixed, std::vector<float>(kSpheres, 0.01F),
                                  rendering::kMillisecond_ns);
  const auto renderer = make_renderer(rival_named(model), display::Transition::kLinear);
  std::mt19937 random(5);
  std::normal_distribution<double> near_m(0.0, 0.01);
  int touching = 0;
  for (std::uint64_t tick = 1; tick <= 2000; ++tick) {
    if (tick % 3 == 0) {
      std::vector<Eigen::Vector3d> places_m(kSpheres);
      for (Eigen::Vector3d& p : places_m) p = {near_m(random), near_m(random), near_m(random)};
      scene.show(places_m, places_m, tick * rendering::kMillisecond_ns,
                 random() % (2 * tick * rendering::kMillisecond_ns));
      spoil_latest(scene, kSpheres, random);
    }
    const rendering::ToolPose pose{.position_m = {near_m(random), near_m(random), near_m(random)},
                                   .orientation = Eigen::Quaterniond(Eigen::AngleAxisd(
                                       0.01 * static_cast<double>(tick), Eigen::Vector3d::UnitX())),
                                   .velocity_m_s = {near_m(random), 0.0, near_m(random)}};
    const rendering::RenderedTick rendered =
        renderer->render(scene.view(), pose, tick * rendering::kMillisecond_ns);
    CHECK(rendered.force.force_N.allFinite());
    CHECK(rendered.force.torque_N_m.allFinite());
    if (rendered.switch_jump_N) CHECK(std::isfinite(*rendered.switch_jump_N));
    touching += rendered.force.contacts > 0 ? 1 : 0;
  }
  CHECK(touching > 500);
}

}  // namespace
}  // namespace stillgrid::laboratory::hostile_scene_test
