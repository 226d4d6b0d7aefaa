#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "tests/laboratory/rivals/local_model_renderer.hpp"
#include "tests/laboratory/rivals/shipped_step.hpp"

namespace stillgrid::laboratory {

/// The contact problem of the simulation's last step, solved again each tick for where the tool now
/// is: contacts are unilateral, along directions n that stay as the step had them, and bodies give
/// way by the compliance W = H C H^T of that step, condensed on the contacts,
///   0 <= d + (W + 1/k) f  _|_  f >= 0,   d = free gap at the sample + n . (x - x0).
/// [Saupin, Duriez, Cotin 2008, Contact model for haptic medical simulations; SOFA's
/// LCPForceFeedback, doComputeForce().]
///
/// Theirs: W and the free gaps are those of the step that the snapshot ends, which the tool of the
/// tick bends; they change at once when a new problem comes, no blend between; Gauss-Seidel of 100
/// iterations at most begins with the forces before, and in a new problem with the simulation's;
/// the force is the sum of n f, scaled by 1 (forceCoef).
///
/// Chosen: the tool's own compliance, in SOFA that of its mass on the spring that couples it to the
/// device, is 1 / k with k the contact stiffness of the material, so that a wall feels as stiff as
/// with every other model, and the step of this simulation, whose springs act at its end, is the
/// solution of the same problem. Contacts are frictionless (theirs may have Coulomb's law) and have
/// no damper. Those handed over are what is within the patch, the 16 nearest.
class ConstraintModel final : public LocalModel {
 public:
  void after_step(const dynamics::Simulation& simulation) { steps_.take(simulation); }
  void update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool& present,
              bool is_first) noexcept override;
  [[nodiscard]] rendering::ToolForce force(const LocalScene& scene,
                                           const PlacedTool& tool) noexcept override;

 private:
  struct Constraint {
    std::uint32_t tool_sphere;
    Eigen::Vector3d normal;     // towards the tool
    Eigen::Vector3d sampled_m;  // where the tool's sphere was
    double gap_m;               // at the step's end
    double stiffness_N_per_m;
    int sphere;  // that moves, of the world's; -1: it is fixed
  };
  void find_constraints(const LocalScene& scene, const PlacedTool& sampled);
  void solve(const Eigen::VectorXd& gaps_m) noexcept;

  ShippedSteps steps_;
  std::vector<Constraint> constraints_;
  Eigen::MatrixXd compliance_m_per_N_;  // of the contacts, the tool's own in its diagonal
  Eigen::VectorXd free_gaps_m_, forces_N_;
};

/// Renders it, and hands it the simulation's steps.
class ConstraintRenderer final : public LocalModelRenderer, public SeesSteps {
 public:
  ConstraintRenderer() : ConstraintRenderer(new ConstraintModel) {}
  void after_step(const dynamics::Simulation& simulation) override {
    model_.after_step(simulation);
  }

 private:
  explicit ConstraintRenderer(ConstraintModel* model)
      : LocalModelRenderer(std::unique_ptr<LocalModel>(model)), model_(*model) {}

  ConstraintModel& model_;
};

}  // namespace stillgrid::laboratory
