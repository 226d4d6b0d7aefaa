// The law of one simulation that two processes step.

#include <algorithm>
#include <limits>
#include <string>

#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/published_scene.hpp"
#include "tests/laws/law.hpp"

namespace stillgrid::laws {
namespace {

/// Why a scene is not stepped in two processes; empty: it is.
std::string complaint(const scene::SceneDescription& scene) {
  if (scene::hands_of(scene).size() != 1) return "two hands";
  const dynamics::Simulation simulation(scene);
  if (sim_server::static_scene(scene, simulation).model.empty()) return "too long a tick";
  return {};
}

bool are_equal(const recording::TickRow& a, const recording::TickRow& b) {
  return a.position_m == b.position_m && a.velocity_m_s == b.velocity_m_s &&
         a.rendered_N == b.rendered_N && a.force_N == b.force_N && a.torque_N_m == b.torque_N_m &&
         a.contacts == b.contacts;
}

}  // namespace

Finding one_simulation(const LawCase& law_case) {
  scene::SceneDescription scene = scene_of(law_case);
  if (const std::string why = complaint(scene); !why.empty())
    return {.applies = false, .what = why};
  const CaseLoop loop = loop_of(law_case, scene);
  const laboratory::LabRun late = run_lab(scene, loop.options);
  laboratory::LabOptions prompt = loop.options;
  prompt.jitter = prompt.latency_s = 0.0;
  scene.period_s = 1e-3;
  const laboratory::LabRun run = run_lab(scene, prompt);
  const auto differs = std::ranges::mismatch(run.rows, late.rows, are_equal);
  if (differs.in1 == run.rows.end() && differs.in2 == late.rows.end())
    return {.measured = 0.0, .what = "N between two rates"};
  const bool both = differs.in1 != run.rows.end() && differs.in2 != late.rows.end();
  return {
      .measured = both ? std::max((differs.in1->rendered_N - differs.in2->rendered_N).norm(),
                                  std::numeric_limits<double>::min())
                       : std::numeric_limits<double>::infinity(),
      .what = "N between two rates at " + std::to_string(both ? differs.in1->time_s : 0.0) + " s"};
}

}  // namespace stillgrid::laws
