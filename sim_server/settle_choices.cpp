#include "sim_server/settle_choices.hpp"

#include <spdlog/spdlog.h>

#include <cstdio>

#include "sim_server/dynamics/choice/counted_work.hpp"

namespace stillgrid::sim_server {

void settle_choices(scene::SceneDescription& scene, const bodies::World& world) {
  if (!scene.choose_method) return;
  const dynamics::MethodChoice choice =
      dynamics::choose_method(dynamics::load_of(world), scene.period_s);
  scene.method = choice.method;
  spdlog::info("method chosen: {}: {}", scene::describe(scene.method), choice.why);
}

void explain_choices(const scene::SceneDescription& scene, const bodies::World& world) {
  const dynamics::SceneLoad load = dynamics::load_of(world);
  const dynamics::MethodChoice method = dynamics::choose_method(load, scene.period_s);
  std::printf("%s: %.0f nodes, %.0f springs, %.0f rigid bodies, %.0f moving spheres\n",
              scene.name.c_str(), load.nodes, load.springs, load.rigid_bodies, load.spheres);
  std::printf("method by the spectrum: %s: %s\n", scene::describe(method.method).c_str(),
              method.why.c_str());
  if (!scene.choose_method)
    std::printf("the scene names %s\n", scene::describe(scene.method).c_str());
}

}  // namespace stillgrid::sim_server
