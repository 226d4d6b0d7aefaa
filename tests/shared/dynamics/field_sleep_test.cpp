// Bodies that are met through fields sleep and wake as others do.
#include <catch2/catch.hpp>
#include <vector>

#include "tests/shared/dynamics/field_scenes.hpp"
#include "tests/shared/dynamics/implicit_scenes.hpp"

namespace stillgrid::dynamics::field_sleep_test {
namespace {

using Eigen::Vector3d;

const Vector3d kBox_m(0.04, 0.03, 0.02);

/// A box on a box, a box on a solid that never moves, and a tool.
EngineScene boxes() {
  EngineScene scene;
  scene.with_gravity();
  scene.description.materials = {{2100.0, 2.0, 0.6}};
  scene.add_plane(Vector3d::UnitZ(), 0.0);
  const SharedField box = box_field(kBox_m);
  for (const Vector3d& at_m :
       {Vector3d(0.0, 0.0, 0.01), Vector3d(0.004, -0.003, 0.03), Vector3d(0.2, 0.0, 0.03)}) {
    const int rigid = add_field_box(scene, kBox_m, 0.137, at_m, box);
    scene.description.bodies.push_back(
        {.rigid = rigid, .rest_speed_m_s = 4.5e-5, .bounding_radius_m = 0.03});
  }
  const int fixture = add_static_field(scene, box, {0.2, 0.0, 0.01});
  scene.description.rigid_bodies[static_cast<std::size_t>(fixture)].is_fixture = true;
  const int tool = scene.add_rigid(0.0, Vector3d::Zero(), Vector3d::Zero(), true);
  scene.add_sphere(tool, 0.005);
  scene.description.spheres.back().is_tool = true;
  return scene;
}
std::vector<DrivenPose> tool_at(const Vector3d& position_m) {
  DrivenPose fixture{.position_m = {0.2, 0.0, 0.01}}, tool{.position_m = position_m};
  return {fixture, tool};
}
std::vector<DrivenPose> without_tool() {
  std::vector<DrivenPose> poses = tool_at(Vector3d::Zero());
  poses[1].is_here = false;
  return poses;
}
void lull(Engine& engine) {
  for (int tick = 0; tick < 20000 && !engine.sleep().all_sleep(); ++tick)
    engine.step(without_tool());
  REQUIRE(engine.sleep().all_sleep());
}
std::vector<std::byte> block_of(const Engine& engine) {
  std::vector<std::byte> block;
  engine.save(block);
  return block;
}

TEST_CASE("Bodies of fields at rest sleep, and keep the energy of their contacts",
          "[sleep][field]") {
  Engine engine = boxes().engine(each_method());
  double awake_J = 0.0;
  for (int tick = 0; tick < 20000 && !engine.sleep().all_sleep(); ++tick) {
    awake_J = engine.contact_energy_J();
    engine.step(without_tool());
  }
  REQUIRE(engine.sleep().all_sleep());
  CHECK(engine.contact_energy_J() == Approx(awake_J).epsilon(1e-4));
  engine.step(without_tool());
  const Vector4 before_m = engine.state().rigid_position_m[1];
  const std::size_t listings = engine.listing().listings();
  for (int tick = 0; tick < 500; ++tick) engine.step(tool_at({0.1, 0.0, 0.03}));
  CHECK(engine.sleep().all_sleep());
  CHECK(engine.listing().listings() == listings);
  CHECK((engine.state().rigid_position_m[1].vector() == before_m.vector()));
}

TEST_CASE("A tool wakes the bodies of fields that it would touch, and no others",
          "[sleep][field]") {
  Engine engine = boxes().engine(each_method());
  lull(engine);
  int tick = 0;
  for (; tick < 200 && engine.sleep().all_sleep(); ++tick)
    engine.step(tool_at({0.004, 0.002, 0.06 - 1e-4 * tick}));
  CHECK(engine.sleep().sleeping() == 1);
  const double top_m = engine.state().rigid_position_m[1].z + 0.5 * kBox_m.z() + 0.005;
  CHECK(0.06 - 1e-4 * (tick - 1) == Approx(top_m).margin(kFieldCell_m / 2));
  for (int more = 0; more < 10; ++more) engine.step(tool_at({0.004, 0.002, top_m - 1e-4 * more}));
  CHECK(engine.reactions()[1].impulse_N_s.z() > 0.0);
}

TEST_CASE("A run through a saved block is equal to the bit where bodies of fields sleep",
          "[sleep][field]") {
  Engine whole = boxes().engine(), second = boxes().engine();
  lull(whole);
  const auto touch = [](Engine& engine) {
    for (int tick = 0; tick < 150; ++tick) engine.step(tool_at({0.004, 0.002, 0.05 - 1e-4 * tick}));
  };
  second.load(block_of(whole));
  touch(whole);
  touch(second);
  REQUIRE(whole.sleep().sleeping() == 1);
  const bool are_equal = block_of(whole) == block_of(second);
  CHECK(are_equal);
}

}  // namespace
}  // namespace stillgrid::dynamics::field_sleep_test
