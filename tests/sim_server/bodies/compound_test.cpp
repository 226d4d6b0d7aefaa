#include "sim_server/bodies/kinds/compound.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "shared/collision/distance_field.hpp"
#include "sim_server/scene/build_world.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::bodies::compound_test {
namespace {

using Eigen::Vector3d;
using Kind = SolidShape::Kind;
using sim_server::compound;
using sim_server::solid;

World world_of(BodyDescription body) {
  return scene::build_world(
      sim_server::scene_of({std::move(body)}, sim_server::material_of(1000.0, 1.0, 0.3)));
}

/// By points drawn in the box around each shape: only for shapes that do not overlap.
mesh::MassProperties by_points(const std::vector<SolidShape>& shapes) {
  constexpr int kCount = 400'000;
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  mesh::MassProperties sum;
  for (const SolidShape& shape : shapes)
    for (int i = 0; i < kCount; ++i) {
      const double x = draw(engine), y = draw(engine), z = draw(engine);
      const Vector3d own_m = shape.half_m.cwiseProduct(Vector3d(x, y, z));
      const bool is_in = shape.kind == Kind::kSphere
                             ? own_m.norm() < shape.half_m.x()
                             : collision::sample(field_of(shape)->view(), own_m)->distance_m < 0.0;
      if (!is_in) continue;
      const Vector3d at_m = shape.position_m + shape.orientation * own_m;
      const double volume_m3 = 8.0 * shape.half_m.prod() / kCount;
      sum.volume_m3 += volume_m3;
      sum.centre_m += volume_m3 * at_m;
      sum.inertia_per_kg_m2 +=
          volume_m3 * (at_m.squaredNorm() * Eigen::Matrix3d::Identity() - at_m * at_m.transpose());
    }
  sum.centre_m /= sum.volume_m3;
  const Vector3d& c = sum.centre_m;
  sum.inertia_per_kg_m2 /= sum.volume_m3;
  sum.inertia_per_kg_m2 -= c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose();
  return sum;
}

}  // namespace

TEST_CASE("Two halves of a box turn as the box does", "[compound]") {
  const Vector3d size_m(0.03, 0.05, 0.07), half_m(0.03, 0.05, 0.035);
  const double mass_kg = 0.4;
  const World world = world_of(compound({0.1, 0.2, 0.3},
                                        {solid(Kind::kBox, half_m, {0.0, 0.0, 0.0175}),
                                         solid(Kind::kBox, half_m, {0.0, 0.0, -0.0175})},
                                        mass_kg));
  const RigidBody& body = world.rigid_bodies.at(0);
  const Eigen::Array3d squares = size_m.array().square();
  CHECK((body.inertia_kg_m2.array() - mass_kg / 12.0 * (squares.sum() - squares)).abs().maxCoeff() <
        1e-12);
  CHECK((body.position_m - Vector3d(0.1, 0.2, 0.3)).norm() < 1e-12);
  CHECK(body.orientation.isApprox(Eigen::Quaterniond::Identity()));
}

TEST_CASE("A dumbbell of two spheres has the inertia of its closed form", "[compound]") {
  const double mass_kg = 0.6, radius_m = 0.02, arm_m = 0.05;
  const Vector3d size_m = Vector3d::Constant(2.0 * radius_m);
  const World world = world_of(compound(
      {0, 0, 0},
      {solid(Kind::kSphere, size_m, {arm_m, 0, 0}), solid(Kind::kSphere, size_m, {-arm_m, 0, 0})},
      mass_kg));
  const double own = 0.4 * mass_kg * radius_m * radius_m, across = own + mass_kg * arm_m * arm_m;
  CHECK((world.rigid_bodies.at(0).inertia_kg_m2 - Vector3d(own, across, across)).norm() < 1e-12);
  CHECK(world.fields.empty());
  CHECK(world.spheres.size() == 2);
  CHECK_FALSE(world.spheres[0].is_field_point);
}

TEST_CASE("Mass properties are those of points strewn in the shapes", "[compound]") {
  SolidShape tilted = solid(Kind::kCapsule, {0.02, 0.02, 0.06}, {0.03, 0.01, 0.02});
  tilted.orientation = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.1).normalized();
  const std::vector<SolidShape> shapes = {tilted,
                                          solid(Kind::kCylinder, {0.04, 0.04, 0.01}, {0, 0, -0.05}),
                                          solid(Kind::kBox, {0.01, 0.02, 0.03}, {-0.04, 0, 0}),
                                          solid(Kind::kSphere, {0.02, 0.02, 0.02}, {0, -0.06, 0})};
  std::vector<std::vector<SolidShape>> tried = {shapes};
  for (const SolidShape& shape : shapes) tried.push_back({shape});
  for (const std::vector<SolidShape>& some : tried) {
    const mesh::MassProperties own = mass_properties(some), strewn = by_points(some);
    CHECK(own.volume_m3 == Approx(strewn.volume_m3).epsilon(3e-3));
    CHECK((own.centre_m - strewn.centre_m).norm() < 1e-4);
    CHECK((own.inertia_per_kg_m2 - strewn.inertia_per_kg_m2).norm() <
          5e-3 * own.inertia_per_kg_m2.norm());
  }
}

TEST_CASE("Shapes stand in the world where the scene poses them, whatever the principal axes",
          "[compound]") {
  std::vector<SolidShape> shapes = {
      solid(Kind::kBox, {0.05, 0.01, 0.01}, {0.02, 0.01, 0.0}),
      solid(Kind::kCylinder, {0.01, 0.01, 0.04}, {-0.01, 0.02, 0.03})};
  const bool is_static = GENERATE(false, true);
  BodyDescription body = sim_server::body_of(PlaneBody{}, 0.2, {0.3, -0.1, 0.2});
  body.motion = is_static ? Motion::kStatic : Motion::kFree;
  body.orientation = Eigen::Quaterniond(0.5, 0.1, -0.3, 0.8).normalized();
  const Eigen::Vector3d origin_m = body.position_m;
  const Eigen::Quaterniond turn = body.orientation;
  body.shape = compound_of(shapes, body);
  const World world = world_of(body);
  REQUIRE(world.fields.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const FieldBody& field = world.fields[i];
    Eigen::Vector3d at_m = field.position_m;
    Eigen::Quaterniond stands = field.orientation;
    if (!is_static) {
      const RigidBody& rigid = world.rigid_bodies.at(0);
      at_m = rigid.position_m + rigid.orientation * at_m;
      stands = rigid.orientation * stands;
    }
    CHECK((at_m - (origin_m + turn * shapes[i].position_m)).norm() < 1e-12);
    CHECK(stands.angularDistance(turn * shapes[i].orientation) < 1e-7);
  }
  CHECK(world.static_points.empty() == !is_static);
  CHECK(world.spheres.empty() == is_static);
}

TEST_CASE("Contact balls touch the surface from inside, and hidden ones are left out",
          "[compound]") {
  const auto kind = GENERATE(Kind::kBox, Kind::kCapsule, Kind::kCylinder);
  const SolidShape shape = solid(kind, {0.02, 0.02, 0.05});
  for (const spheres::Ball& ball : contact_balls(shape)) {
    const double distance_m = collision::sample(field_of(shape)->view(), ball.centre_m)->distance_m;
    CHECK(distance_m == Approx(-ball.radius_m).margin(1e-9));
  }
  const BodyDescription body =
      compound({0, 0, 0}, {shape, solid(Kind::kSphere, {0.2, 0.2, 0.2})}, 1.0);
  CHECK(world_of(body).spheres.size() == 1);
}

}  // namespace stillgrid::bodies::compound_test
