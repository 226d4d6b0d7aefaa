#include "tests/performance/work_precision_reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "sim_server/scene/build_world.hpp"

namespace stillgrid::performance {

SpringReference::SpringReference(const bodies::World& world)
    : springs_(world.springs), gravity_m_s2_(world.gravity_m_s2) {
  const auto count = static_cast<Eigen::Index>(world.nodes.size());
  positions_m_.resize(3, count);
  velocities_m_s_.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const bodies::Node& node = world.nodes[static_cast<std::size_t>(i)];
    inverse_masses_.push_back(node.pinned ? 0.0 : 1.0 / node.mass_kg);
    positions_m_.col(i) = node.position_m;
    velocities_m_s_.col(i) = node.velocity_m_s;
  }
  slope_m_s2_.resize(3, count);
}

void SpringReference::shift(const Eigen::Matrix3Xd& shift_m) {
  for (Eigen::Index i = 0; i < positions_m_.cols(); ++i)
    if (inverse_masses_[static_cast<std::size_t>(i)] > 0.0) positions_m_.col(i) += shift_m.col(i);
}

double SpringReference::stable_step_s() const {
  // Gershgorin: w^2 <= 2 sum of k / m over a node's springs.
  std::vector<double> sums(inverse_masses_.size(), 0.0);
  for (const bodies::Spring& spring : springs_)
    for (const int node : {spring.a, spring.b})
      sums[static_cast<std::size_t>(node)] += spring.stiffness_N_per_m;
  double square_rad2_s2 = 0.0;
  for (std::size_t i = 0; i < sums.size(); ++i)
    square_rad2_s2 = std::max(square_rad2_s2, 2.0 * sums[i] * inverse_masses_[i]);
  return 1.0 / std::sqrt(square_rad2_s2);
}

void SpringReference::accelerate(const Eigen::Matrix3Xd& positions_m,
                                 const Eigen::Matrix3Xd& velocities_m_s,
                                 Eigen::Matrix3Xd& accelerations_m_s2) const {
  accelerations_m_s2.setZero();
  for (const bodies::Spring& spring : springs_) {
    const Eigen::Vector3d apart_m = positions_m.col(spring.b) - positions_m.col(spring.a);
    const double length_m = apart_m.norm();
    double pull_N_per_m = spring.stiffness_N_per_m * (1.0 - spring.rest_length_m / length_m);
    if (spring.damping_N_s_per_m > 0.0)
      pull_N_per_m += spring.damping_N_s_per_m *
                      apart_m.dot(velocities_m_s.col(spring.b) - velocities_m_s.col(spring.a)) /
                      (length_m * length_m);
    accelerations_m_s2.col(spring.a) += pull_N_per_m * apart_m;
    accelerations_m_s2.col(spring.b) -= pull_N_per_m * apart_m;
  }
  for (Eigen::Index i = 0; i < accelerations_m_s2.cols(); ++i) {
    const double inverse_mass = inverse_masses_[static_cast<std::size_t>(i)];
    accelerations_m_s2.col(i) *= inverse_mass;
    if (inverse_mass > 0.0) accelerations_m_s2.col(i) += gravity_m_s2_;
  }
}

void SpringReference::step(double step_s) {
  constexpr std::array<double, 4> kBoundingRadius{0.5, 0.5, 1.0, 0.0}, kWeight{1.0, 2.0, 2.0, 1.0};
  moved_m_ = positions_m_;
  speeds_m_s_ = velocities_m_s_;
  sum_m_.setZero(3, positions_m_.cols());
  sum_m_s_.setZero(3, positions_m_.cols());
  for (std::size_t stage = 0; stage < kBoundingRadius.size(); ++stage) {
    accelerate(moved_m_, speeds_m_s_, slope_m_s2_);
    sum_m_ += kWeight[stage] * speeds_m_s_;
    sum_m_s_ += kWeight[stage] * slope_m_s2_;
    moved_m_ = positions_m_ + kBoundingRadius[stage] * step_s * speeds_m_s_;
    speeds_m_s_ = velocities_m_s_ + kBoundingRadius[stage] * step_s * slope_m_s2_;
  }
  positions_m_ += step_s / 6.0 * sum_m_;
  velocities_m_s_ += step_s / 6.0 * sum_m_s_;
}

void SpringReference::advance_to(double time_s, double step_s) {
  const int steps = static_cast<int>(std::ceil((time_s - time_s_) / step_s - 1e-9));
  const double each_s = (time_s - time_s_) / steps;
  for (int i = 0; i < steps; ++i) step(each_s);
  time_s_ = time_s;
}

namespace {

constexpr double kNoLimit_s = 600.0;

std::vector<Eigen::Matrix3Xd> by_springs(const ChartScene& scene, double step_s,
                                         const Eigen::Matrix3Xd& shift_m) {
  SpringReference reference(scene::build_world(scene.scene));
  if (shift_m.cols() > 0) reference.shift(shift_m);
  std::vector<Eigen::Matrix3Xd> places_m;
  for (const double until_s : {scene.early_s, scene.end_s}) {
    reference.advance_to(until_s, step_s);
    places_m.push_back(reference.positions_m());
  }
  return places_m;
}

std::vector<Eigen::Matrix3Xd> by_substeps(const ChartScene& scene, double step_s,
                                          const Eigen::Matrix3Xd& shift_m) {
  ChartPoint point;
  point.method.integrator = scene::IntegratorKind::kVelocityVerlet;
  point.method.substeps = static_cast<int>(std::lround(point.period_s / step_s));
  return run_ours(scene, point, kNoLimit_s, shift_m).places_m;
}

Errors between(const ChartScene& scene, const std::vector<Eigen::Matrix3Xd>& places_m,
               const std::vector<Eigen::Matrix3Xd>& reference_m) {
  RunResult run;
  run.places_m = places_m;
  return errors_of(scene, run, reference_m);
}

/// A shift of every place, of kDisturbance_m rms; the same on every run.
Eigen::Matrix3Xd disturbance_m(Eigen::Index places) {
  std::mt19937 random(1);
  Eigen::Matrix3Xd shift_m(3, places);
  for (double& x : shift_m.reshaped()) x = double(random()) / double(std::mt19937::max()) - 0.5;
  return kDisturbance_m / std::sqrt(shift_m.squaredNorm() / double(places)) * shift_m;
}

}  // namespace

Reference make_reference(const ChartScene& scene) {
  Reference reference;
  if (scene.name == "chain_modes") {
    for (const double time_s : {scene.early_s, scene.end_s})
      reference.places_m.push_back(chain_modes_positions_m(time_s));
    return reference;
  }
  const bodies::World world = scene::build_world(scene.scene);
  const auto run = scene.smooth ? by_springs : by_substeps;
  // What is large is dear.
  const double share = world.nodes.size() > 1000 ? 1.0 : world.nodes.size() > 100 ? 0.5 : 0.1;
  reference.step_s = scene.smooth ? share * SpringReference(world).stable_step_s() : 5e-6;
  reference.places_m = run(scene, reference.step_s, {});
  reference.on_halving = between(scene, run(scene, 2.0 * reference.step_s, {}), reference.places_m);
  reference.disturbed =
      between(scene, run(scene, 2.0 * reference.step_s, disturbance_m(positions_m(world).cols())),
              reference.places_m);
  return reference;
}

}  // namespace stillgrid::performance
