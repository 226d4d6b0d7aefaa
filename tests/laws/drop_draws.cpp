#include "tests/laws/drop_draws.hpp"

#include <string>
#include <string_view>

#include "tests/laws/body_draws.hpp"

namespace stillgrid::laws {
namespace {

void draw_shape(SceneSection& body, Random& random, std::string_view kind, double height_m) {
  const auto count = [&] { return std::to_string(2 + random.index(3)); };
  body.text("kind", kind);
  body.vector("position_m", {0.0, 0.0, height_m});
  if (kind == "sphere") {
    body.number("radius_m", random.between(0.01, 0.04));
  } else if (kind == "rigid_box") {
    body.vector("size_m", {random.between(0.02, 0.06), random.between(0.02, 0.06),
                           random.between(0.02, 0.06)});
  } else if (kind == "mesh") {
    body.text("file", "organ.obj");
    body.number("scale", random.between(0.28, 0.33));
    body.number("lattice_m", random.between(0.011, 0.016));
    body.set("spheres", "{ volume_spacing_m = 0.011 }");
  } else if (kind == "soft_block") {
    body.set("nodes", "[" + count() + ", " + count() + ", " + count() + "]");
    body.vector("size_m", {random.between(0.02, 0.08), random.between(0.02, 0.08),
                           random.between(0.02, 0.05)});
  } else {
    body.set("nodes", "[" + count() + ", " + count() + "]");
    body.set("size_m", "[" + short_number(random.between(0.04, 0.1)) + ", " +
                           short_number(random.between(0.04, 0.1)) + "]");
    body.set("spheres", "{ spacing_m = 0.01, radius_m = 0.006 }");
  }
}

}  // namespace

void draw_drop(LawCase& law_case, Random& random) {
  SceneText& scene = law_case.scene;
  SceneSection& simulation = scene.section("[simulation]");
  if (random.chance(0.8)) {
    simulation.number("rate_hz", random.over_decades(33.0, 1000.0));
    simulation.text("integrator", "velocity_verlet");
  }
  const std::string material = draw_material(scene, random, {});
  add_floor(scene, 0.0, material);
  SceneSection& body = scene.add("[[body]]");
  body.text("name", "b0");
  body.text("material", material);
  const std::string_view kind =
      random.one_of({"soft_block", "soft_block", "mesh", "sheet", "sphere", "rigid_box"});
  draw_shape(body, random, kind, random.between(0.05, 0.9));
  body.number("mass_kg", random.over_decades(0.01, 0.3));
  law_case.duration_s = 1.5;
  if (kind == "sphere" || kind == "rigid_box") return;
  const double structural_N_per_m = random.over_decades(30.0, 3000.0);
  body.set("spring_stiffness_N_per_m",
           "{ structural = " + short_number(structural_N_per_m) +
               ", shear = " + short_number(structural_N_per_m * random.between(0.2, 2.5)) +
               ", bend = " + short_number(structural_N_per_m * random.between(0.02, 0.3)) + " }");
  if (random.chance(0.3)) body.number("spring_damping_N_s_per_m", random.over_decades(0.005, 0.3));
}

}  // namespace stillgrid::laws
