#include "tests/performance/drawn_tool.hpp"

#include <Eigen/Geometry>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "tests/performance/contact_models.hpp"
#include "tests/sim_server/mesh/solids.hpp"

namespace stillgrid::performance {
namespace {

using Eigen::Vector3d;

constexpr double kTool_m = 0.004, kDepth_m = 0.001;

const Eigen::Matrix3d& tilt() {
  static const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.61, Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  return turn;
}

ModelledMesh modelled(const mesh::TriangleMesh& upright) {
  ModelledMesh of{.name = "",
                  .mesh = mesh::moved(upright, tilt(), Vector3d(0.0031, -0.0017, 0.0023)),
                  .tool_radius_m = kTool_m,
                  .press_depth_m = kDepth_m,
                  .distance = {}};
  of.distance = std::make_shared<const mesh::MeshDistance>(of.mesh);
  return of;
}
Vector3d in_place(const Vector3d& upright_m) {
  return tilt() * upright_m + Vector3d(0.0031, -0.0017, 0.0023);
}

std::vector<ContactModel> models_of(const ModelledMesh& of) {
  return {decomposition_model(of, 0.004), decomposition_model(of, 0.002), even_model(of, 0.004),
          even_model(of, 0.002),          volume_model(of, 0.002),        field_model(of, 0.004),
          field_model(of, 0.002),         field_model(of, 0.001)};
}

/// A block whose section is an L: a floor and a wall, each `thick_m` thick, one mesh.
mesh::TriangleMesh corner_mesh(double length_m, double side_m, double thick_m) {
  const std::vector<Eigen::Vector2d> outline = {
      {0, 0}, {side_m, 0}, {side_m, thick_m}, {thick_m, thick_m}, {thick_m, side_m}, {0, side_m}};
  mesh::TriangleMesh mesh;
  for (const double y_m : {-0.5 * length_m, 0.5 * length_m})
    for (const Eigen::Vector2d& p : outline) mesh.vertices_m.emplace_back(p.x(), y_m, p.y());
  for (int i = 0; i < 6; ++i) {
    const int next = (i + 1) % 6;
    mesh.triangles.emplace_back(i, next, next + 6);
    mesh.triangles.emplace_back(i, next + 6, i + 6);
  }
  for (const Eigen::Vector3i& t : {Eigen::Vector3i(0, 1, 2), {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
  }
  // Whichever way round the outline goes, outwards.
  double volume = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles)
    volume += mesh.vertices_m[static_cast<std::size_t>(t[0])].dot(
        mesh.vertices_m[static_cast<std::size_t>(t[1])].cross(
            mesh.vertices_m[static_cast<std::size_t>(t[2])]));
  if (volume < 0.0)
    for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

constexpr double kLength_m = 0.08, kSide_m = 0.06, kThick_m = 0.015;

/// Spheres in a row, slanting, so that both ends touch: floor and wall of the upright corner.
struct Rod {
  std::vector<Vector3d> spheres_m;  // upright
  Vector3d middle_m = Vector3d::Zero();
};

/// As deep in both walls at its ends, and where its lowest sphere is in the corner itself.
Rod rod_at(double depth_m) {
  constexpr double kRod_m = 0.036;
  constexpr int kSpheres = 9;
  // From the floor near the corner, touching the wall there, up and out, along the corner too.
  const Vector3d low_m(kThick_m + kTool_m - depth_m, -0.01, kThick_m + kTool_m - depth_m);
  const Vector3d along = Vector3d(0.55, 0.75, 0.12).normalized();
  Rod rod;
  for (int i = 0; i < kSpheres; ++i)
    rod.spheres_m.push_back(low_m + (i * kRod_m / (kSpheres - 1)) * along);
  rod.middle_m = low_m + 0.5 * kRod_m * along;
  return rod;
}

struct Wrench {
  Vector3d force_m = Vector3d::Zero(), torque_m2 = Vector3d::Zero();
};

/// Upright forces by the place of a sphere, upright too.
Wrench wrench_on(const Rod& rod, const spheres::UnitForce& force) {
  Wrench sum;
  for (const Vector3d& sphere_m : rod.spheres_m) {
    const Vector3d force_m = force(sphere_m);
    sum.force_m += force_m;
    sum.torque_m2 += (sphere_m - rod.middle_m).cross(force_m);
  }
  return sum;
}

/// Both walls push, each as deep as the sphere is in it.
Vector3d two_walls_m(const Vector3d& sphere_m) {
  return {std::max(0.0, kThick_m + kTool_m - sphere_m.x()), 0.0,
          std::max(0.0, kThick_m + kTool_m - sphere_m.z())};
}

void print_wrench(const char* walls, const ContactModel& model, double depth_m,
                  const Wrench& found) {
  std::printf("%s,%s,%g,%g", walls, model.name.c_str(), 1e3 * model.size_m, 1e3 * depth_m);
  for (const double x_m : found.force_m) std::printf(",%.5g", 1e3 * x_m);
  for (const double x_m2 : found.torque_m2) std::printf(",%.5g", 1e6 * x_m2);
  std::printf("\n");
}

}  // namespace

void print_drawn_tool() {
  const ModelledMesh of = modelled(mesh::box_mesh({0, 0, 0}, {0.06, 0.05, 0.03}));
  const Vector3d up = tilt().col(2);
  std::printf("model,size_mm,along_mm,normal,sideways\n");
  for (const ContactModel& model : models_of(of))
    for (int i = 0; i <= 240; ++i) {
      const double along_m = 0.01 + 0.04 * i / 240.0;
      const Vector3d force_m = model.force(
          in_place({along_m, 0.0183 + 0.31 * (along_m - 0.01), 0.03 + kTool_m - kDepth_m}));
      const double normal_m = force_m.dot(up);
      std::printf("%s,%g,%.4f,%.5f,%.5f\n", model.name.c_str(), 1e3 * model.size_m, 1e3 * along_m,
                  normal_m / kDepth_m, (force_m - normal_m * up).norm() / kDepth_m);
    }
}

void print_rod_in_corner() {
  const ModelledMesh one = modelled(corner_mesh(kLength_m, kSide_m, kThick_m));
  const Vector3d low_m(0, -0.5 * kLength_m, 0), high_m(kSide_m, 0.5 * kLength_m, kSide_m);
  const ModelledMesh floor = modelled(mesh::box_mesh(low_m, {high_m.x(), high_m.y(), kThick_m}));
  const ModelledMesh wall = modelled(mesh::box_mesh(low_m, {kThick_m, high_m.y(), high_m.z()}));
  const std::vector<ContactModel> of_one = models_of(one), of_floor = models_of(floor),
                                  of_wall = models_of(wall);
  std::printf("walls,model,size_mm,depth_mm,fx_mm,fy_mm,fz_mm,tx_mm2,ty_mm2,tz_mm2\n");
  const auto upright = [](const ContactModel& model) -> spheres::UnitForce {
    return [&model](const Vector3d& at_m) -> Vector3d {
      return tilt().transpose() * model.force(in_place(at_m));
    };
  };
  for (int i = 1; i <= 24; ++i) {
    const double depth_m = 0.0001 * i;
    const Rod rod = rod_at(depth_m);
    print_wrench("exact", {"two walls", 0.0, 0, 0.0, {}}, depth_m, wrench_on(rod, two_walls_m));
    for (std::size_t m = 0; m < of_one.size(); ++m) {
      print_wrench("one mesh", of_one[m], depth_m, wrench_on(rod, upright(of_one[m])));
      const auto a = upright(of_floor[m]), b = upright(of_wall[m]);
      print_wrench(
          "two meshes", of_floor[m], depth_m,
          wrench_on(rod, [&](const Vector3d& at_m) -> Vector3d { return a(at_m) + b(at_m); }));
    }
  }
}

}  // namespace stillgrid::performance
