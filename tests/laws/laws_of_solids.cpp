// The law of solids: what a tool feels is a body's surface, whatever covers it.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "proto/safety_flag.hpp"
#include "tests/laws/law.hpp"

namespace stillgrid::laws {
namespace {

using Eigen::Vector3d;
using Rows = std::span<const recording::TickRow>;

/// The surface that a case's tool presses: a face in z = 0 and a wall across x, or a ball.
struct Surface {
  double stiffness_N_per_m = 0.0;
  double wall_x_m = std::numeric_limits<double>::infinity();
  double ball_m = 0.0;     // radius; 0: a face
  double steepness = 0.0;  // of the steepest normal between the spheres of a cover, its tangent
};

double steepness_of(const scene::SceneDescription& scene) {
  double steepest = 0.0;
  for (const bodies::BodyDescription& body : scene.bodies) {
    if (const auto* box = std::get_if<bodies::RigidBoxBody>(&body.shape)) {
      const double radii_m = box->spheres.radius_m + scene.tool.front().radius_m;
      const double sine = box->spheres.spacing_m / (std::sqrt(2.0) * radii_m);
      steepest = std::max(steepest, std::tan(std::asin(std::min(0.9, sine))));
    }
  }
  return steepest;
}

Surface surface_of(const scene::SceneDescription& scene) {
  Surface surface{.stiffness_N_per_m = scene.materials.front().contact_stiffness_N_per_m,
                  .steepness = steepness_of(scene)};
  for (const bodies::BodyDescription& body : scene.bodies) {
    const auto* compound = std::get_if<bodies::CompoundBody>(&body.shape);
    if (body.name == "wall" && compound != nullptr) surface.wall_x_m = body.position_m.x() - 0.003;
    if (body.name == "ball") surface.ball_m = -body.position_m.z();
  }
  return surface;
}

Vector3d ideal_N(const Surface& surface, std::span<const scene::ToolSphere> tool,
                 const Vector3d& position_m) {
  Vector3d depths_m = Vector3d::Zero();
  for (const scene::ToolSphere& sphere : tool) {
    const Vector3d at_m = position_m + sphere.position_m;
    if (surface.ball_m > 0.0) {
      const Vector3d line_m = at_m + Vector3d(0.0, 0.0, surface.ball_m);
      const double depth_m = surface.ball_m + sphere.radius_m - line_m.norm();
      depths_m += std::max(0.0, depth_m) * line_m.normalized();
    } else {
      depths_m.z() += std::max(0.0, sphere.radius_m - at_m.z());
      depths_m.x() -= std::max(0.0, at_m.x() + sphere.radius_m - surface.wall_x_m);
    }
  }
  return surface.stiffness_N_per_m * depths_m;
}

/// Two forces of each tick: how far they are apart at most, as a share of the largest of `right_N`.
/// Across the force spheres may lean by their steepest normal.
Finding apart(Rows rows, std::span<const Vector3d> right_N, double steepness,
              const std::string& part) {
  constexpr double kShare = 0.05;
  double most_N = 0.0;
  for (const Vector3d& force_N : right_N) most_N = std::max(most_N, force_N.norm());
  if (!(most_N > 0.0)) return {.applies = false, .what = "nothing touched"};
  Finding finding{.allowed = kShare, .what = "of the force, " + part};
  for (std::size_t i = 0; i < std::min(rows.size(), right_N.size()); ++i) {
    const Vector3d apart_N = rows[i].rendered_N - right_N[i];
    const Vector3d along = right_N[i].isZero() ? Vector3d::UnitZ().eval() : right_N[i].normalized();
    const double across_N = (apart_N - along.dot(apart_N) * along).norm();
    const double off =
        std::max(std::abs(along.dot(apart_N)) / most_N, across_N / most_N - steepness);
    if (off <= finding.measured) continue;
    finding.measured = off;
    finding.what = "of the force, " + part + ", at " + short_number(rows[i].time_s) + " s";
  }
  return finding;
}

Finding is_ideal(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  const Surface surface = surface_of(scene);
  const laboratory::LabRun run = laboratory::run_lab(scene, loop_of(law_case, scene).options);
  std::vector<Vector3d> right_N;
  for (const recording::TickRow& row : run.rows)
    right_N.push_back(ideal_N(surface, scene.tool, row.position_m));
  return apart(run.rows, right_N, surface.steepness, law_case.variant);
}

/// Half of each length of a cover in that line.
std::string halved(std::string line) {
  for (const std::string key : {"spacing_m = ", "cell_m = "}) {
    const auto at = line.find(key);
    if (at == std::string::npos) continue;
    const auto begin = at + key.size(), end = line.find_first_of(", }", begin);
    line.replace(begin, end - begin,
                 short_number(0.5 * std::strtod(line.c_str() + begin, nullptr)));
  }
  return line;
}

bool is_truncated(const recording::TickRow& row) {
  return (row.flags & proto::kFlagTruncated) != 0;
}

Finding covers_alike(const LawCase& law_case) {
  LawCase finer = law_case;
  for (SceneSection& section : finer.scene.sections)
    for (std::string& line : section.lines) line = halved(line);
  if (print_case(finer) == print_case(law_case))
    return {.applies = false, .what = "no cover that can be finer"};
  const scene::SceneDescription scene = scene_of(law_case), other = scene_of(finer);
  const laboratory::LabRun run = laboratory::run_lab(scene, loop_of(law_case, scene).options);
  const laboratory::LabRun fine = laboratory::run_lab(other, loop_of(finer, other).options);
  if (std::ranges::any_of(run.rows, is_truncated) || std::ranges::any_of(fine.rows, is_truncated))
    return {.applies = false, .what = "more spheres than a tick keeps, flagged"};
  std::vector<Vector3d> right_N;
  for (const recording::TickRow& row : fine.rows) right_N.push_back(row.rendered_N);
  return apart(run.rows, right_N, steepness_of(scene) + steepness_of(other), "finer cover");
}

/// A line through the values of ticks of 1 ms: its slope, a second.
double slope_per_s(std::span<const double> values) {
  const double middle = 0.5 * static_cast<double>(values.size() - 1);
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double from_middle = static_cast<double>(i) - middle;
    sum += from_middle * values[i];
    squares += from_middle * from_middle;
  }
  return 1e3 * sum / squares;
}

/// The place where a spring of the tool's stiffness would be at rest: it neither creeps nor
/// chatters.
Finding holds_its_load(const LawCase& law_case) {
  constexpr double kCreep_m_per_s = 1e-4 / 60.0, kChatter_N = 5e-3;
  const scene::SceneDescription scene = scene_of(law_case);
  const laboratory::LabRun run = laboratory::run_lab(scene, loop_of(law_case, scene).options);
  const double stiffness_N_per_m =
      static_cast<double>(scene.tool.size()) * scene.materials.front().contact_stiffness_N_per_m;
  const auto first = static_cast<std::size_t>(1e3 * (0.5 + law_case.hand->period_s));
  if (run.rows.size() < first + 1000) return {.applies = false, .what = "too short"};
  Finding worst;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> rest_m;
    for (std::size_t i = first; i < run.rows.size(); ++i)
      rest_m.push_back(run.rows[i].position_m[axis] +
                       run.rows[i].rendered_N[axis] / stiffness_N_per_m);
    const double creep_m_per_s = std::abs(slope_per_s(rest_m));
    const double middle_m =
        std::accumulate(rest_m.begin(), rest_m.end(), 0.0) / static_cast<double>(rest_m.size());
    double chatter_N = 0.0;
    for (const double at_m : rest_m)
      chatter_N = std::max(chatter_N, stiffness_N_per_m * std::abs(at_m - middle_m));
    const Finding creep{.measured = 60.0 * creep_m_per_s,
                        .allowed = 60.0 * kCreep_m_per_s,
                        .what = "m of creep a minute, hold"};
    const Finding chatter{
        .measured = chatter_N, .allowed = kChatter_N, .what = "N of chatter, hold"};
    for (const Finding& each : {creep, chatter})
      if (each.measured / each.allowed >= worst.measured / std::max(1e-300, worst.allowed))
        worst = each;
  }
  return worst;
}

/// A block that was lifted hangs, from half a period on, when the hand rests.
Finding block_hangs(const LawCase& law_case) {
  constexpr double kLook_s = 0.01, kLowest_m_per_minute = 1e-4;
  const scene::SceneDescription scene = scene_of(law_case);
  CaseLoop loop = loop_of(law_case, scene);
  loop.options.state_interval_s = kLook_s;
  const laboratory::LabRun run = laboratory::run_lab(scene, loop.options);
  std::vector<double> height_m;
  for (const laboratory::WorldState& state : run.states)
    if (state.time_s > 0.15 + 0.5 * law_case.hand->period_s)
      height_m.push_back(state.rigid_bodies.front().position_m.z());
  if (height_m.size() < 10) return {.applies = false, .what = "too short"};
  const double lifted_m = law_case.hand->depth_m;
  if (height_m.front() < 0.5 * lifted_m)
    return {.measured = lifted_m - height_m.front(), .allowed = 0.0, .what = "m not lifted, grip"};
  const double span_s = run.states[1].time_s - run.states[0].time_s;
  return {.measured = 60.0 * std::abs(slope_per_s(height_m)) * 1e-3 / span_s,
          .allowed = kLowest_m_per_minute,
          .what = "m of creep a minute, grip"};
}

/// Energy that a hand gets on its last whole turn, as a share of what goes to and fro.
Finding turn_gives_nothing(const LawCase& law_case) {
  constexpr double kShare = 0.001;
  const scene::SceneDescription scene = scene_of(law_case);
  const laboratory::LabRun run = laboratory::run_lab(scene, loop_of(law_case, scene).options);
  const auto turn = static_cast<std::size_t>(std::lround(1e3 * law_case.hand->period_s));
  if (run.rows.size() < 3 * turn) return {.applies = false, .what = "too short"};
  double given_J = 0.0, moved_J = 0.0;
  for (std::size_t i = run.rows.size() - turn; i < run.rows.size(); ++i) {
    const Vector3d mean_N = 0.5 * (run.rows[i].rendered_N + run.rows[i - 1].rendered_N);
    const double work_J = mean_N.dot(run.rows[i].position_m - run.rows[i - 1].position_m);
    given_J += work_J;
    moved_J += std::abs(work_J);
  }
  if (!(moved_J > 0.0)) return {.applies = false, .what = "nothing touched"};
  return {.measured = given_J,
          .allowed = kShare * moved_J,
          .what = "J given to the hand in a turn, closed path"};
}

/// A tick whose flag does not tell on which side of the stated force it is, or null.
const recording::TickRow* wrongly_flagged(std::span<const recording::TickRow> rows,
                                          double stated_N) {
  constexpr double kShare = 0.1;  // what is left of a switch counts in the force alone
  const auto is_wrong = [&](const recording::TickRow& row) {
    const double force_N = row.rendered_N.norm();
    return (row.flags & proto::kFlagCrushed) != 0 ? force_N < (1.0 - kShare) * stated_N
                                                  : force_N > (1.0 + kShare) * stated_N;
  };
  const auto it = std::ranges::find_if(rows, is_wrong);
  return it == rows.end() ? nullptr : &*it;
}

/// A soft body bears what the device can exert, or what the log states: while the hand goes deeper
/// the force does not fall under half of what it was. Ticks beyond the stated force have their
/// flag, and no others.
Finding bears_the_device(const LawCase& law_case) {
  constexpr double kDevice_N = 8.5;  // profile premium15
  const scene::SceneDescription scene = scene_of(law_case);
  const auto& shape = scene.bodies.front().shape;
  const auto* block = std::get_if<bodies::SoftBlockBody>(&shape);
  const double stated_N =
      block != nullptr ? bodies::crushing_force_N(block->lattice, block->springs)
                       : bodies::crushing_force_N(std::get<bodies::SoftMeshBody>(shape).lattice,
                                                  std::get<bodies::SoftMeshBody>(shape).springs);
  const laboratory::LabRun run = laboratory::run_lab(scene, loop_of(law_case, scene).options);
  if (const recording::TickRow* row = wrongly_flagged(run.rows, stated_N))
    return {.measured = row->rendered_N.norm(),
            .allowed = stated_N,
            .what = "N with the wrong flag, at " + short_number(row->time_s) + " s, soft"};
  double most_N = 0.0;
  Finding worst{.allowed = 0.5, .what = "of the force is lost, soft"};
  for (const recording::TickRow& row : run.rows) {
    const double force_N = row.rendered_N.norm();
    most_N = std::max(most_N, force_N);
    if (most_N > std::min(kDevice_N, stated_N)) break;
    if (most_N < 0.2) continue;
    const double lost = 1.0 - force_N / most_N;
    if (lost <= worst.measured) continue;
    worst.measured = lost;
    worst.what =
        "of " + short_number(most_N) + " N is lost at " + short_number(row.time_s) + " s, soft";
  }
  if (most_N < 0.2) return {.applies = false, .what = "nothing pressed"};
  return worst;
}

}  // namespace

Finding feels_solid(const LawCase& law_case) {
  if (law_case.variant == "cover") return covers_alike(law_case);
  if (law_case.variant == "hold") return holds_its_load(law_case);
  if (law_case.variant == "grip") return block_hangs(law_case);
  if (law_case.variant == "closed path") return turn_gives_nothing(law_case);
  if (law_case.variant == "soft") return bears_the_device(law_case);
  return is_ideal(law_case);
}

}  // namespace stillgrid::laws
