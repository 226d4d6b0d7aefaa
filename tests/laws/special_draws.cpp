#include "tests/laws/special_draws.hpp"

#include <cmath>
#include <string>

#include "tests/laws/body_draws.hpp"
#include "tests/laws/drop_draws.hpp"
#include "tests/laws/solid_draws.hpp"

namespace stillgrid::laws {
namespace {

constexpr std::uint64_t kLongSeeds = 1000;  // from here on cases are of full length and size

/// One body in the air: springs that swing, or a spin.
void draw_swing(LawCase& law_case, Random& random) {
  SceneText& scene = law_case.scene;
  SceneSection& simulation = scene.section("[simulation]");
  simulation.text("integrator", random.one_of({"velocity_verlet", "implicit_euler", "cvode_bdf"}));
  simulation.set("sleeping", "false");
  BodyWishes wishes{.still = false, .prescribed = false, .moving = false, .meshes = false};
  const std::string material = draw_material(scene, random, wishes);
  (void)draw_body(scene, random, wishes, "b0", material, Eigen::Vector3d::Zero());
  SceneSection& body = scene.sections.back();
  if (body.value_of("kind") == "\"rigid_box\"")
    body.vector("angular_velocity_rad_s",
                {random.between(-9.0, 9.0), random.between(-9.0, 9.0), random.between(-9.0, 9.0)});
  law_case.duration_s = random.between(0.02, 0.06);
}

void add_box(SceneText& scene, Random& random, const std::string& name, double mass_kg,
             const Eigen::Vector3d& place_m, const Eigen::Vector3d& size_m) {
  SceneSection& box = scene.add("[[body]]");
  box.text("name", name);
  box.text("kind", "rigid_box");
  box.text("material", "m0");
  box.number("mass_kg", mass_kg);
  box.vector("position_m", place_m);
  box.vector("size_m", size_m);
  const double radius_m = size_m.minCoeff() * random.between(0.15, 0.17);
  box.set("spheres", "{ spacing_m = " + short_number(2.0 * radius_m) +
                         ", radius_m = " + short_number(radius_m) + " }");
}

SceneSection& add_material(SceneText& scene, double stiffness_N_per_m, double damping_N_s_per_m,
                           double friction) {
  SceneSection& material = scene.add("[[material]]");
  material.text("name", "m0");
  material.number("contact_stiffness_N_per_m", stiffness_N_per_m);
  material.number("contact_damping_N_s_per_m", damping_N_s_per_m);
  material.number("friction", friction);
  return material;
}

/// Boxes on one another, so stiff that the column bears its own weight many times; or one on a
/// slope below its friction angle; or two with an offset.
void draw_standing(LawCase& law_case, Random& random) {
  SceneText& scene = law_case.scene;
  law_case.variant = random.one_of({"stack", "slope"});
  const bool is_stack = law_case.variant == "stack";
  const double friction = random.between(0.3, 0.9);
  const double slope_rad = is_stack ? 0.0 : std::atan(friction * random.between(0.1, 0.8));
  if (!is_stack)
    scene.add("[world]").vector("gravity_m_s2",
                                {9.81 * std::sin(slope_rad), 0.0, -9.81 * std::cos(slope_rad)});
  SceneSection& simulation = scene.section("[simulation]");
  simulation.number("rate_hz", random.over_decades(30.0, 300.0));
  simulation.text("integrator", random.one_of({"velocity_verlet", "implicit_euler"}));
  if (random.chance(0.5)) simulation.set("sleeping", "false");
  const double stiffness_N_per_m = random.over_decades(2000.0, 10'000.0);
  const double mass_kg = random.over_decades(0.01, 0.04);
  add_material(scene, stiffness_N_per_m,
               random.between(0.3, 0.9) * 2.0 * std::sqrt(mass_kg * stiffness_N_per_m), friction);
  add_floor(scene, 0.0, "m0");
  const std::size_t boxes = is_stack ? 2 + random.index(3) : 1;
  const double side_m = random.between(0.03, 0.04), height_m = random.between(0.02, 0.025);
  for (std::size_t i = 0; i < boxes; ++i)
    add_box(
        scene, random, "b" + std::to_string(i), mass_kg,
        {is_stack ? random.between(-0.001, 0.001) : 0.0,
         is_stack ? random.between(-0.001, 0.001) : 0.0, (static_cast<double>(i) + 0.5) * height_m},
        {side_m, side_m, height_m});
  law_case.duration_s = law_case.seed < kLongSeeds ? 8.0 : 600.0;
}

/// A box or a capsule that tumbles down a slope too steep to stand on.
void draw_tumble(LawCase& law_case, Random& random) {
  SceneText& scene = law_case.scene;
  const double slope_rad = random.between(0.7, 1.1);
  scene.add("[world]").vector("gravity_m_s2",
                              {9.81 * std::sin(slope_rad), 0.0, -9.81 * std::cos(slope_rad)});
  SceneSection& simulation = scene.section("[simulation]");
  simulation.number("rate_hz", random.over_decades(33.0, 1000.0));
  simulation.text("integrator",
                  random.one_of({"implicit_euler", "implicit_euler", "velocity_verlet"}));
  const double mass_kg = random.over_decades(0.01, 0.1);
  add_material(scene, random.over_decades(500.0, 5000.0), random.over_decades(0.3, 3.0),
               random.between(0.8, 1.5));
  add_floor(scene, 0.0, "m0");
  const double side_m = random.between(0.015, 0.03);
  const bool is_capsule = random.chance(0.3);  // a row of spheres
  const double length_m = side_m * (is_capsule ? random.between(2.0, 3.0) : 1.0);
  add_box(scene, random, "b0", mass_kg, {0.0, 0.0, 0.5 * side_m}, {side_m, length_m, side_m});
  if (is_capsule) {
    SceneSection& capsule = scene.sections.back();
    capsule.lines.pop_back();  // its spheres
    capsule.set("spheres", "{ spacing_m = " + short_number(side_m) +
                               ", radius_m = " + short_number(0.499 * side_m) + " }");
  }
  law_case.duration_s = random.between(0.5, 1.5);
}

/// A paddle that sweeps balls at rest, or a shot at one, without gravity.
void draw_tunnel(LawCase& law_case, Random& random) {
  SceneText& scene = law_case.scene;
  scene.add("[world]").set("gravity_m_s2", "[0.0, 0.0, 0.0]");
  SceneSection& simulation = scene.section("[simulation]");
  simulation.number("rate_hz", random.over_decades(10.0, 300.0));
  simulation.text("integrator", random.one_of({"velocity_verlet", "implicit_euler"}));
  add_material(scene, random.over_decades(500.0, 5000.0), random.over_decades(0.1, 3.0), 0.1);
  const bool is_paddle = random.chance(0.5);
  const double amplitude_m = random.between(0.03, 0.1), radius_m = random.between(0.004, 0.009);
  SceneSection& mover = scene.add("[[body]]");
  mover.text("name", "mover");
  mover.text("material", "m0");
  if (is_paddle) {
    mover.text("kind", "rigid_box");
    mover.set("size_m", "[0.02, 0.2, 0.02]");
    mover.set("spheres", "{ spacing_m = 0.01, radius_m = 0.007 }");
    mover.text("motion", "prescribed");
    mover.number("amplitude_m", amplitude_m);
    const double frequency_hz = random.over_decades(1.0, 10.0);
    mover.number("frequency_hz", frequency_hz);
    law_case.duration_s = 1.0 / frequency_hz;
  } else {
    const double speed_m_s = random.over_decades(1.0, 30.0);
    mover.text("kind", "sphere");
    mover.number("radius_m", random.between(0.004, 0.01));
    mover.number("mass_kg", random.over_decades(0.02, 0.2));
    mover.vector("velocity_m_s", {speed_m_s, 0.0, 0.0});
    law_case.duration_s = 0.2 / speed_m_s;
  }
  const std::size_t balls = is_paddle ? 3 + random.index(6) : 1;
  for (std::size_t i = 0; i < balls; ++i) {
    SceneSection& ball = scene.add("[[body]]");
    ball.text("name", "ball" + std::to_string(i));
    ball.text("kind", "sphere");
    ball.text("material", "m0");
    ball.number("mass_kg", random.over_decades(0.01, 0.1));
    ball.number("radius_m", radius_m);
    const double way_m = is_paddle ? amplitude_m * (random.chance(0.5) ? random.between(0.1, 0.9)
                                                                       : random.between(0.9, 0.99))
                                   : 0.06;
    ball.vector("position_m", {0.012 + radius_m + way_m,
                               is_paddle ? -0.08 + 0.022 * static_cast<double>(i) : 0.001, 0.002});
  }
  law_case.jitter = random.chance(0.5) ? 0.0 : random.between(0.01, 0.3);
}

void draw_cost(LawCase& law_case, Random& random) {
  SceneText& scene = law_case.scene;
  const bool is_long = law_case.seed >= kLongSeeds;
  SceneSection& simulation = scene.section("[simulation]");
  simulation.number("rate_hz", random.over_decades(30.0, 500.0));
  simulation.text("integrator", random.one_of({"velocity_verlet", "implicit_euler"}));
  add_material(scene, random.over_decades(100.0, 3000.0), random.over_decades(0.1, 1.0), 0.3);
  add_floor(scene, 0.0, "m0");
  const bool is_box = law_case.law == 13 && random.chance(0.4);
  SceneSection& body = scene.add("[[body]]");
  body.text("name", "n0");
  body.text("material", "m0");
  body.number("mass_kg", random.over_decades(0.01, 0.1));
  if (is_box) {
    body.text("kind", "rigid_box");
    body.set("size_m", "[0.1, 0.1, 0.1]");
    body.set("position_m", "[0.0, 0.0, 0.2]");
    body.set("spheres", "{ spacing_m = 0.05 }");
    body.vector("velocity_m_s", {random.between(0.5, 2.0), 0.0, 0.0});
    law_case.variant = "spheres";
  } else {
    body.text("kind", "sphere");
    body.number("radius_m", random.between(0.015, 0.023));
    law_case.variant = "bodies";
  }
  const double most = law_case.law == 13 ? (is_box ? 1500.0 : 5000.0) : is_long ? 40'000.0 : 3000.0;
  const double least = law_case.law == 13 ? 0.4 * most : 10.0;
  law_case.repeat = static_cast<int>(random.over_decades(least, most));
}

/// A device pressed on a wall or a ball on a floor, whose stiffness is looked for.
void draw_verdict(LawCase& law_case, Random& random) {
  SceneText& scene = law_case.scene;
  scene.section("[simulation]").number("rate_hz", random.over_decades(10.0, 100.0));
  SceneSection& material = add_material(scene, 1000.0, 0.0, random.between(0.0, 0.3));
  (void)material;
  add_floor(scene, -0.0051, "m0");
  if (random.chance(0.7)) {
    scene.sections.pop_back();
    const double radius_m = random.between(0.01, 0.02);
    add_floor(scene, -0.005 - 2.0 * radius_m, "m0");
    SceneSection& ball = scene.add("[[body]]");
    ball.text("name", "ball");
    ball.text("kind", "sphere");
    ball.text("material", "m0");
    ball.vector("position_m", {0.0, 0.0, -0.005 - radius_m});
    ball.number("radius_m", radius_m);
    ball.number("mass_kg", random.over_decades(0.02, 1.0));
  }
  law_case.device = "phantom:profile=touch,hand=light,path=still,centre_z_m=0,push_z_N=-1";
  law_case.jitter = random.between(0.05, 0.3);
  law_case.latency_share = random.between(0.0, 0.5);
  law_case.duration_s = 20.0;
}

}  // namespace

bool draw_special(LawCase& law_case, Random& random) {
  switch (law_case.law) {
    case 8:
      draw_swing(law_case, random);
      return true;
    case 10:
      draw_standing(law_case, random);
      return true;
    case 11:
      draw_tunnel(law_case, random);
      return true;
    case 12:
    case 13:
      draw_cost(law_case, random);
      return true;
    case 14:
      draw_verdict(law_case, random);
      return true;
    case 16:
      if (random.chance(0.5))
        draw_drop(law_case, random);
      else
        draw_tumble(law_case, random);
      return true;
    case 18:
      draw_solid(law_case, random);
      return true;
    default:
      return false;
  }
}

}  // namespace stillgrid::laws
