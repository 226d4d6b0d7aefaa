#include "sim_server/contact/start_warnings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <variant>

#include "sim_server/contact/start_overlaps.hpp"

namespace stillgrid::contact {
namespace {

constexpr double kLongest_m = 10.0, kShortest_m = 1e-3;  // of a body
constexpr double kFastest_m_s = 50.0;
constexpr double kFarthest_m = 1000.0;  // floats are 60 um apart beyond
constexpr double kHeaviest_kg = 50.0;
constexpr double kLargestTool_m = 0.1;  // a radius, in lengths of the device
constexpr double kSoftest_N_per_m = 1.0, kStiffest_N_per_m = 1e6;
constexpr double kRoughest = 2.0;  // rubber on rubber: 1.2
constexpr std::size_t kMaxLines = 10;

[[gnu::format(printf, 1, 2)]] std::string print(const char* format, ...) {
  std::array<char, 300> text{};
  va_list values;
  va_start(values, format);
  std::vsnprintf(text.data(), text.size(), format, values);
  va_end(values);
  return text.data();
}

/// The spheres of one body at the start.
struct Shape {
  Eigen::AlignedBox3d centres_m;
  double radius_m = 0.0;                                        // the largest
  double smallest_m = std::numeric_limits<double>::infinity();  // radius, without field points
  std::vector<double> highest_m;                                // of a centre above each plane
};

std::vector<Shape> shapes_of(const bodies::World& world) {
  std::vector<Shape> shapes(world.bodies.size());
  const auto include = [&](int body, const Eigen::Vector3d& at_m, double radius_m) {
    Shape& shape = shapes[static_cast<std::size_t>(body)];
    shape.centres_m.extend(at_m);
    shape.radius_m = std::max(shape.radius_m, radius_m);
    shape.highest_m.resize(world.planes.size(), -std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < world.planes.size(); ++i)
      shape.highest_m[i] =
          std::max(shape.highest_m[i], world.planes[i].normal.dot(at_m) - world.planes[i].offset_m);
  };
  const auto include_sphere = [&](int body, const Eigen::Vector3d& at_m, double radius_m) {
    include(body, at_m, radius_m);
    double& smallest_m = shapes[static_cast<std::size_t>(body)].smallest_m;
    smallest_m = std::min(smallest_m, radius_m);
  };
  for (const bodies::SphereBinding& sphere : world.spheres) {
    if (sphere.is_field_point)
      include(sphere.body, sphere.rest_position_m, sphere.radius_m);
    else
      include_sphere(sphere.body, sphere.rest_position_m, sphere.radius_m);
  }
  for (const bodies::StaticSphere& sphere : world.static_spheres)
    include_sphere(sphere.body, sphere.position_m, sphere.radius_m);
  for (const bodies::StaticSphere& point : world.static_points)
    include(point.body, point.position_m, point.radius_m);
  return shapes;
}

double speed_m_s(const bodies::BodyDescription& body) {
  if (body.motion == bodies::Motion::kFree) return body.velocity_m_s.norm();
  if (body.motion == bodies::Motion::kStatic) return 0.0;
  return body.prescribed.highest_speed_m_s();
}

class Warnings {
 public:
  Warnings(const scene::SceneDescription& scene, const std::string& file)
      : scene_(scene), file_(file) {}

  void add(int body, const std::string& what) {
    const bodies::BodyDescription& of = scene_.bodies[static_cast<std::size_t>(body)];
    add(print(":%u: body '%s'", of.line, of.name.c_str()), what);
  }

  void add(const std::string& subject, const std::string& what) {
    ++count_;
    if (has_room()) lines_.push_back(file_ + subject + ": " + what);
  }

  /// Whether a line more would be shown: what is only counted need not say what it is.
  [[nodiscard]] bool has_room() const { return lines_.size() < kMaxLines; }

  [[nodiscard]] std::string name(int body) const {
    return "'" + scene_.bodies[static_cast<std::size_t>(body)].name + "'";
  }

  [[nodiscard]] std::vector<std::string> lines() && {
    if (count_ > lines_.size())
      lines_.push_back(file_ + ": and " + std::to_string(count_ - lines_.size()) +
                       " more of the kind");
    return std::move(lines_);
  }

 private:
  const scene::SceneDescription& scene_;
  const std::string& file_;
  std::vector<std::string> lines_;
  std::size_t count_ = 0;
};

void warn_of_shape(const scene::SceneDescription& scene, const bodies::World& world, int number,
                   const Shape& shape, Warnings& warnings) {
  const bodies::BodyDescription& body = scene.bodies[static_cast<std::size_t>(number)];
  if (body.mass_kg > kHeaviest_kg)
    warnings.add(number, print("mass_kg %.3g: no hand moves that: masses are in kg", body.mass_kg));
  if (speed_m_s(body) > kFastest_m_s)
    warnings.add(number, print("moves at %.3g m/s: speeds are in m/s", speed_m_s(body)));
  if (shape.highest_m.empty() && shape.centres_m.isEmpty()) return;
  const double side_m = shape.centres_m.sizes().maxCoeff() + 2.0 * shape.radius_m;
  if (side_m > kLongest_m || side_m < kShortest_m)
    warnings.add(number, print("is %.3g m long: lengths are in m", side_m));
  const double far_m = std::max(shape.centres_m.min().cwiseAbs().maxCoeff(),
                                shape.centres_m.max().cwiseAbs().maxCoeff());
  if (far_m > kFarthest_m)
    warnings.add(number, print("is %.3g m from the origin: snapshots are in floats, there %.2g mm "
                               "apart, and forces as coarse",
                               far_m, 1e3 * far_m * std::numeric_limits<float>::epsilon()));
  if (body.motion != bodies::Motion::kFree) return;
  for (std::size_t i = 0; i < shape.highest_m.size(); ++i)
    if (shape.highest_m[i] < -shape.radius_m)
      warnings.add(number, print("lies %.3g m below plane ", -shape.highest_m[i]) +
                               warnings.name(world.planes[i].body) +
                               ", behind its normal: the plane will throw it out");
}

/// Returns what a cover by spheres of one radius was asked for; none: the body has no such cover.
std::optional<bodies::SpherePacking> packing_of(const bodies::BodyDescription& body) {
  return std::visit(
      [](const auto& shape) -> std::optional<bodies::SpherePacking> {
        if constexpr (requires { shape.spheres.spacing_m; })
          return shape.spheres;
        else
          return std::nullopt;
      },
      body.shape);
}

/// Returns the radius of the largest ball that passes between neighbouring spheres of a cover
/// without contact; negative if none does.
double hole_radius_m(const bodies::BodyDescription& body) {
  const auto packing = packing_of(body);
  if (!packing) return -1.0;
  const bool is_thread = std::holds_alternative<bodies::ThreadBody>(body.shape);
  return packing->spacing_m * (is_thread ? 0.5 : std::numbers::sqrt2 / 2.0) - packing->radius_m;
}

/// Warns of covers that a sphere of a tool or of another body passes through.
void warn_of_holes(const scene::SceneDescription& scene, const std::vector<Shape>& shapes,
                   Warnings& warnings) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double tool_m = kNone;
  for (const scene::Hand& hand : scene::hands_of(scene))
    for (const scene::ToolSphere& sphere : hand.tool) tool_m = std::min(tool_m, sphere.radius_m);
  std::array<double, 2> smallest_m = {kNone, kNone};  // of all bodies, and without that body
  for (const Shape& shape : shapes)
    if (shape.smallest_m < smallest_m[1])
      smallest_m = {std::min(smallest_m[0], shape.smallest_m),
                    std::max(smallest_m[0], shape.smallest_m)};
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const bool is_smallest = shapes[i].smallest_m == smallest_m[0];
    const double passing_m = std::min(tool_m, smallest_m[is_smallest ? 1 : 0]);
    if (hole_radius_m(scene.bodies[i]) >= passing_m)
      warnings.add(
          static_cast<int>(i),
          print("has holes: a sphere of radius %.3g m passes between its spheres: expected "
                "spacing_m at most their radius, %.3g",
                passing_m, shapes[i].radius_m));
  }
}

void warn_of_overlaps(const bodies::World& world, const std::vector<Shape>& shapes,
                      Warnings& warnings) {
  std::map<std::pair<int, int>, Overlap> deepest;  // by body, and the other where it moves
  for (const Overlap& overlap : deep_overlaps(world)) {
    const Shape& shape = shapes[static_cast<std::size_t>(overlap.body)];
    if (overlap.plane >= 0 &&
        shape.highest_m[static_cast<std::size_t>(overlap.plane)] < -shape.radius_m)
      continue;  // said already
    Overlap& known = deepest[{overlap.body, overlap.other_moves ? overlap.other : -1}];
    if (overlap.depth_m > known.depth_m) known = overlap;
  }
  for (const auto& [bodies, overlap] : deepest) {
    if (!warnings.has_room()) {
      warnings.add(bodies.first, {});
      continue;
    }
    warnings.add(
        bodies.first,
        print("overlaps ") +
            (overlap.other == bodies.first ? "itself" : "body " + warnings.name(overlap.other)) +
            print(" by %.3g m at the start: they will burst apart", overlap.depth_m));
  }
}

void warn_of_materials(const scene::SceneDescription& scene, Warnings& warnings) {
  for (const scene::MaterialDescription& material : scene.materials) {
    const std::string subject = print(": material '%s'", material.name.c_str());
    const double stiffness_N_per_m = material.contact_stiffness_N_per_m;
    if (stiffness_N_per_m < kSoftest_N_per_m || stiffness_N_per_m > kStiffest_N_per_m)
      warnings.add(subject, print("contact_stiffness_N_per_m %.3g: devices render 10 to 10000 N/m",
                                  stiffness_N_per_m));
    if (material.friction > kRoughest)
      warnings.add(subject,
                   print("friction %.3g: a coefficient, of rubber 1.2", material.friction));
  }
}

void warn_of_tools(const scene::SceneDescription& scene, Warnings& warnings) {
  for (const scene::Hand& hand : scene::hands_of(scene)) {
    double radius_m = 0.0;
    for (const scene::ToolSphere& sphere : hand.tool)
      radius_m = std::max(radius_m, sphere.radius_m);
    if (radius_m > kLargestTool_m * hand.device.scale)
      warnings.add(hand.name.empty() ? ": tool" : print(": hand '%s': tool", hand.name.c_str()),
                   print("radius_m %.3g: larger than a hand: lengths are in m", radius_m));
  }
}

}  // namespace

std::vector<std::string> start_warnings(const scene::SceneDescription& scene,
                                        const bodies::World& world, const std::string& file) {
  Warnings warnings(scene, file);
  warn_of_tools(scene, warnings);
  warn_of_materials(scene, warnings);
  const std::vector<Shape> shapes = shapes_of(world);
  for (std::size_t i = 0; i < shapes.size(); ++i)
    warn_of_shape(scene, world, static_cast<int>(i), shapes[i], warnings);
  warn_of_holes(scene, shapes, warnings);
  warn_of_overlaps(world, shapes, warnings);
  return std::move(warnings).lines();
}

std::vector<std::string> cover_warnings(const scene::SceneDescription& scene,
                                        const std::string& file) {
  Warnings warnings(scene, file);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const auto packing = packing_of(scene.bodies[i]);
    if (!packing || packing->spacing_m <= packing->radius_m * (1.0 + 1e-9)) continue;
    warnings.add(
        static_cast<int>(i),
        print("spacing_m %.3g is greater than radius_m %.3g: there may be dips between its "
              "spheres, and holes that a small sphere passes",
              packing->spacing_m, packing->radius_m));
  }
  return std::move(warnings).lines();
}

}  // namespace stillgrid::contact
