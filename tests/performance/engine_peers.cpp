#include "tests/performance/engine_peers.hpp"

#include "sim_server/bodies/kinds/rigid_box.hpp"
#include "sim_server/bodies/solid_shape.hpp"
#include "sim_server/dynamics/workers/workers.hpp"
#include "tests/shared/dynamics/field_scenes.hpp"

namespace stillgrid::performance {
namespace {

class OurWorld : public PeerWorld {
 public:
  OurWorld(const PeerScene& scene, int threads, dynamics::EngineMethod method)
      : workers_(threads), engine_(scene.ours.engine(method)) {
    engine_.share_work(workers_);
  }
  void step() override {
    for (int tick = 0; tick < 10; ++tick) engine_.step();
  }
  [[nodiscard]] std::vector<Pose> poses() const override {
    std::vector<Pose> poses;
    const dynamics::SceneState& state = engine_.state();
    for (std::size_t i = 0; i < state.orientation.size(); ++i)
      poses.push_back({state.rigid_position_m[i].vector(), state.orientation[i].quaternion()});
    return poses;
  }

 private:
  dynamics::Workers workers_;
  dynamics::Engine engine_;
};

}  // namespace

PeerScene falling_boxes(int count) {
  PeerScene scene;
  dynamics::EngineScene& ours = scene.ours;
  fall_into_bin(ours, count, 0.03, [&](const Eigen::Vector3d& at, const auto& between) {
    const Eigen::Vector3d size_m(between(0.016, 0.024), between(0.016, 0.024),
                                 between(0.016, 0.024));
    const bodies::SolidShape box{.kind = bodies::SolidShape::Kind::kBox, .half_m = 0.5 * size_m};
    const double mass_kg = 1000.0 * size_m.prod();
    const Eigen::Vector3d inertia_kg_m2 =
        mass_kg * bodies::mass_properties({&box, 1}).inertia_per_kg_m2.diagonal();
    const int rigid = ours.add_rigid(mass_kg, inertia_kg_m2, at);
    ours.state.orientation.back() = dynamics::Vector4(Eigen::Quaterniond(
        Eigen::AngleAxisd(between(-0.2, 0.2), Eigen::Vector3d(1.0, 1.0, 1.0).normalized())));
    dynamics::add_field(ours, rigid, bodies::field_of(box));
    for (const spheres::Ball& ball : bodies::contact_balls(box))
      dynamics::add_surface_point(ours, rigid, ball.radius_m, ball.centre_m);
    scene.box_m.push_back(size_m);
  });
  return scene;
}

PeerScene hanging_links(int count, double stiffness_N_per_m) {
  constexpr double kLength_m = 0.03, kMass_kg = 0.01;
  const Eigen::Vector3d end_m(0.0, 0.0, 0.5 * kLength_m);
  const bodies::RigidBoxBody link{{0.008, 0.008, kLength_m}};
  PeerScene scene;
  scene.ours.description.gravity_m_s2 = 9.81 * Eigen::Vector3d(1.0, 0.0, -1.0).normalized();
  for (int i = 0; i < count; ++i) {
    scene.ours.add_rigid(kMass_kg, rigid_shape(link, kMass_kg).inertia_kg_m2,
                         -kLength_m * (i + 0.5) * Eigen::Vector3d::UnitZ());
    const dynamics::Description::JointEnd above{
        -1, i - 1, i == 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(-end_m)};
    scene.ours.description.joints.push_back(
        {above, {-1, i, end_m}, 0.0, stiffness_N_per_m, 2e-4 * stiffness_N_per_m});
  }
  return scene;
}

std::unique_ptr<PeerWorld> our_world(const PeerScene& scene, int threads,
                                     const dynamics::EngineMethod& method) {
  return std::make_unique<OurWorld>(scene, threads, method);
}

}  // namespace stillgrid::performance
