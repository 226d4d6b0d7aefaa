#include "tests/performance/pile.hpp"

#include <unistd.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "shared/publication/scene_segment.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::performance {
namespace {

constexpr int kLayers = 10;
constexpr double kMinRadius_m = 0.008, kMaxRadius_m = 0.012, kDensity_kg_per_m3 = 1000.0;
constexpr double kStiffness_N_per_m = 1000.0, kDamping_N_s_per_m = 2.0;
constexpr double kSpacing_m = 2.05 * kMaxRadius_m;

class Draws {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  PileSphere sphere(const Eigen::Vector3d& position_m) {
    const double radius_m = between(kMinRadius_m, kMaxRadius_m);
    const double volume_m3 = 4.0 / 3.0 * std::numbers::pi * std::pow(radius_m, 3);
    return {position_m, radius_m, kDensity_kg_per_m3 * volume_m3};
  }

 private:
  std::mt19937_64 random_{17};
};

scene::SceneDescription scene_of(const Pile& pile, bool may_sleep) {
  scene::SceneDescription scene;
  scene.name = "pile";
  scene.gravity_m_s2 = {0.0, 0.0, -kPileGravity_m_s2};
  scene.period_s = kPileStep_s;
  scene.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  scene.sleeping = may_sleep;
  scene.materials = {{"m", kStiffness_N_per_m, kDamping_N_s_per_m, pile.friction}};
  const auto add_plane = [&](const Eigen::Vector3d& normal, const Eigen::Vector3d& at_m) {
    bodies::BodyDescription& body = scene.bodies.emplace_back();
    body.name = "plane " + std::to_string(scene.bodies.size());
    body.motion = bodies::Motion::kStatic;
    body.shape = bodies::PlaneBody{normal};
    body.position_m = at_m;
  };
  add_plane(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero());
  for (int axis = 0; axis < 2 && !pile.bin_m.isZero(); ++axis) {
    add_plane(Eigen::Vector3d::Unit(axis), Eigen::Vector3d::Zero());
    add_plane(-Eigen::Vector3d::Unit(axis), pile.bin_m[axis] * Eigen::Vector3d::Unit(axis));
  }
  for (const PileSphere& sphere : pile.spheres) {
    bodies::BodyDescription& body = scene.bodies.emplace_back();
    body.name = "sphere " + std::to_string(scene.bodies.size());
    body.shape = bodies::SphereBody{sphere.radius_m};
    body.position_m = sphere.position_m;
    body.mass_kg = sphere.mass_kg;
  }
  return scene;
}

class OurPile : public PileEngine {
 public:
  OurPile(const scene::SceneDescription& scene, bool predicts, int threads)
      : predicts_(predicts),
        workers_(threads),
        simulation_(scene),
        writer_("pile_" + std::to_string(getpid()), sim_server::static_scene(scene, simulation_),
                simulation_.world().spheres.size(), 10'000'000, proto::Clock::kVirtual, 0) {
    simulation_.share_work(workers_);
  }

  void step() override {
    report_ = simulation_.step(kPileStep_s, [] { return std::nullopt; });
    publication::SnapshotPrediction prediction;
    if (predicts_) prediction = simulation_.predict_next(kPileStep_s);
    now_ns_ += 10'000'000;
    writer_.publish(simulation_.snapshot(), {.state_ns = now_ns_, .publish_ns = now_ns_},
                    prediction, simulation_.field_records());
  }
  [[nodiscard]] int touching() const override { return report_.contacts; }
  [[nodiscard]] int sleeping() const override { return report_.sleeping_spheres; }
  [[nodiscard]] double mean_height_m() const override {
    double sum_m = 0.0;
    for (const bodies::RigidBody& body : simulation_.world().rigid_bodies)
      sum_m += body.position_m.z();
    return sum_m / static_cast<double>(simulation_.world().rigid_bodies.size());
  }

 private:
  bool predicts_;
  dynamics::Workers workers_;
  dynamics::Simulation simulation_;
  publication::SceneWriter writer_;
  dynamics::StepReport report_;
  std::uint64_t now_ns_ = 0;
};

}  // namespace

Pile falling_pile(int count) {
  Draws draws;
  Pile pile;
  const int a_layer = (count + kLayers - 1) / kLayers;
  const int columns = static_cast<int>(std::ceil(std::sqrt(a_layer)));
  const int rows = (a_layer + columns - 1) / columns;
  const double margin_m = 0.5 * kSpacing_m;
  for (int i = 0; i < count; ++i) {
    const int place = i % a_layer, layer = i / a_layer;
    Eigen::Vector3d at_m = kSpacing_m * Eigen::Vector3d(place % columns, place / columns, layer);
    // Out of line by less than what keeps the largest apart, so that no column stands.
    for (double& coordinate : at_m) coordinate += margin_m + draws.between(0.0, 4e-4);
    pile.spheres.push_back(draws.sphere(at_m));
  }
  pile.bin_m = kSpacing_m * Eigen::Vector2d(columns, rows);
  return pile;
}

Pile lying_spheres(int count) {
  Draws draws;
  Pile pile;
  const int columns = static_cast<int>(std::ceil(std::sqrt(count)));
  for (int i = 0; i < count; ++i) {
    PileSphere& sphere = pile.spheres.emplace_back(
        draws.sphere(kSpacing_m * Eigen::Vector3d(i % columns, i / columns, 0.0)));
    sphere.position_m.z() =
        sphere.radius_m - sphere.mass_kg * kPileGravity_m_s2 / kStiffness_N_per_m;
  }
  return pile;
}

std::unique_ptr<PileEngine> our_pile(const Pile& pile, bool may_sleep, bool predicts, int threads) {
  return std::make_unique<OurPile>(scene_of(pile, may_sleep), predicts, threads);
}

}  // namespace stillgrid::performance
