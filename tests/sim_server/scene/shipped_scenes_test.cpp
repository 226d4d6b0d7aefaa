#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/body_in_world.hpp"
#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::scene::shipped_scenes_test {

namespace {

SceneDescription shipped(const std::string& name) {
  return load_scene(std::filesystem::path(STILLGRID_SCENES) / (name + ".toml"));
}

long spheres_along(double length_m, double spacing_m) {
  return std::max(1L, static_cast<long>(std::ceil(length_m / spacing_m - 1e-6)) + 1);
}

/// The spheres that a free body of a shipped scene is covered with, by the rule of SpherePacking.
long sphere_count(const bodies::BodyDescription& body) {
  if (const auto* thread = std::get_if<bodies::ThreadBody>(&body.shape))
    return spheres_along((thread->to_m - thread->from_m).norm(), thread->spheres.spacing_m);
  if (const auto* sheet = std::get_if<bodies::SheetBody>(&body.shape))
    return spheres_along(sheet->size_m.x(), sheet->spheres.spacing_m) *
           spheres_along(sheet->size_m.y(), sheet->spheres.spacing_m);
  if (!std::holds_alternative<bodies::RigidBoxBody>(body.shape))
    return static_cast<long>(bodies::pack_spheres(body).size());
  const auto& box = std::get<bodies::RigidBoxBody>(body.shape);
  long count = 1;
  for (const double side_m : box.size_m)
    count *= spheres_along(side_m - 2.0 * box.spheres.radius_m, box.spheres.spacing_m);
  return count;
}

long moving_sphere_count(const SceneDescription& scene) {
  long count = 0;
  for (const bodies::BodyDescription& body : scene.bodies) {
    if (body.motion == bodies::Motion::kFree) count += sphere_count(body);
  }
  return count;
}

template <class Shape>
long count_of(const SceneDescription& scene) {
  return std::count_if(scene.bodies.begin(), scene.bodies.end(),
                       [](const bodies::BodyDescription& body) {
                         return std::holds_alternative<Shape>(body.shape);
                       });
}

/// Whether no two boxes of the scene overlap at the start, boxes being level.
bool boxes_are_apart(const SceneDescription& scene) {
  for (const bodies::BodyDescription& a : scene.bodies) {
    for (const bodies::BodyDescription& b : scene.bodies) {
      const auto* one = std::get_if<bodies::RigidBoxBody>(&a.shape);
      const auto* other = std::get_if<bodies::RigidBoxBody>(&b.shape);
      if (one == nullptr || other == nullptr || one == other) continue;
      const Eigen::Array3d gap_m =
          (a.position_m - b.position_m).array().abs() - 0.5 * (one->size_m + other->size_m).array();
      if ((gap_m < 0.0).all()) return false;
    }
  }
  return true;
}

}  // namespace

TEST_CASE("The scenes for two hands name them alike, each with a tool of its own",
          "[shipped_scenes]") {
  const auto& [name, spheres, of_tool] = GENERATE(table<std::string, long, std::size_t>(
      {{"block_pinched", 15, 4}, {"cloth_held_by_two", 156, 6}}));
  const SceneDescription scene = shipped(name);
  REQUIRE(scene.hands.size() == 2);
  CHECK(scene.hands[0].name == "left");
  CHECK(scene.hands[1].name == "right");
  for (const Hand& hand : scene.hands) CHECK(hand.tool.size() == of_tool);
  CHECK(moving_sphere_count(scene) == spheres);
}

TEST_CASE("Tissue and blocks are the paper's: 8 x 8 nodes, ten blocks, 405 spheres", "[scenes]") {
  const SceneDescription scene = shipped("tissue_and_blocks");

  CHECK(scene.name == "tissue_and_blocks");
  CHECK(scene.period_s == Approx(1e-3));
  CHECK(count_of<bodies::RigidBoxBody>(scene) == 10);
  REQUIRE(count_of<bodies::SheetBody>(scene) == 1);
  for (const bodies::BodyDescription& body : scene.bodies) {
    const auto* sheet = std::get_if<bodies::SheetBody>(&body.shape);
    if (sheet == nullptr) continue;
    CHECK(sheet->nodes == Eigen::Vector2i(8, 8));
    CHECK(sheet->springs.pinned_nodes == std::vector<int>{0, 7, 56, 63});
  }
  CHECK(moving_sphere_count(scene) == 405);
  CHECK(boxes_are_apart(scene));
}

TEST_CASE("Threads are forty, hung by their upper ends, 400 spheres", "[scenes]") {
  const SceneDescription scene = shipped("threads");

  CHECK(count_of<bodies::ThreadBody>(scene) == 40);
  CHECK(scene.bodies.size() == 40);
  for (const bodies::BodyDescription& body : scene.bodies) {
    const auto& thread = std::get<bodies::ThreadBody>(body.shape);
    CHECK(thread.springs.pinned_nodes == std::vector<int>{0});
    CHECK(thread.from_m.z() > thread.to_m.z());
  }
  CHECK(moving_sphere_count(scene) == 400);
}

TEST_CASE("Pillars stand round a tissue with bricks and soft blocks, 21,877 spheres", "[scenes]") {
  const SceneDescription scene = shipped("pillars");

  CHECK(count_of<bodies::SheetBody>(scene) == 1);
  CHECK(count_of<bodies::SoftBlockBody>(scene) == 4);
  CHECK(count_of<bodies::RigidBoxBody>(scene) == 24 + 140);
  CHECK(moving_sphere_count(scene) == 21'877);
  CHECK(boxes_are_apart(scene));
}

TEST_CASE("A chain of five links hangs from the world, and a ball by a thread from a sheet",
          "[scenes]") {
  const SceneDescription chain = shipped("pendulum_chain");
  CHECK(count_of<bodies::RigidBoxBody>(chain) == 5);
  CHECK(moving_sphere_count(chain) == 20);
  REQUIRE(chain.joints.size() == 5);
  for (int i = 0; i < 5; ++i) {
    CHECK(chain.joints[static_cast<std::size_t>(i)].body_a == i);
    CHECK(chain.joints[static_cast<std::size_t>(i)].body_b == i - 1);
  }
  const SceneDescription sewn = shipped("sewn_ball");
  CHECK(moving_sphere_count(sewn) == 57);
  CHECK(sewn.joints.size() == 2);
}

TEST_CASE("The moving sphere's held snapshot jumps by k v P = 1.65 N", "[scenes]") {
  const SceneDescription scene = shipped("moving_sphere");

  REQUIRE(scene.bodies.size() == 1);
  const bodies::BodyDescription& sphere = scene.bodies[0];
  const MaterialDescription& material = scene.materials.at(0);
  CHECK(sphere.motion == bodies::Motion::kPrescribed);
  const double speed_m_s = sphere.prescribed.velocity_m_s.x();
  CHECK(sphere.prescribed.velocity_m_s == Eigen::Vector3d(speed_m_s, 0.0, 0.0));
  CHECK(material.contact_stiffness_N_per_m * speed_m_s * scene.period_s == Approx(1.65));
  CHECK(material.contact_damping_N_s_per_m == 0.0);
  CHECK(material.friction == 0.0);
  const double touch_time_s =
      (-sphere.position_m.x() - std::get<bodies::SphereBody>(sphere.shape).radius_m -
       scene.tool.at(0).radius_m) /
      speed_m_s;
  CHECK(touch_time_s == Approx(0.35));
}

TEST_CASE("The wall is 1000 N/m at z = 0 and nothing else", "[scenes]") {
  const SceneDescription scene = shipped("wall");

  REQUIRE(scene.bodies.size() == 1);
  REQUIRE(std::holds_alternative<bodies::PlaneBody>(scene.bodies[0].shape));
  CHECK(std::get<bodies::PlaneBody>(scene.bodies[0].shape).normal == Eigen::Vector3d::UnitZ());
  CHECK(scene.bodies[0].position_m.isZero(0.0));
  CHECK(scene.materials.at(0).contact_stiffness_N_per_m == 1000.0);
  CHECK(scene.materials.at(0).contact_damping_N_s_per_m == 0.0);
  CHECK(scene.materials.at(0).friction == 0.0);
  CHECK(scene.gravity_m_s2.isZero(0.0));
}

TEST_CASE("Every scene that ships loads", "[scenes]") {
  for (const auto& entry : std::filesystem::directory_iterator(STILLGRID_SCENES)) {
    if (entry.path().extension() != ".toml") continue;  // a mesh
    INFO(entry.path());
    CHECK_NOTHROW(load_scene(entry.path()));
  }
}

}  // namespace stillgrid::scene::shipped_scenes_test
