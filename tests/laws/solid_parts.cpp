#include "tests/laws/solid_parts.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::laws {
namespace {

std::string box_shape(const Eigen::Vector3d& size_m, double x_m) {
  return "{ kind = \"box\", size_m = [" + short_number(size_m.x()) + ", " +
         short_number(size_m.y()) + ", " + short_number(size_m.z()) + "], position_m = [" +
         short_number(x_m) + ", 0.0, 0.0] }";
}

}  // namespace

SceneSection& add_held_body(SceneText& scene, Random& random, const std::string& name,
                            bool may_be_free) {
  SceneSection& body = scene.add("[[body]]");
  body.text("name", name);
  body.text("material", "m0");
  if (may_be_free && random.chance(0.2))
    body.set("mass_kg", "10000000.0");
  else
    body.text("motion", "static");
  return body;
}

std::string draw_packing(Random& random, double height_m) {
  const double radius_m = std::min(0.5 * height_m, random.between(0.0015, 0.003));
  return "{ spacing_m = " + short_number(radius_m * random.between(0.5, 1.0)) +
         ", radius_m = " + short_number(0.999 * radius_m) + " }";
}

void add_solid_box(SceneText& scene, Random& random, const std::string& name, BoxKind kind,
                   const Eigen::Vector3d& middle_m, const Eigen::Vector3d& size_m,
                   bool may_be_free) {
  if (kind == BoxKind::kPlane) {
    SceneSection& plane = scene.add("[[body]]");
    plane.text("name", name);
    plane.text("material", "m0");
    plane.text("kind", "plane");
    plane.vector("point_m", middle_m + Eigen::Vector3d(0.0, 0.0, 0.5 * size_m.z()));
    plane.set("normal", "[0.0, 0.0, 1.0]");
    return;
  }
  SceneSection& body = add_held_body(scene, random, name, may_be_free);
  body.vector("position_m", middle_m);
  if (kind == BoxKind::kCompound) {
    const Eigen::Vector3d half_m(0.5 * size_m.x(), size_m.y(), size_m.z());
    body.text("kind", "compound");
    body.set("shape", "[" + box_shape(half_m, -0.25 * size_m.x()) + ", " +
                          box_shape(half_m, 0.25 * size_m.x()) + "]");
    return;
  }
  body.text("kind", "rigid_box");
  body.vector("size_m", size_m);
  if (kind == BoxKind::kSpheres) body.set("spheres", draw_packing(random, size_m.z()));
}

BoxKind draw_sharp_kind(Random& random) {
  return random.chance(0.5) ? BoxKind::kExact : BoxKind::kCompound;
}

BoxKind draw_box_kind(Random& random, bool may_be_plane) {
  const double share = random.between(0.0, 1.0);
  if (share < 0.5) return BoxKind::kSpheres;
  if (share < 0.7) return BoxKind::kExact;
  return share < 0.9 || !may_be_plane ? BoxKind::kCompound : BoxKind::kPlane;
}

SolidTool draw_solid_tool(SceneText& scene, Random& random, double friction, bool may_be_two) {
  const SolidTool tool{random.between(0.003, 0.008), random.over_decades(100.0, 2000.0)};
  SceneSection& section = scene.section("[tool]");
  if (may_be_two && random.chance(0.3)) {
    const std::string end = short_number(tool.radius_m) + " }";
    const std::string out = short_number(1.1 * tool.radius_m);
    section.set("spheres", "[{ position_m = [0.0, -" + out + ", 0.0], radius_m = " + end +
                               ", { position_m = [0.0, " + out + ", 0.0], radius_m = " + end + "]");
  } else {
    section.number("radius_m", tool.radius_m);
  }
  SceneSection& material = scene.add("[[material]]");
  material.text("name", "m0");
  material.number("contact_stiffness_N_per_m", tool.stiffness_N_per_m);
  if (friction > 0.0) material.number("friction", friction);
  return tool;
}

Hand draw_solid_hand(Random& random, HandKind kind, const SolidTool& tool, double depth_m) {
  constexpr double kClear_m = 0.001;
  return {.kind = kind,
          .centre_m = {0.0, 0.0, tool.radius_m + kClear_m},
          .depth_m = kClear_m + depth_m,
          .amplitude_m = random.between(0.002, 0.006),
          .period_s = random.over_decades(0.3, 0.8)};
}

double draw_depth_m(Random& random) {
  return random.between(0.004, 0.006);
}

}  // namespace stillgrid::laws
