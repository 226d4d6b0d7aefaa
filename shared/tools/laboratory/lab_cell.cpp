#include "shared/tools/laboratory/lab_cell.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "shared/tools/laboratory/methods/laboratory_methods.hpp"
#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::laboratory {
namespace {

[[noreturn]] void refuse(const std::string& key, const std::string& value,
                         const std::string& expected) {
  throw std::runtime_error(key + ": value '" + value + "': expected " + expected);
}

LabScene parse_scene(const LabCell& cell) {
  const auto refuse_scene = [&] {
    refuse("--scene", cell.scene, "wall, free, chain or block, with :MASS_KG if any, or FILE.toml");
  };
  LabScene scene;
  const std::size_t colon = cell.scene.find(':');
  const auto body = lab_body_named(cell.scene.substr(0, colon));
  if (!body) refuse_scene();
  scene.body = *body;
  scene.mass_kg = usual_mass_kg(*body);
  if (colon != std::string::npos) {
    const char* const end = cell.scene.data() + cell.scene.size();
    const auto [stop, error] = std::from_chars(cell.scene.data() + colon + 1, end, scene.mass_kg);
    if (error != std::errc{} || stop != end || !(scene.mass_kg > 0.0)) refuse_scene();
  }
  scene.period_s = cell.period_s;
  scene.contact_damping_N_s_per_m = cell.contact_damping_N_s_per_m;
  scene.friction = cell.friction;
  return scene;
}

}  // namespace

std::string scene_text_of(const LabCell& cell, double stiffness_N_per_m) {
  LabScene scene = parse_scene(cell);
  scene.contact_stiffness_N_per_m = stiffness_N_per_m;
  return scene_text(scene);
}

scene::SceneDescription scene_of(const LabCell& cell, std::optional<double> stiffness_N_per_m) {
  const bool is_file = cell.scene.ends_with(".toml");
  scene::SceneDescription scene =
      is_file ? scene::load_scene(cell.scene, laboratory_methods()) : lab_scene(parse_scene(cell));
  scene.period_s = cell.period_s;
  if (stiffness_N_per_m && scene.materials.empty())
    refuse("--stiffness", std::to_string(*stiffness_N_per_m), "a scene with a material");
  if (stiffness_N_per_m) scene.materials.front().contact_stiffness_N_per_m = *stiffness_N_per_m;
  return scene;
}

LabOptions options_of(const LabCell& cell) {
  const Rival* const rival = rival_named(cell.model);
  if (rival == nullptr && cell.model != "grid")
    refuse("--model", cell.model, "grid, or a rival of docs/algorithms/intermediate_models.md");
  const auto transition = display::transition_named(cell.transition);
  if (!transition) refuse("--transition", cell.transition, "a transition of haptic_server --help");
  const auto hand = lab_hand_named(cell.device);
  return {
      .device = hand ? device_text(*hand, cell.resolution_m, cell.device_friction_N) : cell.device,
      .rival = rival,
      .transition = *transition,
      .latency_s = cell.latency_share * cell.period_s,
      .jitter = cell.jitter,
      .seed = cell.seed,
      .duration_s = cell.duration_s};
}

std::optional<double> largest_stable_stiffness_N_per_m(const LabCell& cell,
                                                       const StiffnessSearch& search) {
  LabOptions options = options_of(cell);
  const auto is_stable = [&](double stiffness_N_per_m) {
    return !oscillates(run_lab(scene_of(cell, stiffness_N_per_m), options).rows);
  };
  StiffnessSearch below = search;  // what another seed has lost already
  std::optional<double> least_N_per_m;
  for (int i = 0; i < (cell.jitter > 0.0 ? cell.seeds : 1); ++i) {
    options.seed = cell.seed + static_cast<std::uint64_t>(i);
    least_N_per_m = largest_stable_stiffness_N_per_m(is_stable, below);
    if (!least_N_per_m) break;
    below.highest_N_per_m = *least_N_per_m * std::sqrt(search.step);
  }
  return least_N_per_m;
}

}  // namespace stillgrid::laboratory
