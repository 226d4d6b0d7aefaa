#include "tests/laboratory/lab_cell.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "shared/realtime/processor_time.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/methods/laboratory_methods.hpp"

namespace stillgrid::laboratory {
namespace {

[[noreturn]] void refuse(const std::string& key, const std::string& value,
                         const std::string& expected) {
  throw std::runtime_error(key + ": value '" + value + "': expected " + expected);
}

bool is_file(const LabCell& cell) {
  return cell.scene.ends_with(".toml");
}

LabScene parse_scene(const LabCell& cell) {
  const auto refuse_scene = [&] {
    refuse("--scene", cell.scene,
           "wall, free, row, chain, spring, pinch, block, floor or soft, with :MASS_KG if any, or "
           "FILE.toml");
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
  const auto tool = lab_tool_named(cell.tool);
  if (!tool) refuse("--tool", cell.tool, "1x1, 2x2 or 3x1");
  scene.tool = *tool;
  if (cell.from != "inside" && !stands_alone(*body))
    refuse("--from", cell.from, "inside: nothing but the tool holds " + cell.scene);
  scene.period_s = cell.period_s;
  scene.contact_damping_N_s_per_m = cell.contact_damping_N_s_per_m;
  scene.friction = cell.friction.value_or(usual_friction(*body));
  return scene;
}

LabDevice device_of(const LabCell& cell) {
  if (cell.limits != "none" && cell.limits != "declared")
    refuse("--limits", cell.limits, "none or declared");
  if (cell.from != "inside" && cell.from != "outside")
    refuse("--from", cell.from, "inside or outside");
  return {cell.limits == "declared", cell.from == "outside", cell.resolution_m,
          cell.device_friction_N};
}

/// Of all that is free to move.
double moving_mass_kg(const bodies::World& world) {
  double mass_kg = 0.0;
  for (const bodies::Node& node : world.nodes) mass_kg += node.pinned ? 0.0 : node.mass_kg;
  for (const bodies::RigidBody& body : world.rigid_bodies)
    mass_kg += body.free ? body.mass_kg : 0.0;
  return mass_kg;
}

/// A cell with its options and its rule, made once.
class Judge {
 public:
  explicit Judge(const LabCell& cell)
      : cell_(cell),
        scene_(scene_of(cell, kAnyStiffness_N_per_m)),
        options_(options_of(cell)),
        rule_(rule_of(cell)) {
    // So that the search need not read the scene again for each stiffness.
    share_ = scene_.materials.front().contact_stiffness_N_per_m / kAnyStiffness_N_per_m;
    options_.duration_s = rule_.most_s;
  }

  [[nodiscard]] Verdict at(double stiffness_N_per_m, std::uint64_t seed) {
    scene_.materials.front().contact_stiffness_N_per_m = share_ * stiffness_N_per_m;
    options_.seed = seed;
    VerdictWatch watch(rule_);
    options_.watch = [&watch](const recording::TickRow& row) { return watch.take(row); };
    try {
      if (run_lab(scene_, options_).device_failed) return Verdict::kNowhere;
    } catch (const std::domain_error&) {  // a place that is no number
      return Verdict::kNowhere;
    }
    return watch.verdict();
  }

  /// By the first seed that loses it.
  [[nodiscard]] Verdict worst(double stiffness_N_per_m, std::uint64_t first) {
    const int seeds = is_drawn(cell_) ? cell_.seeds : 1;
    for (int i = 0; i < seeds; ++i) {
      const Verdict verdict = at(stiffness_N_per_m, first + static_cast<std::uint64_t>(i));
      if (verdict != Verdict::kStable) return verdict;
    }
    return Verdict::kStable;
  }

 private:
  LabCell cell_;
  scene::SceneDescription scene_;
  LabOptions options_;
  VerdictRule rule_;
  double share_ = 1.0;  // of a cell's stiffness, that the scene's first material has
};

}  // namespace

std::string scene_text_of(const LabCell& cell, double stiffness_N_per_m) {
  LabScene scene = parse_scene(cell);
  scene.contact_stiffness_N_per_m = stiffness_N_per_m;
  return scene_text(scene);
}

scene::SceneDescription scene_of(const LabCell& cell, std::optional<double> stiffness_N_per_m) {
  if (!is_file(cell)) {
    LabScene scene = parse_scene(cell);
    scene.contact_stiffness_N_per_m = stiffness_N_per_m.value_or(kAnyStiffness_N_per_m);
    return lab_scene(scene);
  }
  scene::SceneDescription scene = scene::load_scene(cell.scene, laboratory_methods());
  scene::require_one_hand(scene, cell.scene);
  scene.period_s = cell.period_s;
  if (stiffness_N_per_m && scene.materials.empty())
    refuse("--stiffness", std::to_string(*stiffness_N_per_m), "a scene with a material");
  if (stiffness_N_per_m) scene.materials.front().contact_stiffness_N_per_m = *stiffness_N_per_m;
  return scene;
}

bool is_drawn(const LabCell& cell) noexcept {
  return cell.jitter > 0.0 || cell.network.path.delay_jitter > 0.0 || cell.network.path.loss > 0.0;
}

LabOptions options_of(const LabCell& cell) {
  const Rival* const rival = rival_named(cell.model);
  if (rival == nullptr && cell.model != "grid")
    refuse("--model", cell.model, "grid, or a rival of docs/algorithms/intermediate_models.md");
  const auto transition = display::transition_named(cell.transition);
  if (!transition) refuse("--transition", cell.transition, "a transition of haptic_server --help");
  const auto hand = lab_hand_named(cell.device);
  const LabDevice device = device_of(cell);
  LabOptions options{.device = hand ? device_text(*hand, device) : cell.device,
                     .rival = rival,
                     .transition = *transition,
                     .latency_s = cell.latency_share * cell.period_s,
                     .jitter = cell.jitter,
                     .steps_by_samples = cell.steps_by_samples,
                     .seed = cell.seed,
                     .duration_s = cell.duration_s};
  if (cell.network.is_felt()) options.network = cell.network;
  // What is sought is a stiffness: governed to the one that the device declares, all would be it.
  constexpr double kUngoverned_N_per_m = 1e9;
  if (hand) options.safety.max_stiffness_N_per_m = kUngoverned_N_per_m;
  return options;
}

double friction_of(const LabCell& cell) {
  return is_file(cell) ? cell.friction.value_or(0.0) : parse_scene(cell).friction;
}

VerdictRule rule_of(const LabCell& cell) {
  VerdictRule rule;
  rule.must_touch = !is_file(cell);
  const auto hand = lab_hand_named(cell.device);
  const HandModel model = hand ? model_of(*hand) : HandModel{};
  if (model.stiffness_N_per_m > 0.0) {
    const double mass_kg =
        model.mass_kg + moving_mass_kg(scene::build_world(scene_of(cell, std::nullopt)));
    const double cycle_s = 2.0 * std::numbers::pi * std::sqrt(mass_kg / model.stiffness_N_per_m);
    rule.window_s = std::max(rule.window_s, 2.0 * cycle_s);
  }
  rule.limit_m = kQuietEncoderSteps * std::max(cell.resolution_m, 30e-6);
  rule.least_s = cell.duration_s + (hand ? kHold_s : 0.0);
  rule.most_s = 3.0 * rule.least_s;
  return rule;
}

Verdict verdict_of(const LabCell& cell, double stiffness_N_per_m) {
  return Judge(cell).at(stiffness_N_per_m, cell.seed);
}

CellLimit limit_of(const LabCell& cell, const StiffnessSearch& search) {
  const double began_s = realtime::thread_processor_s();
  Judge judge(cell);
  CellLimit found;
  const auto is_stable = [&](double stiffness_N_per_m, std::uint64_t first) {
    const Verdict verdict = judge.worst(stiffness_N_per_m, first);
    if (first == cell.seed) found.lost_by = verdict;
    return verdict == Verdict::kStable;
  };
  found.limit_N_per_m = largest_stable_stiffness_N_per_m(
      [&](double stiffness_N_per_m) { return is_stable(stiffness_N_per_m, cell.seed); }, search);
  found.by_others_N_per_m = found.limit_N_per_m;
  if (found.limit_N_per_m && is_drawn(cell)) {
    const std::uint64_t others = cell.seed + static_cast<std::uint64_t>(cell.seeds);
    StiffnessSearch near = search;  // on the same grid
    near.from_N_per_m = 0.7 * *found.limit_N_per_m;
    near.highest_N_per_m = std::min(search.highest_N_per_m, 1.4 * *found.limit_N_per_m);
    found.by_others_N_per_m = largest_stable_stiffness_N_per_m(
        [&](double stiffness_N_per_m) { return is_stable(stiffness_N_per_m, others); }, near);
  }
  found.processor_s = realtime::thread_processor_s() - began_s;
  return found;
}

}  // namespace stillgrid::laboratory
