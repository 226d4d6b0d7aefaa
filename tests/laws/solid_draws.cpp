#include "tests/laws/solid_draws.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/laws/solid_parts.hpp"

namespace stillgrid::laws {
namespace {

void draw_face(LawCase& law_case, Random& random) {
  const SolidTool tool = draw_solid_tool(law_case.scene, random, 0.0, true);
  const Eigen::Vector3d size_m(0.028, 0.028, random.between(0.003, 0.008));
  add_solid_box(law_case.scene, random, "b0", draw_box_kind(random, true),
                {0.0, 0.0, -0.5 * size_m.z()}, size_m);
  law_case.hand = draw_solid_hand(random, HandKind::kStroke, tool, draw_depth_m(random));
}

/// Two to four bodies that touch, across or along the way of the tool.
void draw_seam(LawCase& law_case, Random& random) {
  const SolidTool tool = draw_solid_tool(law_case.scene, random, 0.0, false);
  const Eigen::Vector3d size_m(0.026, 0.026, random.between(0.004, 0.008));
  const bool along = random.chance(0.3), four = random.chance(0.3);
  for (int i = 0; i < (four ? 4 : 2); ++i) {
    Eigen::Vector3d middle_m = Eigen::Vector3d::Constant(-0.5).cwiseProduct(size_m);
    const bool right = i % 2 == 1, behind = i / 2 == 1;
    middle_m.x() = four || !along ? (right ? 0.5 : -0.5) * size_m.x() : 0.0;
    middle_m.y() = four    ? (behind ? 0.5 : -0.5) * size_m.y()
                   : along ? (right ? 0.5 : -0.5) * size_m.y()
                           : 0.0;
    add_solid_box(law_case.scene, random, "b" + std::to_string(i), draw_sharp_kind(random),
                  middle_m, size_m);
  }
  law_case.hand = draw_solid_hand(random, HandKind::kStroke, tool, draw_depth_m(random));
}

/// A face and a wall across the way of the tool, up from the face or besides it.
void draw_corner(LawCase& law_case, Random& random) {
  const SolidTool tool = draw_solid_tool(law_case.scene, random, 0.0, false);
  const Eigen::Vector3d size_m(0.04, 0.03, 0.006), wall_m(0.006, 0.03, 0.03);
  const BoxKind kind = random.chance(0.3) ? BoxKind::kPlane : BoxKind::kExact;
  add_solid_box(law_case.scene, random, "b0", kind, {0.0, 0.0, -0.5 * size_m.z()}, size_m);
  const double gap_m = random.between(0.0, 0.002);
  add_solid_box(law_case.scene, random, "wall", BoxKind::kExact,
                {tool.radius_m + gap_m + 0.5 * wall_m.x(), 0.0, 0.5 * wall_m.z()}, wall_m);
  law_case.hand = draw_solid_hand(random, HandKind::kStroke, tool, draw_depth_m(random));
}

void draw_ball(LawCase& law_case, Random& random) {
  const SolidTool tool = draw_solid_tool(law_case.scene, random, 0.0, false);
  const double radius_m = random.between(0.012, 0.03);
  SceneSection& ball = add_held_body(law_case.scene, random, "ball");
  ball.vector("position_m", {0.0, 0.0, -radius_m});
  if (random.chance(0.5)) {
    ball.text("kind", "sphere");
    ball.number("radius_m", radius_m);
  } else {
    ball.text("kind", "compound");
    ball.set("shape", "[{ kind = \"sphere\", radius_m = " + short_number(radius_m) + " }]");
  }
  law_case.hand = draw_solid_hand(random, HandKind::kStroke, tool, draw_depth_m(random));
}

/// A thin plate, pushed by up to 40 N, at up to 3 m/s.
void draw_through(LawCase& law_case, Random& random) {
  const SolidTool tool = draw_solid_tool(law_case.scene, random, 0.0, true);
  const Eigen::Vector3d size_m(0.028, 0.028, random.between(0.001, 0.004));
  add_solid_box(law_case.scene, random, "b0", draw_box_kind(random, false),
                {0.0, 0.0, -0.5 * size_m.z()}, size_m);
  const double most_m = std::min(0.05, 40.0 / tool.stiffness_N_per_m);
  Hand hand = draw_solid_hand(random, HandKind::kTap, tool, random.between(0.3, 1.0) * most_m);
  const double speed_m_s = random.over_decades(0.05, 3.0);
  hand.period_s = 5.0 * std::numbers::pi * hand.depth_m / speed_m_s;
  law_case.hand = hand;
  law_case.duration_s = 0.2 + std::min(2.0, hand.period_s);
}

/// The same body by another cover: finer spheres or cells, or two halves for one box.
void draw_finer(LawCase& law_case, Random& random) {
  if (random.chance(0.6)) {
    draw_face(law_case, random);
    return;
  }
  const SolidTool tool = draw_solid_tool(law_case.scene, random, 0.0, false);
  SceneSection& organ = add_held_body(law_case.scene, random, "organ");
  organ.text("kind", "mesh");
  organ.text("file", "organ.obj");
  organ.set("position_m", "[-0.0049, 0.0037, -0.0124]");
  if (random.chance(0.7))
    organ.set("field", "{ cell_m = " + short_number(random.between(0.0008, 0.0016)) + " }");
  else
    organ.set("spheres",
              "{ surface_spacing_m = " + short_number(random.between(0.002, 0.003)) + " }");
  law_case.hand = draw_solid_hand(random, HandKind::kStroke, tool, draw_depth_m(random));
}

/// A slope within the friction cone, on which an unsteady hand presses straight down.
void draw_hold(LawCase& law_case, Random& random) {
  const double friction = random.between(0.2, 1.0);
  const SolidTool tool = draw_solid_tool(law_case.scene, random, friction, true);
  const Eigen::Vector3d size_m(0.028, 0.028, 0.006);
  add_solid_box(law_case.scene, random, "b0",
                random.chance(0.5) ? BoxKind::kSpheres : BoxKind::kExact,
                {0.0, 0.0, -0.5 * size_m.z()}, size_m, false);
  const double half_rad = 0.5 * std::atan(random.between(0.1, 0.7) * friction);
  law_case.scene.sections.back().set("orientation_xyzw",
                                     "[0.0, " + short_number(std::sin(half_rad)) + ", 0.0, " +
                                         short_number(std::cos(half_rad)) + "]");
  Hand hand = draw_solid_hand(random, HandKind::kStill, tool, random.between(0.001, 0.004));
  hand.noise_m = random.chance(0.7) ? 30e-6 : 0.0;
  law_case.hand = hand;
  law_case.duration_s = 0.3 + hand.period_s + 2.0;
}

/// A fork of two spheres that lifts a block from a floor.
void draw_grip(LawCase& law_case, Random& random) {
  SceneText& scene = law_case.scene;
  const double radius_m = random.between(0.005, 0.008), half_m = random.between(0.01, 0.015);
  const double squeeze_m = random.between(0.0007, 0.0015);
  const std::string out = short_number(half_m + radius_m - squeeze_m);
  const std::string end = ", 0.0, 0.0], radius_m = " + short_number(radius_m) + " }";
  scene.section("[tool]").set(
      "spheres", "[{ position_m = [-" + out + end + ", { position_m = [" + out + end + "]");
  SceneSection& material = scene.add("[[material]]");
  material.text("name", "m0");
  const double stiffness_N_per_m = random.between(1000.0, 2000.0);
  material.number("contact_stiffness_N_per_m", stiffness_N_per_m);
  material.number("contact_damping_N_s_per_m", random.between(0.5, 2.0));
  const double friction = random.between(0.5, 1.0);
  material.number("friction", friction);
  add_solid_box(scene, random, "floor", BoxKind::kPlane, {0.0, 0.0, -half_m},
                Eigen::Vector3d::Zero());
  SceneSection& block = scene.add("[[body]]");
  block.text("name", "block");
  block.text("material", "m0");
  block.number("mass_kg",
               random.between(0.1, 0.4) * 2.0 * friction * stiffness_N_per_m * squeeze_m / 9.81);
  block.text("kind", "rigid_box");
  block.vector("size_m", Eigen::Vector3d::Constant(2.0 * half_m));
  if (random.chance(0.5)) block.set("spheres", draw_packing(random, 0.006));
  Hand hand;
  hand.kind = HandKind::kTap;
  hand.centre_m = {0.0, 0.0, half_m + radius_m + 0.002};
  hand.depth_m = hand.centre_m.z() - random.between(0.2, 0.5) * half_m;
  hand.period_s = 7.0;
  hand.noise_m = random.chance(0.5) ? 30e-6 : 0.0;
  law_case.hand = hand;
  law_case.duration_s = 0.15 + hand.period_s;
}

/// A soft body by its default cover, pinned below, into which a hand goes, at most nearly to the
/// bottom.
void draw_soft(LawCase& law_case, Random& random) {
  const SolidTool tool = draw_solid_tool(law_case.scene, random, random.between(0.0, 0.5), false);
  SceneSection& body = law_case.scene.add("[[body]]");
  body.text("name", "soft");
  body.text("material", "m0");
  body.number("mass_kg", random.between(0.03, 0.3));
  const double structural_N_per_m = random.over_decades(40.0, 400.0);
  const std::string shear = short_number(random.between(0.3, 1.0) * structural_N_per_m);
  const std::string bend = short_number(random.between(0.02, 0.2) * structural_N_per_m);
  body.set("spring_stiffness_N_per_m", "{ structural = " + short_number(structural_N_per_m) +
                                           ", shear = " + shear + ", bend = " + bend + " }");
  body.number("spring_damping_N_s_per_m", random.between(0.05, 0.3));
  double height_m = 0.025;
  if (random.chance(0.5)) {
    body.text("kind", "mesh");
    body.text("file", "organ.obj");
    body.set("position_m", "[-0.0049, 0.0037, -0.0124]");
    body.number("lattice_m", random.between(0.008, 0.014));
  } else {
    const Eigen::Vector3d size_m(random.between(0.04, 0.08), random.between(0.04, 0.08),
                                 height_m = random.between(0.02, 0.04));
    body.text("kind", "soft_block");
    body.set("nodes", "[5, 5, " + std::to_string(3 + random.index(3)) + "]");
    body.vector("size_m", size_m);
    body.vector("position_m", {0.0, 0.0, -0.5 * height_m});
  }
  body.set("pinned", "{ low_m = [-1.0, -1.0, -1.0], high_m = [1.0, 1.0, " +
                         short_number(-0.75 * height_m) + "] }");
  law_case.hand =
      draw_solid_hand(random, HandKind::kStill, tool, random.between(0.3, 0.9) * height_m);
  law_case.hand->centre_m.x() = random.between(-0.003, 0.003);
  law_case.hand->centre_m.y() = random.between(-0.003, 0.003);
  law_case.duration_s = 0.15 + 1.5 * law_case.hand->period_s;
}

/// Some bodies beside and into one another, round which a hand stirs.
void draw_closed_path(LawCase& law_case, Random& random) {
  const SolidTool tool = draw_solid_tool(law_case.scene, random, 0.0, true);
  for (int i = 0, count = 1 + static_cast<int>(random.index(3)); i < count; ++i) {
    const Eigen::Vector3d size_m(random.between(0.01, 0.03), random.between(0.01, 0.03), 0.006);
    const Eigen::Vector3d middle_m(random.between(-0.01, 0.01), random.between(-0.01, 0.01),
                                   -0.5 * size_m.z() - (i == 0 ? 0.0 : random.between(0.0, 0.003)));
    add_solid_box(law_case.scene, random, "b" + std::to_string(i), draw_box_kind(random, false),
                  middle_m, size_m, false);
  }
  law_case.hand = draw_solid_hand(random, random.chance(0.6) ? HandKind::kStir : HandKind::kPress,
                                  tool, random.between(0.002, 0.01));
  law_case.duration_s = 0.16 + 4.0 * law_case.hand->period_s;
}

}  // namespace

void draw_solid(LawCase& law_case, Random& random) {
  law_case.variant = random.one_of({"face", "seam", "corner", "ball", "through", "cover", "hold",
                                    "grip", "closed path", "soft"});
  const bool is_grip = law_case.variant == "grip";
  if (!is_grip) law_case.scene.add("[world]").set("gravity_m_s2", "[0.0, 0.0, 0.0]");
  if (random.chance(0.4)) law_case.transition = "linear";
  SceneSection& simulation = law_case.scene.section("[simulation]");
  simulation.number("rate_hz", random.over_decades(30.0, 1000.0));
  simulation.text("integrator", random.one_of({"velocity_verlet", "implicit_euler"}));
  simulation.set("sleeping", "false");
  const auto draw = [&](std::string_view part, void (*draw_part)(LawCase&, Random&)) {
    if (law_case.variant == part) draw_part(law_case, random);
  };
  draw("face", draw_face);
  draw("seam", draw_seam);
  draw("corner", draw_corner);
  draw("ball", draw_ball);
  draw("through", draw_through);
  draw("cover", draw_finer);
  draw("hold", draw_hold);
  draw("grip", draw_grip);
  draw("closed path", draw_closed_path);
  draw("soft", draw_soft);
  if (law_case.hand->kind == HandKind::kStroke)
    law_case.duration_s = 0.15 + 3.0 * law_case.hand->period_s;
}

}  // namespace stillgrid::laws
