#include "tests/laws/generator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/laws/body_draws.hpp"
#include "tests/laws/hand_draws.hpp"
#include "tests/laws/joint_draws.hpp"
#include "tests/laws/random.hpp"
#include "tests/laws/special_draws.hpp"

namespace stillgrid::laws {
namespace {

constexpr double kCell_m = 0.08;  // bodies of 60 mm at most stand apart

/// Who may move the tool.
enum class Mover { kNobody, kFormula, kAny };

struct Wishes {
  BodyWishes bodies;
  Mover mover = Mover::kAny;
  std::size_t most_bodies = 30;
  double floor_share = 0.8;
  bool default_display = false;  // transition and model
  bool continuous_display = false;
  bool cost_and_jitter = true;
  double duration_s = 0.8;
};

/// What a run is compared with, of laws that compare.
std::string draw_variant(int law, Random& random) {
  if (law == 5) return std::string(random.one_of({"accounted", "published"}));
  if (law == 6)
    return std::string(random.one_of(
        {"reversed list", "moved by 1 m", "turned by 90 degrees", "mirrored", "at 1 m/s"}));
  if (law == 7) return std::string(random.one_of({"motion", "force"}));
  return {};
}

Wishes wishes_of(int law) {
  Wishes wishes;
  switch (law) {
    case 1:
      wishes.most_bodies = 30;
      break;
    case 2:
      wishes.continuous_display = true;
      wishes.mover = Mover::kFormula;
      wishes.most_bodies = 6;
      break;
    case 3:
      wishes.mover = Mover::kFormula;
      wishes.bodies.damped = true;
      wishes.bodies.prescribed = false;
      wishes.default_display = true;
      wishes.most_bodies = 4;
      wishes.duration_s = 2.5;
      break;
    case 4:
      wishes.most_bodies = 4;
      wishes.default_display = true;
      wishes.duration_s = 2.0;
      break;
    case 6:
      wishes.mover = Mover::kFormula;
      wishes.duration_s = 0.05;
      break;
    case 17:
      wishes.most_bodies = 6;
      wishes.default_display = true;
      wishes.duration_s = 0.8;
      break;
    case 9:
      wishes.mover = Mover::kNobody;
      wishes.bodies = {
          .damped = true, .prescribed = false, .pinned = false, .moving = false, .meshes = false};
      wishes.most_bodies = 5;
      wishes.floor_share = 1.0;
      wishes.duration_s = 20.0;
      break;
    default:
      wishes.mover = Mover::kFormula;
      wishes.most_bodies = 12;
      wishes.duration_s = 0.15;
  }
  return wishes;
}

void draw_simulation(LawCase& law_case, Random& random, const Wishes& wishes) {
  SceneSection& simulation = law_case.scene.section("[simulation]");
  simulation.number("rate_hz", random.over_decades(10.0, 1000.0));
  const double kind = random.between(0.0, 1.0);
  if (kind < 0.4) {
    simulation.text("integrator", "velocity_verlet");
  } else if (kind < 0.96) {
    simulation.text("integrator", "implicit_euler");
  } else {
    simulation.text("integrator", "cvode_bdf");
    // Steps that SUNDIALS chooses by error are short at once where contacts set in.
    simulation.number("tolerance_m_s", 1e-4);
  }
  if (random.chance(0.5)) simulation.set("sleeping", "false");
  if (wishes.cost_and_jitter) {
    law_case.jitter = random.chance(0.5) ? 0.0 : random.between(0.01, 0.3);
    law_case.latency_share = random.chance(0.4) ? 0.0 : random.between(0.0, 1.0);
  }
}

/// A simulation that is slow, late and uneven.
void draw_clocks(LawCase& law_case, Random& random) {
  law_case.transition = "local";
  SceneSection& simulation = law_case.scene.section("[simulation]");
  simulation.text("integrator", random.chance(0.7) ? "velocity_verlet" : "implicit_euler");
  simulation.set("rate_hz", std::string(random.one_of({"10.0", "33.0", "50.0", "100.0"})));
  if (random.chance(0.5)) simulation.set("sleeping", "false");
  law_case.jitter = random.chance(0.3) ? 0.0 : random.between(0.0, 0.5);
  law_case.latency_share = random.chance(0.3) ? 0.0 : random.between(0.0, 2.0);
}

void draw_display(LawCase& law_case, Random& random, const Wishes& wishes) {
  if (wishes.default_display || random.chance(0.4)) return;
  if (wishes.continuous_display) {
    law_case.transition = "linear";
    return;
  }
  if (random.chance(0.6))
    law_case.transition = display::transitions()[random.index(display::transitions().size())].name;
  else
    law_case.model = laboratory::rivals()[random.index(laboratory::rivals().size())].name;
}

/// Returns the tool's reach along z below its origin.
double draw_tool(SceneText& scene, Random& random) {
  SceneSection& tool = scene.section("[tool]");
  const double radius_m = random.between(0.002, 0.008);
  if (random.chance(0.7)) {
    tool.number("radius_m", radius_m);
    return radius_m;
  }
  const std::size_t count = 1 + random.index(16);
  std::string spheres = "[";
  for (std::size_t i = 0; i < count; ++i) {
    const double out_m = static_cast<double>(i) * 0.6 * radius_m;
    spheres += (i == 0 ? "" : ", ") + std::string("{ position_m = [0.0, 0.0, ") +
               short_number(out_m) + "], radius_m = " + short_number(radius_m) + " }";
  }
  tool.set("spheres", spheres + "]");
  return radius_m;
}

/// Two threads, held at their far ends, between whose spheres a tool is pinched.
Target draw_gap(SceneText& scene, Random& random, const BodyWishes& bodies,
                double contact_distance_m) {
  const std::string material = draw_material(scene, random, bodies);
  const Eigen::Vector3d middle_m(0.001, -0.25, 0.001);  // beside all others
  const double radius_m = random.between(0.004, 0.007);
  const double half_m = contact_distance_m + radius_m - random.between(-0.0005, 0.0015);
  for (const double side : {1.0, -1.0}) {
    SceneSection& thread = scene.add("[[body]]");
    thread.text("name", side > 0.0 ? "right" : "left");
    thread.text("kind", "thread");
    thread.text("material", material);
    thread.set("nodes", "4");
    thread.vector("from_m", middle_m + Eigen::Vector3d(side * half_m, 0.0, 0.0));
    thread.vector("to_m", middle_m + Eigen::Vector3d(side * (half_m + 0.09), 0.0, 0.0));
    thread.text("pinned", "end");
    thread.set("spheres", "{ spacing_m = 0.03, radius_m = " + short_number(radius_m) + " }");
    const double mass_kg = random.over_decades(0.01, 0.2);
    thread.number("mass_kg", mass_kg);
    const double stiffness_N_per_m = random.over_decades(100.0, 2000.0);
    thread.set("spring_stiffness_N_per_m",
               "{ structural = " + short_number(stiffness_N_per_m) + " }");
    thread.number("spring_damping_N_s_per_m", 0.2 * std::sqrt(stiffness_N_per_m * mass_kg / 4.0));
  }
  return {.place_m = middle_m, .height_m = radius_m, .is_gap = true};
}

std::vector<Target> draw_bodies(SceneText& scene, Random& random, const Wishes& wishes) {
  std::vector<std::string> materials;
  const std::size_t material_count = 1 + random.index(3);
  for (std::size_t i = 0; i < material_count; ++i)
    materials.push_back(draw_material(scene, random, wishes.bodies));
  const auto any = [&] { return materials[random.index(materials.size())]; };
  if (random.chance(wishes.floor_share)) add_floor(scene, random.between(-0.06, -0.035), any());
  const double share = std::pow(random.between(0.0, 1.0), 2.5);
  const auto count =
      1 + static_cast<std::size_t>(share * static_cast<double>(wishes.most_bodies - 1) + 0.5);
  std::vector<Target> targets;
  for (std::size_t i = 0; i < count; ++i) {
    // Layers of nine, the first in the middle.
    constexpr std::array<int, 9> kSpiral = {0, 1, -1, 0, 0, 1, 1, -1, -1};
    constexpr std::array<int, 9> kTurned = {0, 0, 0, 1, -1, 1, -1, 1, -1};
    const std::size_t cell = i % 9;
    const Eigen::Vector3d place_m(
        kCell_m * kSpiral[cell] + random.between(-0.004, 0.004),
        kCell_m * kTurned[cell] + random.between(-0.004, 0.004),
        kCell_m * static_cast<double>(i / 9) + random.between(-0.004, 0.004));
    const double height_m =
        draw_body(scene, random, wishes.bodies, "b" + std::to_string(i), any(), place_m);
    targets.push_back({place_m, height_m});
  }
  return targets;
}

void draw_mover(LawCase& law_case, Random& random, const Wishes& wishes,
                const std::vector<Target>& targets, double contact_distance_m) {
  if (wishes.mover == Mover::kNobody) return;
  const bool is_pinch = targets.front().is_gap;
  const Target& target = is_pinch ? targets.front() : targets[random.index(targets.size())];
  const Hand hand = draw_hand(random, target, contact_distance_m, is_pinch);
  const double who = random.between(0.0, 1.0);
  if (wishes.mover == Mover::kFormula || who < 0.4)
    law_case.hand = hand;
  else if (who < 0.95)
    law_case.device = draw_device(random, hand);
  else
    law_case.device = draw_recorded(random, hand);
}

/// Laws that look at the simulation alone: they bear a second hand, the laboratory knows one; and
/// bodies that swing on joints for ever.
bool is_of_simulation(const LawCase& law_case) {
  return law_case.law == 5 || law_case.law == 6 || law_case.law == 15 ||
         (law_case.law == 7 && law_case.variant != "force");
}

}  // namespace

LawCase draw_case(int law, std::uint64_t seed) {
  Random random(std::uint64_t{0x100000001B3} * seed + static_cast<std::uint64_t>(law));
  LawCase law_case;
  law_case.law = law;
  law_case.seed = seed;
  law_case.scene.add("").set("format", "2");
  if (!draw_special(law_case, random)) {
    Wishes wishes = wishes_of(law);
    law_case.variant = draw_variant(law, random);
    if (law_case.variant == "at 1 m/s") {  // what is held still has another speed there
      wishes.floor_share = 0.0;
      wishes.bodies = {.still = false, .prescribed = false, .pinned = false, .meshes = false};
    }
    if (law_case.variant == "mirrored") wishes.bodies.meshes = false;
    law_case.duration_s = wishes.duration_s;
    if (random.chance(0.2) && law != 9)
      law_case.scene.add("[world]").set("gravity_m_s2", "[0.0, 0.0, 0.0]");
    if (law == 17)
      draw_clocks(law_case, random);
    else
      draw_simulation(law_case, random, wishes);
    draw_display(law_case, random, wishes);
    const double contact_distance_m =
        wishes.mover == Mover::kNobody ? 0.0 : draw_tool(law_case.scene, random);
    std::vector<Target> targets;
    const bool may_pinch =
        wishes.mover != Mover::kNobody && wishes.bodies.soft && wishes.bodies.pinned;
    if (may_pinch && random.chance(0.15))
      targets.push_back(draw_gap(law_case.scene, random, wishes.bodies, contact_distance_m));
    for (const Target& target : draw_bodies(law_case.scene, random, wishes))
      targets.push_back(target);
    draw_mover(law_case, random, wishes, targets, contact_distance_m);
    if (is_of_simulation(law_case) && random.chance(0.2))
      draw_other_hand(law_case, random, targets, contact_distance_m);
    // By numbers of their own: all else is drawn as without.
    Random of_joints(random.bits());
    if (is_of_simulation(law_case) && of_joints.chance(0.3))
      draw_joints(law_case.scene, of_joints, law_case.variant != "at 1 m/s");
  }
  // What is run is what is printed.
  return parse_case(print_case(law_case));
}

}  // namespace stillgrid::laws
