#include "sim_server/scene_summary.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "sim_server/dynamics/choice/counted_work.hpp"

namespace stillgrid::sim_server {
namespace {

std::string count_of(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

std::string bodies_of(const scene::SceneDescription& scene) {
  const auto moved = [&](bodies::Motion motion) {
    return std::to_string(
        std::ranges::count(scene.bodies, motion, &bodies::BodyDescription::motion));
  };
  return count_of(scene.bodies.size(), "body", "bodies") + ": " + moved(bodies::Motion::kFree) +
         " free, " + moved(bodies::Motion::kPrescribed) + " prescribed, " +
         moved(bodies::Motion::kStatic) + " static\n";
}

std::string content_of(const bodies::World& world) {
  return count_of(world.spheres.size(), "sphere", "spheres") + " of what moves, " +
         std::to_string(world.static_spheres.size()) + " of what does not; " +
         count_of(world.nodes.size(), "node", "nodes") + ", " +
         count_of(world.springs.size(), "spring", "springs") + ", " +
         count_of(world.fields.size(), "field", "fields") +
         (world.joints.empty()
              ? ""
              : ", joined at " + count_of(world.joints.size(), "point", "points")) +
         '\n';
}

std::string hands_line(const scene::SceneDescription& scene) {
  std::string line;
  for (const scene::Hand& hand : scene::hands_of(scene))
    line += (line.empty() ? "" : ", ") + (hand.name.empty() ? "" : "hand '" + hand.name + "': ") +
            "tool of " + count_of(hand.tool.size(), "sphere", "spheres");
  return line + '\n';
}

}  // namespace

std::string summary_of(const scene::SceneDescription& scene, const bodies::World& world) {
  std::array<char, 160> rate{};
  std::snprintf(rate.data(), rate.size(), "%.6g Hz, %s", 1.0 / scene.period_s,
                scene::describe(scene.method).c_str());
  std::string step = rate.data();
  if (scene::is_explicit(scene.method.integrator) && scene.method.substeps == 0) {
    const int substeps = dynamics::taken_substeps(dynamics::load_of(world), scene.period_s);
    step += ", " + count_of(static_cast<std::size_t>(substeps), "substep", "substeps");
  }
  if (scene.choose_method) step += " (chosen)";
  return scene.name + ": " + bodies_of(scene) + content_of(world) + hands_line(scene) + step + '\n';
}

}  // namespace stillgrid::sim_server
