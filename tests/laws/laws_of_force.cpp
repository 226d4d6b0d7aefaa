// Laws of the rendered force, tick by tick.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "proto/scene_segment.hpp"
#include "sim_server/scene/build_world.hpp"
#include "tests/laws/law.hpp"

namespace stillgrid::laws {
namespace {

/// The stiffest contact that the tool can have, and how deep one can be.
struct Contacts {
  double stiffness_N_per_m = 0.0, damping_N_s_per_m = 0.0, friction = 0.0;
  double contact_distance_m = 0.0;  // of a sphere's contact
  double tool_m = 0.0;              // from the tool's origin to its farthest point
};

Contacts contacts_of(const scene::SceneDescription& scene) {
  const bodies::World world = scene::build_world(scene);
  Contacts most;
  for (const collision::ContactMaterial& material : world.materials) {
    most.stiffness_N_per_m = std::max(most.stiffness_N_per_m, material.stiffness_N_per_m);
    most.damping_N_s_per_m = std::max(most.damping_N_s_per_m, material.damping_N_s_per_m);
    most.friction = std::max(most.friction, material.friction);
  }
  double widest_m = 0.0, tool_m = 0.0;
  for (const bodies::SphereBinding& sphere : world.spheres)
    widest_m = std::max(widest_m, sphere.radius_m);
  for (const bodies::StaticSphere& sphere : world.static_spheres)
    widest_m = std::max(widest_m, sphere.radius_m);
  for (const bodies::FieldBody& field : world.fields)
    widest_m = std::max(widest_m, double{field.field->shape().bounding_radius_m});
  for (const scene::ToolSphere& sphere : scene.tool) {
    tool_m = std::max(tool_m, sphere.radius_m);
    most.tool_m = std::max(most.tool_m, sphere.position_m.norm() + sphere.radius_m);
  }
  most.contact_distance_m = widest_m + tool_m;
  return most;
}

/// How deep a plane can have a part of the tool.
double depth_in_planes_m(const scene::SceneDescription& scene, const Eigen::Vector3d& at_m,
                         double tool_m) {
  double depth_m = 0.0;
  for (const bodies::BodyDescription& body : scene.bodies)
    if (const auto* plane = std::get_if<bodies::PlaneBody>(&body.shape))
      depth_m = std::max(depth_m, tool_m - plane->normal.dot(at_m - body.position_m));
  return depth_m;
}

bool is_finite(const laboratory::WorldState& state) {
  const auto finite = [](const laboratory::WorldState::Point& point) {
    return point.position_m.allFinite() && point.velocity_m_s.allFinite();
  };
  return std::all_of(state.nodes.begin(), state.nodes.end(), finite) &&
         std::all_of(state.rigid_bodies.begin(), state.rigid_bodies.end(), finite);
}

/// The most of each window of `ticks` to either side.
std::vector<double> most_around(const std::vector<double>& values, std::size_t ticks) {
  std::vector<double> most(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t first = i > ticks ? i - ticks : 0;
    const std::size_t last = std::min(values.size(), i + ticks + 1);
    most[i] = *std::max_element(values.begin() + static_cast<std::ptrdiff_t>(first),
                                values.begin() + static_cast<std::ptrdiff_t>(last));
  }
  return most;
}

std::vector<double> changes_N(const laboratory::LabRun& run) {
  std::vector<double> changes(run.rows.size(), 0.0);
  for (std::size_t i = 1; i < run.rows.size(); ++i)
    changes[i] = (run.rows[i].rendered_N - run.rows[i - 1].rendered_N).norm();
  return changes;
}

/// The true force at `rate_hz` along the way that a run took, seen at each of its ticks.
laboratory::LabRun reference_at(const scene::SceneDescription& scene,
                                const laboratory::LabOptions& options,
                                const laboratory::LabRun& run, double rate_hz) {
  laboratory::LabRun reference = laboratory::run_reference(scene, options, run);
  if (rate_hz == options.tick_rate_hz) return reference;
  laboratory::LabOptions fine = options;
  fine.tick_rate_hz = rate_hz;
  reference = laboratory::run_reference(scene, fine, run);
  const auto every = static_cast<std::size_t>(std::lround(rate_hz / options.tick_rate_hz));
  laboratory::LabRun thinned;
  for (std::size_t i = 0; i < reference.rows.size(); i += every)
    thinned.rows.push_back(reference.rows[i]);
  return thinned;
}

/// Where the scene at 1 kHz and at 4 kHz disagree by more than a fifth of the force, rms, and by
/// more than 0.05 N, nobody knows what is true.
bool is_chaotic(const laboratory::LabRun& one, const laboratory::LabRun& fine) {
  double apart_N2 = 0.0, force_N2 = 0.0;
  const std::size_t ticks = std::min(one.rows.size(), fine.rows.size());
  std::size_t touched = 1;
  for (std::size_t i = 0; i < ticks; ++i) {
    apart_N2 += (one.rows[i].rendered_N - fine.rows[i].rendered_N).squaredNorm();
    force_N2 += one.rows[i].rendered_N.squaredNorm();
    if (one.rows[i].contacts > 0) ++touched;
  }
  return apart_N2 > 0.04 * force_N2 && apart_N2 > 0.0025 * static_cast<double>(touched);
}

struct Excess {
  std::size_t tick = 0;
  double change_N = 0.0, allowed_N = 0.0, ratio = 0.0;
};

Excess worst_excess(const std::vector<double>& changes, const std::vector<double>& allowed) {
  Excess worst;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const double ratio = std::isfinite(changes[i]) ? changes[i] / allowed[i]
                                                   : std::numeric_limits<double>::infinity();
    if (ratio > worst.ratio) worst = {i, changes[i], allowed[i], ratio};
  }
  return worst;
}

/// Stiffness x speed x tick + 0.05 N, of the most that was touched and the fastest within a window.
std::vector<double> own_steps_N(const scene::SceneDescription& scene, const laboratory::LabRun& run,
                                double tick_s, std::size_t window, double resolution_m) {
  std::vector<double> speeds(run.rows.size(), 0.0), touched(run.rows.size(), 0.0);
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    if (i > 0) speeds[i] = (run.rows[i].position_m - run.rows[i - 1].position_m).norm() / tick_s;
    touched[i] = run.rows[i].contacts;
  }
  speeds = most_around(speeds, window);
  touched = most_around(touched, 1);
  const double stiffness_N_per_m = contacts_of(scene).stiffness_N_per_m;
  std::vector<double> allowed(run.rows.size());
  for (std::size_t i = 0; i < run.rows.size(); ++i)
    allowed[i] = touched[i] * stiffness_N_per_m * (speeds[i] * tick_s + resolution_m) + 0.05;
  return allowed;
}

}  // namespace

Finding finite_and_bounded(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  CaseLoop loop = loop_of(law_case, scene);
  loop.options.state_interval_s = 0.05;
  const laboratory::LabRun run = laboratory::run_lab(scene, loop.options);
  const Contacts most = contacts_of(scene);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const laboratory::WorldState& state : run.states)
    if (!is_finite(state))
      return {.measured = kInfinite, .what = "state at " + short_number(state.time_s) + " s"};

  int touched = 1;
  double fastest_m_s = 0.0, deepest_m = most.contact_distance_m;
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    const recording::TickRow& row = run.rows[i];
    touched = std::max(touched, row.contacts);
    deepest_m = std::max(deepest_m, depth_in_planes_m(scene, row.position_m, most.tool_m));
    if (i > 0)
      fastest_m_s =
          std::max(fastest_m_s, (row.position_m - run.rows[i - 1].position_m).norm() * 1e3);
  }
  // What is touched is no faster than things held or thrown by hand.
  constexpr double kThrown_m_s = 5.0;
  const double bound_N =
      touched *
      (most.stiffness_N_per_m * deepest_m + most.damping_N_s_per_m * (fastest_m_s + kThrown_m_s)) *
      (1.0 + most.friction);
  Finding finding{.allowed = bound_N, .what = "N"};
  for (const recording::TickRow& row : run.rows) {
    const bool finite =
        row.rendered_N.allFinite() && row.force_N.allFinite() && row.torque_N_m.allFinite();
    const double levers_N = row.torque_N_m.norm() / most.tool_m;
    const double force_N =
        finite ? std::max({row.rendered_N.norm(), row.force_N.norm(), levers_N}) : kInfinite;
    if (force_N <= finding.measured) continue;
    finding.measured = force_N;
    finding.what = "N, at " + short_number(row.time_s) + " s";
  }
  return finding;
}

Finding no_step_of_its_own(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  const CaseLoop loop = loop_of(law_case, scene);
  const laboratory::LabRun run = laboratory::run_lab(scene, loop.options);
  const double tick_s = 1.0 / loop.options.tick_rate_hz;
  // A snapshot shows what was by a period and its cost.
  const double old_s = scene.period_s * (1.0 + law_case.jitter) + loop.options.latency_s;
  const auto window = static_cast<std::size_t>(std::ceil(old_s / tick_s));
  const double resolution_m = law_case.hand ? 0.0 : 55e-6;
  const std::vector<double> changes = changes_N(run);
  std::vector<double> allowed = own_steps_N(scene, run, tick_s, window, resolution_m);
  Excess worst = worst_excess(changes, allowed);
  if (worst.ratio > 1.0) {  // then the reference is asked, which costs a hundred times more
    const laboratory::LabRun reference = reference_at(scene, loop.options, run, 1000.0);
    const laboratory::LabRun fine = reference_at(scene, loop.options, run, 4000.0);
    if (is_chaotic(reference, fine)) return {.applies = false, .what = "chaotic"};
    std::vector<double> world = changes_N(reference);
    world.resize(changes.size(), 0.0);
    world = most_around(world, window);
    for (std::size_t i = 0; i < allowed.size(); ++i)
      allowed[i] = std::max(allowed[i], 3.0 * world[i]);
    worst = worst_excess(changes, allowed);
  }
  const double at_s = run.rows.empty() ? 0.0 : run.rows[worst.tick].time_s;
  return {.measured = worst.change_N,
          .allowed = worst.allowed_N,
          .what = "N within a tick, at " + short_number(at_s) + " s"};
}

}  // namespace stillgrid::laws
