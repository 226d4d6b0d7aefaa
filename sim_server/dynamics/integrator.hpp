#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/budget.hpp"
#include "sim_server/dynamics/nonlinear_solver.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid {

/// Where a step led, not yet the world's own.
struct Trial {
  std::vector<Node> nodes;              // as World::nodes
  std::vector<RigidBody> rigid_bodies;  // as World::rigid_bodies
  std::vector<SphereMotion> spheres;    // of World::spheres
  int touching = 0;                     // contacts that touch at its end
  bool struck = false;                  // something touched on the way, where that was looked at
};

/// Energy that left or entered by other ways than gravity, springs and contact springs, J. Losses
/// are positive.
struct EnergyFlow {
  double spring_damping_J = 0.0;
  double contact_damping_J = 0.0;
  double friction_J = 0.0;
  double given_J = 0.0;  // work done on the world by what is moved from outside: tool, prescribed
};

/// Moves a world on under springs, gravity and contacts. One object serves one world: it may
/// keep what earlier steps taught it.
class Integrator {
 public:
  Integrator() = default;
  virtual ~Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;
  Integrator(Integrator&&) = delete;
  Integrator& operator=(Integrator&&) = delete;

  /// Computes where the world will be after duration_s; the world stays as it is. contacts: all
  /// pairs that may touch within that time. Of a step that did not converge the trial is the best
  /// there was; if that is no number, the trial is the world's own state at rest.
  virtual SolveReport advance(const World& world, std::span<const Contact> contacts,
                              double duration_s, Budget& budget) = 0;

  /// Leads on where the last advance() led, if that converged, to what other contacts with what is
  /// given, as the tool, make of the step: world and duration are the same. Begins at its trial,
  /// and leaves that as it is unless this converges too. By default there is no such way.
  virtual SolveReport correct(const World& /*world*/, std::span<const Contact> /*contacts*/,
                              double /*duration_s*/, Budget& /*budget*/) {
    return {};
  }

  /// Where the last advance() or correct() led.
  [[nodiscard]] const Trial& trial() const noexcept { return trial_; }

  /// The energy that flowed over the last advance(), of an integrator that looked within its step.
  [[nodiscard]] virtual std::optional<EnergyFlow> flow() const { return std::nullopt; }

  /// The trial becomes the world's state, duration_s later. The integrator learns of it: a step
  /// that was not committed leaves no trace in its history.
  virtual void commit(World& world, double duration_s);

  /// Forgets earlier steps: the world was changed from outside, or its unknowns numbered anew.
  virtual void restart() {}

 protected:
  Trial trial_;
};

[[nodiscard]] std::unique_ptr<Integrator> make_integrator(const Method& method);

}  // namespace stillgrid
