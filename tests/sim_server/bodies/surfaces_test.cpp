#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>

#include "sim_server/bodies/kinds/body_in_world.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::bodies::surfaces_test {
namespace {

/// All centres at rest, by their published numbers.
std::vector<Eigen::Vector3d> centres_of(const World& world) {
  std::vector<Eigen::Vector3d> centres_m;
  for (const SphereBinding& sphere : world.spheres) centres_m.push_back(sphere.rest_position_m);
  for (const StaticSphere& sphere : world.static_spheres) centres_m.push_back(sphere.position_m);
  return centres_m;
}

Eigen::Vector3d place_of(const SurfacePoint& point, std::span<const Eigen::Vector3d> centres_m) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(point.count); ++i)
    sum_m += point.weights[i] * centres_m[static_cast<std::size_t>(point.spheres[i])];
  return sum_m;
}

Eigen::Vector3d in_world(const BodyDescription& body, const Eigen::Vector3d& point_m) {
  return body.position_m + body.orientation * point_m;
}

void tilt(BodyDescription& body) {
  body.position_m = {0.1, -0.2, 0.3};
  body.orientation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
}

/// A mesh of its own round evenly strewn balls: a tetrahedron.
BodyDescription meshed_body() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> draw(-0.02, 0.02);
  std::vector<spheres::Ball> balls;
  for (int i = 0; i < 60; ++i) balls.push_back({{draw(random), draw(random), draw(random)}, 0.004});
  BodyDescription body = sim_server::rigid_mesh(balls, {1e-4, 1e-4, 1e-4}, 0.1);
  mesh::TriangleMesh& surface = std::get<RigidMeshBody>(body.shape).surface;
  surface.vertices_m = {{0.03, 0, 0}, {-0.02, 0.02, 0}, {-0.02, -0.02, 0}, {0, 0, 0.03}};
  surface.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return body;
}

/// Twice the solid's volume along each axis' share of the outward normals: positive if they are
/// outward.
double volume_m3(const BodySurface& surface, std::span<const Eigen::Vector3d> centres_m) {
  double volume = 0.0;
  for (const Eigen::Vector3i& t : surface.triangles) {
    const auto corner = [&](int i) {
      return place_of(surface.vertices[static_cast<std::size_t>(t[i])], centres_m);
    };
    volume += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
  }
  return volume;
}

TEST_CASE("A box's corners are where they were, and the faces look outward", "[surfaces]") {
  BodyDescription body = sim_server::box({0, 0, 0}, {0.03, 0.05, 0.02}, 0.02, {0.01, 0.005});
  tilt(body);
  body.motion = GENERATE(Motion::kFree, Motion::kStatic);
  const scene::SceneDescription scene =
      sim_server::scene_of({sim_server::sphere({1, 1, 1}, 0.01, 0.1), body});
  const World world = scene::build_world(scene);
  const auto centres_m = centres_of(world);

  const auto surfaces = rest_surfaces(scene.bodies, world);

  REQUIRE(surfaces.size() == 1);
  CHECK(surfaces[0].body == 1);
  REQUIRE(surfaces[0].vertices.size() == 8);
  CHECK(surfaces[0].triangles.size() == 12);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d local_m(((corner & 1) - 0.5) * 0.03, ((corner >> 1 & 1) - 0.5) * 0.05,
                                  ((corner >> 2) - 0.5) * 0.02);
    CHECK((place_of(surfaces[0].vertices[static_cast<std::size_t>(corner)], centres_m) -
           in_world(body, local_m))
              .norm() < 1e-12);
  }
  CHECK(volume_m3(surfaces[0], centres_m) == Approx(0.03 * 0.05 * 0.02));
}

TEST_CASE("Whatever turns, moves or strains the centres turns, moves and strains the surface alike",
          "[surfaces]") {
  std::vector<BodyDescription> bodies = {
      sim_server::sheet({4, 3}, 0.02, 0.002, 500.0),
      sim_server::thread(7, {0, 0, 1}, {0.3, 0.1, 0.5}, 0.01, 100.0),
      sim_server::soft_block({3, 4, 5}, 0.01, 0.001, 10.0, {0.005, 0.0025}),
      sim_server::box({0, 0, 0}, {0.03, 0.05, 0.02}, 0.02, {0.01, 0.005}), meshed_body()};
  for (BodyDescription& body : bodies)
    if (!std::holds_alternative<ThreadBody>(body.shape)) tilt(body);
  const scene::SceneDescription scene = sim_server::scene_of(bodies);
  const World world = scene::build_world(scene);
  const auto surfaces = rest_surfaces(scene.bodies, world);
  REQUIRE(surfaces.size() == bodies.size());

  Eigen::Matrix3d motion =
      Eigen::AngleAxisd(2.0, Eigen::Vector3d(3, -1, 2).normalized()) * Eigen::Matrix3d::Identity();
  if (GENERATE(false, true)) motion *= Eigen::Vector3d(1.2, 0.9, 1.0).asDiagonal();
  const auto moved = [&](const Eigen::Vector3d& point_m) -> Eigen::Vector3d {
    return Eigen::Vector3d(0.5, 0.6, -0.7) + motion * point_m;
  };
  const auto rest_m = centres_of(world);
  std::vector<Eigen::Vector3d> now_m;
  for (const Eigen::Vector3d& centre_m : rest_m) now_m.push_back(moved(centre_m));
  for (const BodySurface& surface : surfaces)
    for (const SurfacePoint& point : surface.vertices)
      CHECK((place_of(point, now_m) - moved(place_of(point, rest_m))).norm() < 1e-11);
}

TEST_CASE("A soft block shows its lattice's skin, closed", "[surfaces]") {
  BodyDescription body = sim_server::soft_block({3, 4, 5}, 0.01, 0.001, 10.0, {0.005, 0.0025});
  tilt(body);
  const scene::SceneDescription scene = sim_server::scene_of({body});
  const World world = scene::build_world(scene);
  const auto surfaces = rest_surfaces(scene.bodies, world);

  REQUIRE(surfaces.size() == 1);
  const BodySurface& skin = surfaces[0];
  CHECK(skin.vertices.size() == 3 * 4 * 5 - 1 * 2 * 3);
  CHECK(skin.triangles.size() == 4 * (2 * 3 + 3 * 4 + 2 * 4));
  CHECK(volume_m3(skin, centres_of(world)) == Approx(0.02 * 0.03 * 0.04));
  std::set<std::pair<int, int>> edges;  // each once in each direction
  for (const Eigen::Vector3i& t : skin.triangles)
    for (int i = 0; i < 3; ++i) CHECK(edges.insert({t[i], t[(i + 1) % 3]}).second);
  for (const auto& [from, to] : edges) CHECK(edges.count({to, from}) == 1);
}

TEST_CASE("A mesh's vertices are where its file has them, by weights that stay small",
          "[surfaces]") {
  BodyDescription body = meshed_body();
  tilt(body);
  const scene::SceneDescription scene = sim_server::scene_of({body});
  const World world = scene::build_world(scene);
  const auto surfaces = rest_surfaces(scene.bodies, world);
  REQUIRE(surfaces.size() == 1);
  REQUIRE(surfaces[0].vertices.size() == 4);
  const mesh::TriangleMesh& mesh = std::get<RigidMeshBody>(body.shape).surface;
  CHECK(surfaces[0].triangles == mesh.triangles);
  for (std::size_t i = 0; i < 4; ++i) {
    const SurfacePoint& point = surfaces[0].vertices[i];
    CHECK((place_of(point, centres_of(world)) - in_world(body, mesh.vertices_m[i])).norm() < 1e-12);
    double sum = 0.0;
    for (const double weight : point.weights) sum += std::abs(weight);
    CHECK(sum < 5.0);
  }
}

TEST_CASE("A sheet is the grid of its spheres and a thread the line through them", "[surfaces]") {
  const scene::SceneDescription scene =
      sim_server::scene_of({sim_server::sheet({4, 3}, 0.02, 0.002, 500.0),
                            sim_server::thread(7, {0, 0, 1}, {0.3, 0.1, 0.5}, 0.01, 100.0)});
  const World world = scene::build_world(scene);
  const auto surfaces = rest_surfaces(scene.bodies, world);
  REQUIRE(surfaces.size() == 2);
  CHECK(surfaces[0].vertices.size() == 12);
  CHECK(surfaces[0].triangles.size() == 2 * 3 * 2);
  CHECK(surfaces[1].triangles.empty());
  CHECK(surfaces[1].lines.size() == surfaces[1].vertices.size() - 1);
  CHECK(surfaces[1].vertices[0].spheres[0] == 12);
}

TEST_CASE("A body whose spheres span no space has no surface, nor has a ball", "[surfaces]") {
  BodyDescription rod = sim_server::box({0, 0, 0}, {0.05, 0.01, 0.01}, 0.02, {0.01, 0.005});
  BodyDescription plate = sim_server::box({0, 0, 0.1}, {0.05, 0.05, 0.01}, 0.02, {0.01, 0.005});
  tilt(rod);
  tilt(plate);
  const scene::SceneDescription scene =
      sim_server::scene_of({rod, plate, sim_server::sphere({1, 1, 1}, 0.01, 0.1)});
  const World world = scene::build_world(scene);
  REQUIRE(world.spheres.size() > 10);
  CHECK(rest_surfaces(scene.bodies, world).empty());
}

TEST_CASE("Where the nearest spheres lie flat, wider ones hold the point", "[surfaces]") {
  std::vector<Eigen::Vector3d> centres_m;
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 5; ++y) centres_m.emplace_back(0.01 * x, 0.01 * y, 1e-5 * (x * y % 3));
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 5; ++y) centres_m.emplace_back(0.01 * x, 0.01 * y, 0.04);
  const Eigen::Vector3d point_m(0.021, 0.02, 0.006);
  const auto point = bind_to_spheres(centres_m, 0, point_m);
  REQUIRE(point);
  CHECK((place_of(*point, centres_m) - point_m).norm() < 1e-12);
  double sum = 0.0;
  for (const double weight : point->weights) sum += std::abs(weight);
  CHECK(sum < 4.0);
}

}  // namespace
}  // namespace stillgrid::bodies::surfaces_test
