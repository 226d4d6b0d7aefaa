#include "tests/laboratory/methods/broyden.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr int kFrictionIterations = 6;  // in which limits of friction follow normal forces

}  // namespace

void BroydenStep::solve(dynamics::SolveFigures& figures, const std::atomic<bool>* stop) {
  double residual = residual_m_s(), least = residual;
  best_ = velocities_;
  look(residual);
  // Nothing brings it back from an iterate that is not finite.
  for (int k = 0; k < most_iterations_ && residual > tolerance_m_s_ && std::isfinite(residual);
       ++k) {
    if (stop != nullptr && *stop) break;
    const auto taken = static_cast<std::size_t>(k);
    find_step(taken);
    ++figures.iterations;
    dynamics::each_awake(
        awake_, [&](std::size_t i) { velocities_[i] = velocities_[i] + steps_[taken][i]; });
    evaluate();
    if (k < kFrictionIterations) limit_friction();
    residual = residual_m_s();
    look(residual);
    if (!(residual < least)) continue;
    least = residual;
    best_ = velocities_;
  }
  velocities_ = best_;
  evaluate();
  figures.converged = least <= tolerance_m_s_;
  figures.residual_m_s = least;
}

/// The step number `taken`, from the residual and the steps before.
void BroydenStep::find_step(std::size_t taken) {
  if (steps_.size() <= taken) {
    steps_.emplace_back(velocities_.size());
    squares_.push_back(0.0);
  }
  dynamics::Motions& step = steps_[taken];
  std::fill(step.begin(), step.end(), dynamics::Vector4());
  for (const std::size_t i : nodes_) step[i] = -1.0 / description_.nodes[i].mass_kg * residual_[i];
  for (const std::size_t r : bodies_) {
    const auto& body = description_.rigid_bodies[r];
    const std::size_t centre = poses_.centre(r), spin = poses_.spin(r);
    step[centre] = -1.0 / body.mass_kg * residual_[centre];
    step[spin] = dynamics::Vector4(Eigen::Vector3d(
        -dynamics::inverse_inertia(poses_.from().orientation[r].quaternion(), body.inertia_kg_m2) *
        residual_[spin].vector()));
  }
  const auto along = [&](std::size_t j) { return dot(steps_[j], step, awake_) / squares_[j]; };
  // H_k = (1 + s_k s_(k-1)' / |s_(k-1)|^2) H_(k-1), by Sherman and Morrison; the last factor holds
  // the step sought itself.
  for (std::size_t j = 0; j + 1 < taken; ++j) {
    const double share = along(j);
    dynamics::each_awake(awake_,
                         [&](std::size_t i) { step[i] = step[i] + share * steps_[j + 1][i]; });
  }
  if (taken > 0) {
    const double scale = 1.0 / (1.0 - along(taken - 1));
    dynamics::each_awake(awake_, [&](std::size_t i) { step[i] = scale * step[i]; });
  }
  squares_[taken] = dot(step, step, awake_);
}

dynamics::EngineMethod by_broyden(double tolerance_m_s) {
  const auto make = [](const dynamics::Description& description, double tolerance) {
    return std::unique_ptr<dynamics::CoupledStep>(
        std::make_unique<BroydenStep>(description, tolerance));
  };
  return {.make = make, .has_end_forces = true, .tolerance_m_s = tolerance_m_s};
}

}  // namespace stillgrid::laboratory
