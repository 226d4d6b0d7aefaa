#include "tests/laws/body_draws.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace stillgrid::laws {
namespace {

constexpr double kFastest_rad_s = 2000.0;

std::string braces(std::initializer_list<std::pair<std::string_view, double>> items) {
  std::string text = "{ ";
  for (const auto& [key, value] : items)
    text += (text.size() > 2 ? ", " : "") + std::string(key) + " = " + short_number(value);
  return text + " }";
}

std::string draw_orientation(Random& random) {
  const double half_rad = 0.5 * random.between(-0.6, 0.6);
  const double turn_rad = random.between(0.0, 2.0 * std::numbers::pi);
  const double x = std::sin(half_rad) * std::cos(turn_rad);
  const double y = std::sin(half_rad) * std::sin(turn_rad);
  return "[" + short_number(x) + ", " + short_number(y) + ", 0.0, " +
         short_number(std::cos(half_rad)) + "]";
}

/// Springs of nodes of that mass, damped by a share of critical.
void draw_springs(SceneSection& body, Random& random, const BodyWishes& wishes, double node_kg,
                  bool is_thread) {
  const double fastest_N_per_m = 0.1 * node_kg * kFastest_rad_s * kFastest_rad_s;
  const double structural = std::min(fastest_N_per_m, random.over_decades(30.0, 3000.0));
  body.set("spring_stiffness_N_per_m",
           is_thread ? braces({{"structural", structural}, {"bend", 0.13 * structural}})
                     : braces({{"structural", structural},
                               {"shear", 0.51 * structural},
                               {"bend", 0.13 * structural}}));
  const double share = wishes.undamped ? 0.0
                       : wishes.damped ? random.over_decades(0.1, 1.0)
                                       : random.over_decades(0.01, 1.0);
  if (share > 0.0)
    body.number("spring_damping_N_s_per_m", 2.0 * share * std::sqrt(structural * node_kg));
}

void draw_motion(SceneSection& body, Random& random, const BodyWishes& wishes, double mass_kg,
                 bool may_prescribe) {
  if (may_prescribe && wishes.prescribed && random.chance(0.1)) {
    body.text("motion", "prescribed");
    body.number("amplitude_m", random.between(0.001, 0.006));
    body.number("frequency_hz", random.over_decades(0.3, 6.0));
    body.set("direction", random.one_of({"[1.0, 0.0, 0.0]", "[0.0, 0.6, 0.8]", "[0.0, 0.0, 1.0]"}));
    return;
  }
  if (wishes.still && random.chance(0.12)) {
    body.text("motion", "static");
    return;
  }
  body.number("mass_kg", mass_kg);
  if (wishes.moving && random.chance(0.15))
    body.vector("velocity_m_s",
                {random.between(-0.3, 0.3), random.between(-0.3, 0.3), random.between(-0.5, 0.1)});
}

double draw_sheet(SceneSection& body, Random& random, const BodyWishes& wishes, double mass_kg,
                  const Eigen::Vector3d& place_m) {
  const auto x = static_cast<int>(3 + random.index(4)), y = static_cast<int>(3 + random.index(3));
  const double width_m = random.between(0.03, 0.06), length_m = random.between(0.03, 0.05);
  body.text("kind", "sheet");
  body.set("nodes", "[" + std::to_string(x) + ", " + std::to_string(y) + "]");
  body.set("size_m", "[" + short_number(width_m) + ", " + short_number(length_m) + "]");
  body.vector("position_m", place_m);
  const double radius_m = random.between(0.003, 0.005);
  body.set("spheres", braces({{"spacing_m", 1.9 * radius_m}, {"radius_m", radius_m}}));
  if (wishes.pinned) body.text("pinned", random.one_of({"corners", "edges", "two_corners", "top"}));
  body.number("mass_kg", mass_kg);
  draw_springs(body, random, wishes, mass_kg / (x * y), false);
  return radius_m;
}

double draw_thread(SceneSection& body, Random& random, const BodyWishes& wishes, double mass_kg,
                   const Eigen::Vector3d& place_m) {
  const auto nodes = static_cast<int>(3 + random.index(6));
  const Eigen::Vector3d half_m(random.between(0.012, 0.03), random.between(-0.01, 0.01),
                               random.between(-0.004, 0.004));
  body.text("kind", "thread");
  body.set("nodes", std::to_string(nodes));
  body.vector("from_m", place_m - half_m);
  body.vector("to_m", place_m + half_m);
  const double radius_m = random.between(0.003, 0.005);
  body.set("spheres", braces({{"spacing_m", 1.9 * radius_m}, {"radius_m", radius_m}}));
  if (wishes.pinned) body.text("pinned", random.one_of({"start", "end", "both", "both"}));
  body.number("mass_kg", mass_kg);
  draw_springs(body, random, wishes, mass_kg / nodes, true);
  return radius_m;
}

double draw_box(SceneSection& body, Random& random, const BodyWishes& wishes, double mass_kg,
                const Eigen::Vector3d& place_m, bool is_soft) {
  const Eigen::Vector3d size_m(random.between(0.02, 0.045), random.between(0.02, 0.045),
                               random.between(0.015, 0.03));
  body.text("kind", is_soft ? "soft_block" : "rigid_box");
  body.vector("size_m", size_m);
  body.vector("position_m", place_m);
  if (random.chance(0.3)) body.set("orientation_xyzw", draw_orientation(random));
  if (is_soft || random.chance(0.5)) {
    const double radius_m = size_m.minCoeff() * random.between(0.2, 0.45);
    body.set("spheres", braces({{"spacing_m", 1.9 * radius_m}, {"radius_m", radius_m}}));
  }
  if (is_soft) {
    body.set("nodes", "[3, 3, 2]");
    body.number("mass_kg", mass_kg);
    if (wishes.pinned && random.chance(0.5)) body.set("pinned", "[0, 2, 6, 8]");
    draw_springs(body, random, wishes, mass_kg / 18.0, false);
  } else {
    draw_motion(body, random, wishes, mass_kg, true);
  }
  return 0.5 * size_m.z();
}

/// Two or three shapes side by side.
double draw_compound(SceneSection& body, Random& random, const BodyWishes& wishes, double mass_kg,
                     const Eigen::Vector3d& place_m) {
  const double width_m = random.between(0.015, 0.025), high_m = random.between(0.015, 0.03);
  std::string shapes;
  for (int i = 0, count = random.chance(0.5) ? 2 : 3; i < count; ++i) {
    const std::string kind(random.one_of({"box", "sphere", "capsule", "cylinder"}));
    const double radius_m = 0.5 * std::min(width_m, high_m) * random.between(0.7, 1.0);
    shapes += (i == 0 ? "{ kind = \"" : ", { kind = \"") + kind + "\", position_m = [" +
              short_number((i - 0.5 * (count - 1)) * width_m) + ", 0.0, 0.0], ";
    if (kind == "box")
      shapes += "size_m = [" + short_number(width_m) + ", " + short_number(width_m) + ", " +
                short_number(high_m) + "] }";
    else
      shapes += "radius_m = " + short_number(radius_m) +
                (kind == "sphere" ? " }" : ", length_m = " + short_number(2.5 * radius_m) + " }");
  }
  body.text("kind", "compound");
  body.set("shape", "[" + shapes + "]");
  body.vector("position_m", place_m);
  if (random.chance(0.3)) body.set("orientation_xyzw", draw_orientation(random));
  draw_motion(body, random, wishes, mass_kg, true);
  return 0.65 * std::max(width_m, high_m);
}

double draw_ball(SceneSection& body, Random& random, const BodyWishes& wishes, double mass_kg,
                 const Eigen::Vector3d& place_m) {
  const double radius_m = random.between(0.006, 0.02);
  body.text("kind", "sphere");
  body.vector("position_m", place_m);
  body.number("radius_m", radius_m);
  draw_motion(body, random, wishes, mass_kg, true);
  return radius_m;
}

double draw_organ(SceneSection& body, Random& random, const BodyWishes& wishes, double mass_kg,
                  const Eigen::Vector3d& place_m) {
  body.text("kind", "mesh");
  body.text("file", "organ.obj");
  body.number("scale", random.between(0.28, 0.33));
  const std::string_view contact = random.one_of({"field", "cells", "spheres"});
  if (contact == "cells") body.set("field", braces({{"cell_m", random.between(0.0007, 0.0012)}}));
  if (contact == "spheres") body.set("spheres", "{ volume_spacing_m = 0.011 }");
  body.vector("position_m", place_m);
  draw_motion(body, random, wishes, mass_kg, false);
  return 0.02;
}

}  // namespace

std::string draw_material(SceneText& scene, Random& random, const BodyWishes& wishes) {
  std::size_t count = 0;
  for (const SceneSection& section : scene.sections)
    if (section.head == "[[material]]") ++count;
  const std::string name = "m" + std::to_string(count);
  SceneSection& material = scene.add("[[material]]");
  material.text("name", name);
  const double stiffness_N_per_m = random.over_decades(50.0, 5000.0);
  material.number("contact_stiffness_N_per_m", stiffness_N_per_m);
  // Against a mass of 50 g.
  const double critical_N_s_per_m = 2.0 * std::sqrt(0.05 * stiffness_N_per_m);
  if (wishes.damped)
    material.number("contact_damping_N_s_per_m",
                    random.over_decades(0.1, 1.0) * critical_N_s_per_m);
  else if (!wishes.undamped && random.chance(0.8))
    material.number("contact_damping_N_s_per_m",
                    random.over_decades(0.01, 1.0) * critical_N_s_per_m);
  if (wishes.damped)
    material.number("friction", random.between(0.3, 1.0));
  else if (!wishes.undamped && random.chance(0.7))
    material.number("friction", random.between(0.0, 1.0));
  return name;
}

double draw_body(SceneText& scene, Random& random, const BodyWishes& wishes,
                 const std::string& name, const std::string& material,
                 const Eigen::Vector3d& place_m) {
  SceneSection& body = scene.add("[[body]]");
  body.text("name", name);
  body.text("material", material);
  const double mass_kg = random.over_decades(0.01, 0.5);
  const double kind = random.between(0.0, 1.0);
  if (wishes.soft && kind < 0.2) return draw_sheet(body, random, wishes, mass_kg, place_m);
  if (wishes.soft && kind < 0.35) return draw_thread(body, random, wishes, mass_kg, place_m);
  if (wishes.soft && kind < 0.45) return draw_box(body, random, wishes, mass_kg, place_m, true);
  if (wishes.meshes && kind < 0.51) return draw_organ(body, random, wishes, mass_kg, place_m);
  if (wishes.rolls && kind < 0.75) return draw_ball(body, random, wishes, mass_kg, place_m);
  if (random.chance(0.3)) return draw_compound(body, random, wishes, mass_kg, place_m);
  return draw_box(body, random, wishes, mass_kg, place_m, false);
}

void add_floor(SceneText& scene, double height_m, const std::string& material) {
  SceneSection& floor = scene.add("[[body]]");
  floor.text("name", "floor");
  floor.text("kind", "plane");
  floor.vector("point_m", {0.0, 0.0, height_m});
  floor.set("normal", "[0.0, 0.0, 1.0]");
  floor.text("material", material);
}

}  // namespace stillgrid::laws
