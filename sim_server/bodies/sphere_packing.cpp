#include "sim_server/bodies/sphere_packing.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid {
namespace {

/// Spheres along a length, ends included.
double spheres_along(double length_m, double spacing_m) {
  return std::max(1.0, std::round(length_m / spacing_m) + 1.0);
}
int count_along(double length_m, double spacing_m) {
  return static_cast<int>(spheres_along(length_m, spacing_m));
}

/// Spacing and radius as described, or as suits the body.
SpherePacking packing_of(const BodyDescription& body) {
  SpherePacking packing = body.spheres;
  const auto default_to = [&](double spacing_m, double radius_per_spacing) {
    if (packing.spacing_m <= 0.0) packing.spacing_m = spacing_m;
    if (packing.radius_m <= 0.0) packing.radius_m = radius_per_spacing * packing.spacing_m;
  };
  if (body.kind == BodyKind::kThread)
    default_to((body.to_m - body.from_m).norm() / (body.nodes.x() - 1), 0.75);
  if (body.kind == BodyKind::kSheet)
    default_to(
        std::min(body.size_m.x() / (body.nodes.x() - 1), body.size_m.y() / (body.nodes.y() - 1)),
        0.75);
  if (body.kind == BodyKind::kRigidBox || body.kind == BodyKind::kSoftBlock)
    default_to(body.size_m.minCoeff() / 3.0, 0.5);
  return packing;
}

/// Edge lengths between the centres of a box's outermost spheres.
Eigen::Vector3d inner_size_m(const BodyDescription& body, double radius_m) {
  return (body.size_m.array() - 2.0 * radius_m).max(0.0).matrix();
}

/// The i-th of n equal steps through [low, high]; the middle when there is one only.
double spread(int i, int n, double low, double high) {
  return n > 1 ? low + (high - low) * i / (n - 1) : 0.5 * (low + high);
}

struct LinePoint {
  int lower;        // node below
  double fraction;  // towards the next
};

LinePoint among_nodes(int i, int spheres, int nodes) {
  const double place = spread(i, spheres, 0.0, nodes - 1.0);
  const int lower = std::clamp(static_cast<int>(std::floor(place)), 0, std::max(0, nodes - 2));
  return {lower, place - lower};
}

SphereBinding blank(const BodyDescription& body, double radius_m) {
  SphereBinding sphere;
  sphere.material = body.material;
  sphere.radius_m = radius_m;
  return sphere;
}

void bind(SphereBinding& sphere, int node, double weight) {
  if (weight == 0.0) return;
  const auto slot = static_cast<std::size_t>(sphere.node_count++);
  sphere.nodes[slot] = node;
  sphere.weights[slot] = weight;
}

std::vector<SphereBinding> pack_thread(const BodyDescription& body) {
  const double length_m = (body.to_m - body.from_m).norm();
  const auto [spacing_m, radius_m] = packing_of(body);
  const int count = count_along(length_m, spacing_m);
  std::vector<SphereBinding> spheres;
  for (int i = 0; i < count; ++i) {
    SphereBinding sphere = blank(body, radius_m);
    const auto [lower, t] = among_nodes(i, count, body.nodes.x());
    bind(sphere, lower, 1.0 - t);
    bind(sphere, lower + 1, t);
    sphere.rest_position_m = body.from_m + spread(i, count, 0.0, 1.0) * (body.to_m - body.from_m);
    spheres.push_back(sphere);
  }
  return spheres;
}

std::vector<SphereBinding> pack_sheet(const BodyDescription& body) {
  const int nx = body.nodes.x(), ny = body.nodes.y();
  const double radius_m = packing_of(body).radius_m;
  const Eigen::Vector2i along = sheet_spheres(body);
  const int columns = along.x(), rows = along.y();
  std::vector<SphereBinding> spheres;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      SphereBinding sphere = blank(body, radius_m);
      const auto [x, u] = among_nodes(i, columns, nx);
      const auto [y, v] = among_nodes(j, rows, ny);
      bind(sphere, x + nx * y, (1.0 - u) * (1.0 - v));
      bind(sphere, x + 1 + nx * y, u * (1.0 - v));
      bind(sphere, x + nx * (y + 1), (1.0 - u) * v);
      bind(sphere, x + 1 + nx * (y + 1), u * v);
      const Eigen::Vector3d local(spread(i, columns, -0.5, 0.5) * body.size_m.x(),
                                  spread(j, rows, -0.5, 0.5) * body.size_m.y(), 0.0);
      sphere.rest_position_m = body.position_m + body.orientation * local;
      spheres.push_back(sphere);
    }
  return spheres;
}

/// A sphere at its place in a solid: on the nodes round it, or fixed in a rigid body.
SphereBinding in_body(const BodyDescription& body, const Ball& ball) {
  SphereBinding sphere = blank(body, ball.radius_m);
  sphere.rest_position_m = body.position_m + body.orientation * ball.centre_m;
  if (body.lattice.nodes_m.empty()) {
    sphere.local_m = ball.centre_m;
    return sphere;
  }
  const LatticePoint point = bind_to_lattice(body.lattice, ball.centre_m);
  for (std::size_t i = 0; i < point.nodes.size(); ++i)
    bind(sphere, point.nodes[i], point.weights[i]);
  return sphere;
}

std::vector<SphereBinding> pack_box(const BodyDescription& body) {
  const auto [spacing_m, radius_m] = packing_of(body);
  const Eigen::Vector3d inner_m = inner_size_m(body, radius_m);
  Eigen::Vector3i counts;
  for (int axis = 0; axis < 3; ++axis) counts[axis] = count_along(inner_m[axis], spacing_m);
  const auto along = [&](int i, int axis) {
    return spread(i, counts[axis], -0.5, 0.5) * inner_m[axis];
  };
  std::vector<SphereBinding> spheres;
  for (int z = 0; z < counts.z(); ++z)
    for (int y = 0; y < counts.y(); ++y)
      for (int x = 0; x < counts.x(); ++x) {
        spheres.push_back(in_body(body, {{along(x, 0), along(y, 1), along(z, 2)}, radius_m}));
      }
  return spheres;
}

std::vector<SphereBinding> pack_mesh(const BodyDescription& body) {
  std::vector<SphereBinding> spheres;
  for (const Ball& ball : body.balls) spheres.push_back(in_body(body, ball));
  return spheres;
}

}  // namespace

std::vector<SphereBinding> pack_spheres(const BodyDescription& body) {
  switch (body.kind) {
    case BodyKind::kThread:
      return pack_thread(body);
    case BodyKind::kSheet:
      return pack_sheet(body);
    case BodyKind::kRigidBox:
    case BodyKind::kSoftBlock:
      return pack_box(body);
    case BodyKind::kMesh:
      return pack_mesh(body);
    case BodyKind::kSphere: {
      SphereBinding sphere = blank(body, body.radius_m);
      sphere.rest_position_m = body.position_m;
      return {sphere};
    }
    case BodyKind::kPlane:
      break;
  }
  return {};
}

Eigen::Vector2i sheet_spheres(const BodyDescription& body) {
  const double spacing_m = packing_of(body).spacing_m;
  return {count_along(body.size_m.x(), spacing_m), count_along(body.size_m.y(), spacing_m)};
}

double sphere_count(const BodyDescription& body) {
  const auto [spacing_m, radius_m] = packing_of(body);
  const auto along = [spacing_m = spacing_m](double length_m) {
    return spheres_along(length_m, spacing_m);
  };
  switch (body.kind) {
    case BodyKind::kThread:
      return along((body.to_m - body.from_m).norm());
    case BodyKind::kSheet:
      return along(body.size_m.x()) * along(body.size_m.y());
    case BodyKind::kMesh:
      return static_cast<double>(body.balls.size());
    case BodyKind::kRigidBox:
    case BodyKind::kSoftBlock: {
      const Eigen::Vector3d inner_m = inner_size_m(body, radius_m);
      return along(inner_m.x()) * along(inner_m.y()) * along(inner_m.z());
    }
    case BodyKind::kSphere:
      return 1.0;
    case BodyKind::kPlane:
      break;
  }
  return 0.0;
}

}  // namespace stillgrid
