#include "sim_server/mesh/mesh_distance.hpp"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>  // Debian 12
#endif

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::mesh {
namespace {

/// Where on a triangle: its face, edge i from corner i to the next, or corner i.
struct Feature {
  enum Kind { kFace, kEdge, kCorner } kind = kFace;
  int index = 0;
};

struct TrianglePoint {
  Eigen::Vector3d point;
  Feature feature;
};

/// The nearest point of a segment.
double along(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& p) {
  const Eigen::Vector3d ab = b - a;
  const double length_squared = ab.squaredNorm();
  return length_squared > 0.0 ? std::clamp((p - a).dot(ab) / length_squared, 0.0, 1.0) : 0.0;
}

/// The nearest point of a triangle, by regions [Ericson, Real-Time Collision Detection, 5.1.5]; of
/// one without area, that of its edges.
TrianglePoint closest_of(const std::array<Eigen::Vector3d, 3>& corners, const Eigen::Vector3d& p) {
  const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double area_squared = normal.squaredNorm();
  if (area_squared > 0.0) {
    const Eigen::Vector3d in_plane = p - normal * ((p - corners[0]).dot(normal) / area_squared);
    bool inside = true;
    for (std::size_t i = 0; i < 3 && inside; ++i)
      inside = (corners[(i + 1) % 3] - corners[i]).cross(in_plane - corners[i]).dot(normal) > 0.0;
    if (inside) return {in_plane, {Feature::kFace, 0}};
  }
  TrianglePoint best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d &a = corners[i], &b = corners[(i + 1) % 3];
    const double t = along(a, b, p);
    const Eigen::Vector3d point = a + t * (b - a);
    const double distance = (point - p).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    const int k = static_cast<int>(i);
    best = {point, t <= 0.0   ? Feature{Feature::kCorner, k}
                   : t >= 1.0 ? Feature{Feature::kCorner, (k + 1) % 3}
                              : Feature{Feature::kEdge, k}};
  }
  return best;
}

std::uint64_t edge_key(int a, int b) {
  const auto [low, high] = std::minmax(a, b);
  return static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high);
}

double angle_at(const Eigen::Vector3d& corner, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d u = a - corner, v = b - corner;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// Embree keeps floats; in units of the box its boxes are this near the truth.
constexpr double kFloatSlack = 2e-6;

}  // namespace

struct MeshDistance::Tree {
  TriangleMesh mesh;
  std::vector<Eigen::Vector3d> face_normals, vertex_normals;
  std::vector<std::array<Eigen::Vector3d, 3>> edge_normals;  // of corner i to the next
  Eigen::AlignedBox3d box;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double to_unit = 1.0;  // metres to the units of Embree's scene
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  explicit Tree(const TriangleMesh& closed) : mesh(closed) {
    make_normals();
    make_scene();
    if (realtime::stop_requested()) {
      release();
      realtime::throw_if_stopped();
    }
  }
  ~Tree() { release(); }
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;

  [[nodiscard]] std::array<Eigen::Vector3d, 3> corners_of(std::size_t triangle) const;
  void make_normals();
  void make_scene();
  void release() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  [[nodiscard]] NearestPoint closest(const Eigen::Vector3d& point_m) const;
  [[nodiscard]] Eigen::Vector3d normal_at(std::size_t triangle, Feature feature) const;
  /// No point of the triangle is nearer; of a sliver, whose plane rounding may turn, none that is
  /// not its neighbour's too.
  [[nodiscard]] double plane_distance_m(std::size_t triangle,
                                        const Eigen::Vector3d& point_m) const {
    const auto corner = static_cast<std::size_t>(mesh.triangles[triangle][0]);
    return std::abs(face_normals[triangle].dot(point_m - mesh.vertices_m[corner]));
  }
};

std::array<Eigen::Vector3d, 3> MeshDistance::Tree::corners_of(std::size_t triangle) const {
  const Eigen::Vector3i& t = mesh.triangles[triangle];
  const auto& vertices = mesh.vertices_m;
  return {vertices[static_cast<std::size_t>(t[0])], vertices[static_cast<std::size_t>(t[1])],
          vertices[static_cast<std::size_t>(t[2])]};
}

void MeshDistance::Tree::make_normals() {
  vertex_normals.assign(mesh.vertices_m.size(), Eigen::Vector3d::Zero());
  std::unordered_map<std::uint64_t, Eigen::Vector3d> of_edge;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    realtime::throw_if_stopped();
    const auto corners = corners_of(i);
    face_normals.push_back((corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized());
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = mesh.triangles[i][static_cast<int>(k)];
      const int b = mesh.triangles[i][static_cast<int>((k + 1) % 3)];
      vertex_normals[static_cast<std::size_t>(a)] +=
          angle_at(corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]) * face_normals[i];
      of_edge.try_emplace(edge_key(a, b), Eigen::Vector3d::Zero()).first->second += face_normals[i];
    }
  }
  for (Eigen::Vector3d& normal : vertex_normals) normal.normalize();
  for (const Eigen::Vector3i& t : mesh.triangles)
    edge_normals.push_back({of_edge[edge_key(t[0], t[1])].normalized(),
                            of_edge[edge_key(t[1], t[2])].normalized(),
                            of_edge[edge_key(t[2], t[0])].normalized()});
}

void MeshDistance::Tree::make_scene() {
  box = box_of(mesh);
  centre_m = box.center();
  to_unit = 1.0 / box.sizes().maxCoeff();

  // One thread: the tree, and with it the order of equally near triangles, is always the same.
  device = rtcNewDevice("threads=1,set_affinity=0");
  if (device == nullptr) throw std::runtime_error("Embree: no device");
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices_m.size()));
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  if (vertices == nullptr || indices == nullptr) throw std::bad_alloc();
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    const Eigen::Vector3f vertex = ((mesh.vertices_m[i] - centre_m) * to_unit).cast<float>();
    std::copy(vertex.data(), vertex.data() + 3, vertices + 3 * i);
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      indices[3 * i + k] = static_cast<unsigned>(mesh.triangles[i][static_cast<int>(k)]);
  rtcCommitGeometry(geometry);
  scene = rtcNewScene(device);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  // A large tree takes seconds, which a stop ends.
  rtcSetSceneProgressMonitorFunction(
      scene,
      [](void*, double) { return !realtime::stop_requested().load(std::memory_order_relaxed); },
      nullptr);
  rtcCommitScene(scene);
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  realtime::throw_if_stopped();
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  throw std::runtime_error("Embree: error " + std::to_string(error));
}

Eigen::Vector3d MeshDistance::Tree::normal_at(std::size_t triangle, Feature feature) const {
  const auto k = static_cast<std::size_t>(feature.index);
  if (feature.kind == Feature::kEdge) return edge_normals[triangle][k];
  if (feature.kind == Feature::kCorner)
    return vertex_normals[static_cast<std::size_t>(mesh.triangles[triangle][feature.index])];
  return face_normals[triangle];
}

NearestPoint MeshDistance::Tree::closest(const Eigen::Vector3d& point_m) const {
  assert(point_m.allFinite());
  realtime::throw_if_stopped();
  struct Search {
    const Tree& tree;
    const Eigen::Vector3d& point_m;
    double slack;
    double distance_squared_m2 = std::numeric_limits<double>::infinity();
    double enough_m = std::numeric_limits<double>::infinity();  // no plane beyond it matters
    std::size_t triangle = 0;
    TrianglePoint best{};
  };
  const auto visit = [](RTCPointQueryFunctionArguments* arguments) {
    auto& search = *static_cast<Search*>(arguments->userPtr);
    // Seen from the middle of a ball no box is farther than another, but most planes are.
    if (search.tree.plane_distance_m(arguments->primID, search.point_m) > search.enough_m)
      return false;
    const TrianglePoint found =
        closest_of(search.tree.corners_of(arguments->primID), search.point_m);
    const double squared_m2 = (found.point - search.point_m).squaredNorm();
    if (squared_m2 > search.distance_squared_m2) return false;
    if (squared_m2 == search.distance_squared_m2 && arguments->primID >= search.triangle)
      return false;
    search.distance_squared_m2 = squared_m2;
    search.enough_m =
        (1.0 + kFloatSlack) * std::sqrt(squared_m2) + search.slack / search.tree.to_unit;
    search.triangle = arguments->primID;
    search.best = found;
    const auto radius =
        static_cast<float>(std::sqrt(squared_m2) * search.tree.to_unit + search.slack);
    if (radius >= arguments->query->radius) return false;
    arguments->query->radius = radius;
    return true;
  };
  const Eigen::Vector3d unit = (point_m - centre_m) * to_unit;
  Search search{*this, point_m, kFloatSlack * (1.0 + unit.norm())};
  RTCPointQuery query{static_cast<float>(unit.x()), static_cast<float>(unit.y()),
                      static_cast<float>(unit.z()), 0.0F, std::numeric_limits<float>::infinity()};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &query, &context, visit, &search);
  return {search.best.point, static_cast<int>(search.triangle),
          normal_at(search.triangle, search.best.feature)};
}

std::vector<int> MeshDistance::triangles_near(const Eigen::Vector3d& point_m,
                                              double search_radius_m) const {
  realtime::throw_if_stopped();
  std::vector<int> triangles;
  const Eigen::Vector3d unit = (point_m - tree_->centre_m) * tree_->to_unit;
  const double reach = search_radius_m * tree_->to_unit + kFloatSlack * (1.0 + unit.norm());
  RTCPointQuery query{static_cast<float>(unit.x()), static_cast<float>(unit.y()),
                      static_cast<float>(unit.z()), 0.0F, static_cast<float>(reach)};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const auto visit = [](RTCPointQueryFunctionArguments* arguments) {
    static_cast<std::vector<int>*>(arguments->userPtr)
        ->push_back(static_cast<int>(arguments->primID));
    return false;
  };
  rtcPointQuery(tree_->scene, &query, &context, visit, &triangles);
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

MeshDistance::MeshDistance(const TriangleMesh& closed) : tree_(std::make_unique<Tree>(closed)) {}
MeshDistance::~MeshDistance() = default;
MeshDistance::MeshDistance(MeshDistance&&) noexcept = default;
MeshDistance& MeshDistance::operator=(MeshDistance&&) noexcept = default;

NearestPoint MeshDistance::closest(const Eigen::Vector3d& point_m) const {
  return tree_->closest(point_m);
}

double MeshDistance::signed_distance_m(const Eigen::Vector3d& point_m) const {
  const NearestPoint nearest = tree_->closest(point_m);
  const Eigen::Vector3d away = point_m - nearest.point_m;
  // Of a mesh that cuts itself, normals may say else.
  if (!tree_->box.contains(point_m)) return away.norm();
  return away.dot(nearest.normal) < 0.0 ? -away.norm() : away.norm();
}

}  // namespace stillgrid::mesh
