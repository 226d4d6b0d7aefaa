// Laws of what stands and of what may not pass.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "sim_server/scene/build_world.hpp"
#include "tests/laws/law.hpp"
#include "tests/laws/moved_scene.hpp"

namespace stillgrid::laws {
namespace {

constexpr double kSettle_s = 4.0;

/// Where the free bodies are when they have settled, and at the end.
struct Creep {
  std::vector<Eigen::Vector3d> settled, end;
  double between_s = 0.0;
};

Creep creep_of(const scene::SceneDescription& scene, const LawCase& law_case) {
  Creep creep;
  double settled_s = 0.0;
  move_scene(scene, law_case, tool_paths_of(law_case),
             [&](dynamics::Simulation& simulation, const dynamics::StepReport&, double time_s) {
               if (creep.settled.empty() && time_s >= kSettle_s) {
                 creep.settled = centres_m(simulation.world());
                 settled_s = time_s;
               }
               creep.end = centres_m(simulation.world());
               creep.between_s = time_s - settled_s;
               return true;
             });
  return creep;
}

std::vector<bool> moved_from_start(const scene::SceneDescription& scene, const LawCase& law_case,
                                   int* crossings_left) {
  const std::vector<Eigen::Vector3d> start = centres_m(scene::build_world(scene));
  std::vector<Eigen::Vector3d> end = start;
  std::vector<bool> moved(start.size(), false);
  move_scene(scene, law_case, tool_paths_of(law_case),
             [&](dynamics::Simulation& simulation, const dynamics::StepReport& report, double) {
               if (crossings_left != nullptr) *crossings_left += report.crossings_left;
               end = centres_m(simulation.world());
               for (std::size_t i = 0; i < end.size(); ++i)
                 if (!((end[i] - start[i]).norm() <= 1e-6)) moved[i] = true;
               return true;
             });
  return moved;
}

/// On a floor, whose friction holds on a slope as steep as gravity makes it.
bool is_to_stand(const scene::SceneDescription& scene) {
  const Eigen::Vector3d& g = scene.gravity_m_s2;
  const double slope = std::hypot(g.x(), g.y()) / std::max(1e-9, -g.z());
  const auto holds = [slope](const scene::MaterialDescription& material) {
    return material.friction > slope && material.contact_damping_N_s_per_m > 0.0;
  };
  const auto is_floor = [](const bodies::BodyDescription& body) {
    return std::holds_alternative<bodies::PlaneBody>(body.shape);
  };
  return std::all_of(scene.materials.begin(), scene.materials.end(), holds) &&
         std::any_of(scene.bodies.begin(), scene.bodies.end(), is_floor);
}

}  // namespace

Finding stands(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  if (!is_to_stand(scene) || law_case.duration_s < 1.25 * kSettle_s)
    return {.applies = false, .what = "nothing that is to stand"};
  const Creep creep = creep_of(scene, law_case);
  const bool is_stack = law_case.variant == "stack";
  const double moved_m = farthest_m(creep.settled, creep.end);
  // A stack may settle; it may not fall or walk. A block on a slope has 10 um a minute.
  const double rate = 60.0 / std::max(1.0, creep.between_s);
  if (is_stack)
    return {.measured = moved_m,
            .allowed = 1e-3,
            .what = "m from where it stood after " + short_number(kSettle_s) + " s, by " +
                    short_number(law_case.duration_s) + " s"};
  return {.measured = moved_m * rate, .allowed = 1e-5, .what = "m of creep a minute"};
}

Finding nothing_tunnels(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  scene::SceneDescription fine = scene;
  fine.method = {.integrator = scene::IntegratorKind::kVelocityVerlet};
  fine.period_s = 5e-5;
  LawCase even = law_case;
  even.jitter = 0.0;
  even.duration_s = std::max(law_case.duration_s, 3.0 * scene.period_s * (1.0 + law_case.jitter));
  const std::vector<bool> truly = moved_from_start(fine, even, nullptr);
  int crossings_left = 0;
  const std::vector<bool> moved = moved_from_start(scene, law_case, &crossings_left);
  int passed = 0;
  for (std::size_t i = 0; i < truly.size(); ++i) passed += truly[i] && !moved[i] ? 1 : 0;
  return {.measured = static_cast<double>(std::max(0, passed - crossings_left)),
          .allowed = 0.0,
          .what = "bodies untouched that are met at 20 kHz, of " +
                  std::to_string(std::count(truly.begin(), truly.end(), true))};
}

}  // namespace stillgrid::laws
