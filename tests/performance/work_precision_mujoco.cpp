#include "tests/performance/work_precision_mujoco.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "sim_server/scene/build_world.hpp"
#include "tests/performance/mujoco_system.hpp"

namespace stillgrid::performance {
namespace {

/// Its data have room for all springs times all velocities: 4,096 nodes of a cloth are refused
/// ("could not create mjData").
constexpr std::size_t kMaxNodes = 1024;
/// The implicit steps' factors have room for the square of all velocities: 1,024 nodes are refused
/// ("Stack overflow").
constexpr std::size_t kMaxNodesImplicit = 64;

std::string model_of(const bodies::World& world, const std::string& integrator, double step_s) {
  std::ostringstream text;
  text.precision(17);
  text << "<mujoco><option timestep='" << step_s << "' gravity='" << world.gravity_m_s2.transpose()
       << "' jacobian='sparse' integrator='" << integrator
       << "'><flag constraint='disable' contact='disable'/></option><worldbody>";
  for (std::size_t i = 0; i < world.nodes.size(); ++i) {
    const bodies::Node& node = world.nodes[i];
    if (node.pinned) {
      text << "<site name='" << i << "' pos='" << node.position_m.transpose() << "'/>";
      continue;
    }
    text << "<body pos='" << node.position_m.transpose() << "'><inertial pos='0 0 0' mass='"
         << node.mass_kg << "' diaginertia='1e-9 1e-9 1e-9'/>";
    for (const char* axis : {"1 0 0", "0 1 0", "0 0 1"})
      text << "<joint type='slide' axis='" << axis << "'/>";
    text << "<site name='" << i << "'/></body>";
  }
  text << "</worldbody><tendon>";
  for (const bodies::Spring& spring : world.springs)
    text << "<spatial stiffness='" << spring.stiffness_N_per_m << "' springlength='"
         << spring.rest_length_m << "'><site site='" << spring.a << "'/><site site='" << spring.b
         << "'/></spatial>";
  text << "</tendon></mujoco>";
  return text.str();
}

/// A world of ours, of masses and springs only, and the same as MuJoCo's.
struct MujocoWorld {
  bodies::World world;
  MujocoSystem system;
};

MujocoWorld mujoco_world(const scene::SceneDescription& scene, const std::string& integrator,
                         double step_s) {
  const bodies::World world = scene::build_world(scene);
  MujocoWorld mujoco{world, load_mujoco(model_of(world, integrator, step_s))};
  // What diverges would be told to the terminal and to a file.
  mju_user_warning = [](const char*) {};
  mjtNum* speed_m_s = mujoco.system.data->qvel;
  for (const bodies::Node& node : world.nodes)
    if (!node.pinned) speed_m_s = std::copy_n(node.velocity_m_s.data(), 3, speed_m_s);
  return mujoco;
}

/// Throws std::domain_error once it has begun anew because of what is no number.
void step(MujocoWorld& mujoco) {
  mj_step(mujoco.system.model.get(), mujoco.system.data.get());
  for (const mjtWarning bad : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC})
    if (mujoco.system.data->warning[bad].number > 0) throw std::domain_error("diverged");
}

/// By its slides, for MuJoCo's own places are those at the last step's begin.
Eigen::Matrix3Xd places_m(const MujocoWorld& mujoco) {
  Eigen::Matrix3Xd nodes_m = positions_m(mujoco.world);
  const mjtNum* slide_m = mujoco.system.data->qpos;
  for (std::size_t i = 0; i < mujoco.world.nodes.size(); ++i) {
    if (mujoco.world.nodes[i].pinned) continue;
    nodes_m.col(static_cast<Eigen::Index>(i)) += Eigen::Map<const Eigen::Vector3d>(slide_m);
    slide_m += 3;
  }
  return nodes_m;
}

std::string integrator_of(const std::string& solver) {
  return solver == "rk4" ? "RK4" : solver == "euler" ? "Euler" : solver;
}

}  // namespace

RunResult run_mujoco(const ChartScene& scene, const ChartPoint& point, double limit_s) {
  MujocoWorld mujoco = mujoco_world(scene.scene, integrator_of(point.solver), point.period_s);
  return run_through(
      scene, point.period_s, limit_s,
      [&](RunResult& run) {
        step(mujoco);
        ++run.substeps;
      },
      [&] { return places_m(mujoco); });
}

Eigen::Matrix3Xd mujoco_at_rest_m(const scene::SceneDescription& scene, double step_s, int steps) {
  MujocoWorld mujoco = mujoco_world(scene, "Euler", step_s);
  for (int i = 0; i < steps; ++i) {
    step(mujoco);
    std::fill_n(mujoco.system.data->qvel, mujoco.system.model->nv, 0.0);
  }
  return places_m(mujoco);
}

std::vector<Curve> mujoco_curves(const ChartScene& scene) {
  const std::size_t nodes = scene::build_world(scene.scene).nodes.size();
  if (!is_conservative(scene) || nodes > kMaxNodes) return {};
  std::vector<Curve> curves(2);
  for (const double step_s : {0.001, 0.0005, 0.00025, 0.0001, 0.00005, 0.000025, 0.00001})
    curves[0].push_back({"mujoco", "euler", "step_s", step_s, step_s, {}});
  for (const double step_s : {0.0025, 0.001, 0.0005, 0.00025, 0.0001})
    curves[1].push_back({"mujoco", "rk4", "step_s", step_s, step_s, {}});
  if (nodes > kMaxNodesImplicit) return curves;
  curves.push_back(curves[0]);
  for (ChartPoint& point : curves[2]) point.solver = "implicit";
  return curves;
}

}  // namespace stillgrid::performance
