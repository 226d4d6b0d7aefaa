#include "tests/laws/moved_scene.hpp"

#include <cmath>
#include <limits>

#include "sim_server/lockstep_schedule.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::laws {

namespace {

ToolPath tool_path_of(const Hand& hand) {
  return [hand](double time_s) -> std::optional<dynamics::ToolSample> {
    const HandMotion motion = motion_at(hand, time_s);
    dynamics::ToolSample sample;
    sample.time_ns = 1 + static_cast<std::uint64_t>(time_s * 1e9);
    sample.position_m = motion.position_m;
    sample.velocity_m_s = motion.velocity_m_s;
    return sample;
  };
}

}  // namespace

ToolPaths tool_paths_of(const LawCase& law_case) {
  ToolPaths paths;
  for (const auto& hand : {law_case.hand, law_case.other_hand})
    if (hand) paths.push_back(tool_path_of(*hand));
  return paths;
}

void move_scene(const scene::SceneDescription& scene, const LawCase& law_case,
                const ToolPaths& paths, const AfterStep& after) {
  constexpr int kLeastSteps = 3;
  dynamics::Simulation simulation(scene);
  simulation.watch_energy();  // as sim_server does
  sim_server::LockstepSchedule schedule(scene.period_s, law_case.jitter, law_case.seed, 0.0);
  double time_s = 0.0;
  for (int steps = 0; time_s < law_case.duration_s || steps < kLeastSteps; ++steps) {
    const sim_server::ScheduledSnapshot snapshot = schedule.next();
    const double step_s = static_cast<double>(snapshot.step_ns) * 1e-9;
    time_s = static_cast<double>(snapshot.state_ns) * 1e-9;
    std::vector<dynamics::TakeTool> take_tools;
    for (const ToolPath& path : paths) take_tools.emplace_back([&] { return path(time_s); });
    const dynamics::StepReport report = simulation.step(step_s, take_tools);
    if (!after(simulation, report, time_s)) return;
  }
}

std::vector<Eigen::Vector3d> centres_m(const bodies::World& world) {
  std::vector<Eigen::Vector3d> centres;
  for (const bodies::BodyRange& body : world.bodies) {
    if (body.rigid >= 0) {
      centres.push_back(world.rigid_bodies[static_cast<std::size_t>(body.rigid)].position_m);
    } else if (body.node_count > 0) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int node = body.first_node; node < body.first_node + body.node_count; ++node)
        sum += world.nodes[static_cast<std::size_t>(node)].position_m;
      centres.emplace_back(sum / body.node_count);
    }
  }
  return centres;
}

double farthest_m(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  double farthest = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double apart = (a[i] - b[i]).norm();
    farthest =
        std::isfinite(apart) ? std::max(farthest, apart) : std::numeric_limits<double>::infinity();
  }
  return farthest;
}

std::vector<Eigen::Vector3d> end_of(const scene::SceneDescription& scene, const LawCase& law_case,
                                    const ToolPaths& paths) {
  std::vector<Eigen::Vector3d> end;
  move_scene(scene, law_case, paths,
             [&](dynamics::Simulation& simulation, const dynamics::StepReport&, double) {
               end = centres_m(simulation.world());
               return true;
             });
  return end;
}

double rounding_m(const scene::SceneDescription& scene, const LawCase& law_case,
                  const ToolPaths& paths) {
  scene::SceneDescription other = scene;
  for (bodies::BodyDescription& body : other.bodies) body.mass_kg *= 1.0 + 1e-13;
  return farthest_m(end_of(scene, law_case, paths), end_of(other, law_case, paths));
}

}  // namespace stillgrid::laws
