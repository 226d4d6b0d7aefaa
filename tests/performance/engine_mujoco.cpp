#include <algorithm>
#include <sstream>

#include "tests/performance/engine_peers.hpp"
#include "tests/performance/mujoco_system.hpp"

namespace stillgrid::performance {
namespace {

std::string shape_of(const PeerScene& scene, std::size_t rigid) {
  std::ostringstream text;
  if (!scene.box_m.empty())
    text << "<geom type='box' size='" << 0.5 * scene.box_m[rigid].transpose() << "'/>";
  else if (!scene.ours.description.spheres.empty())
    text << "<geom type='sphere' size='" << scene.ours.description.spheres[rigid].radius_m << "'/>";
  return text.str();
}

/// Writes bodies from first on. Bodies without joints are free. The links of a chain are within
/// each other; beyond kDepth of them they are in a file of their own, for its reader takes no more.
constexpr std::size_t kDepth = 60;
void write_bodies(const PeerScene& scene, std::size_t first, std::ostringstream& text) {
  const auto& description = scene.ours.description;
  const auto& state = scene.ours.state;
  const bool is_chain = !description.joints.empty();
  const std::size_t bodies = state.orientation.size();
  const std::size_t end = is_chain ? std::min(bodies, first + kDepth) : bodies;
  Eigen::Vector3d above_m =
      first == 0 ? Eigen::Vector3d::Zero() : state.rigid_position_m[first - 1].vector();
  for (std::size_t i = first; i < end; ++i) {
    const auto& rigid = description.rigid_bodies[i];
    const Eigen::Vector3d place_m = state.rigid_position_m[i].vector();
    const dynamics::Vector4& q = state.orientation[i];
    text << "<body pos='" << (place_m - above_m).transpose() << "' quat='" << q.w << ' ' << q.x
         << ' ' << q.y << ' ' << q.z << "'><inertial pos='0 0 0' mass='" << rigid.mass_kg
         << "' diaginertia='" << rigid.inertia_kg_m2.transpose() << "'/>" << shape_of(scene, i);
    if (is_chain) {
      text << "<joint type='ball' pos='" << description.joints[i].b.point_m.transpose() << "'/>";
      above_m = place_m;
    } else {
      text << "<freejoint/></body>";
    }
  }
  if (end < bodies) text << "<include file='included.xml'/>";
  for (std::size_t i = first; is_chain && i < end; ++i) text << "</body>";
}

std::string included_of(const PeerScene& scene) {
  if (scene.ours.description.joints.size() <= kDepth) return {};
  std::ostringstream text;
  text.precision(17);
  text << "<mujocoinclude>";
  write_bodies(scene, kDepth, text);
  text << "</mujocoinclude>";
  return text.str();
}

std::string model_of(const PeerScene& scene, const MujocoMethod& method) {
  const auto& description = scene.ours.description;
  std::ostringstream text;
  text.precision(17);
  text << "<mujoco><option timestep='" << 0.01 / method.substeps << "' gravity='"
       << description.gravity_m_s2.transpose() << "' integrator='" << method.integrator
       << "' solver='" << method.solver << "'/><size nconmax='"
       << 6 * description.rigid_bodies.size() << "' njmax='" << 24 * description.rigid_bodies.size()
       << "'/><default><geom friction='0.5' solref='" << method.time_constant_s
       << " 1'/></default><worldbody>";
  for (const auto& plane : description.planes)
    text << "<geom type='plane' size='0 0 1' pos='" << (plane.offset_m * plane.normal).transpose()
         << "' zaxis='" << plane.normal.transpose() << "'/>";
  write_bodies(scene, 0, text);
  text << "</worldbody></mujoco>";
  return text.str();
}

class MujocoWorld : public PeerWorld {
 public:
  MujocoWorld(const PeerScene& scene, const MujocoMethod& method)
      : substeps_(method.substeps),
        system_(load_mujoco(model_of(scene, method), included_of(scene))) {}

  void step() override {
    for (int i = 0; i < substeps_; ++i) mj_step(system_.model.get(), system_.data.get());
  }
  /// MuJoCo's own positions are those at the start of its last step.
  [[nodiscard]] std::vector<Pose> poses() const override {
    mj_kinematics(system_.model.get(), system_.data.get());
    std::vector<Pose> poses;
    for (int i = 1; i < system_.model->nbody; ++i) {
      const mjtNum* q = system_.data->xquat + 4 * i;
      poses.push_back({Eigen::Map<const Eigen::Vector3d>(system_.data->xpos + 3 * i),
                       {q[0], q[1], q[2], q[3]}});
    }
    return poses;
  }

 private:
  int substeps_;
  MujocoSystem system_;
};

}  // namespace

std::unique_ptr<PeerWorld> mujoco_world(const PeerScene& scene, const MujocoMethod& method) {
  return std::make_unique<MujocoWorld>(scene, method);
}

}  // namespace stillgrid::performance
