#pragma once

#include <memory>
#include <span>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/contacts/contact_memory.hpp"
#include "sim_server/dynamics/forces/trial.hpp"
#include "sim_server/dynamics/solvers/budget.hpp"
#include "sim_server/dynamics/solvers/nonlinear_solver.hpp"
#include "sim_server/scene/method.hpp"

namespace stillgrid::dynamics {

/// What an integrator can, by which the simulation divides a step and judges what came of it.
struct IntegratorTraits {
  bool solves = false;      // by a NonlinearSolver: its iterations are the budget's
  int most_iterations = 0;  // of a part; 0: as few as let a part that does not converge be halved
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

  [[nodiscard]] virtual IntegratorTraits traits() const noexcept = 0;

  /// Computes where the world will be after duration_s; the world stays as it is. contacts: all
  /// pairs that may touch within that time. A step that did not converge leaves the best state that
  /// it found as its trial. If that state is not finite, the trial says so and is not to be used.
  virtual SolveReport advance(const bodies::World& world,
                              std::span<const contact::Contact> contacts, double duration_s,
                              Budget& budget) = 0;

  /// Where the last advance() led.
  [[nodiscard]] const Trial& trial() const noexcept { return trial_; }

  /// What sticks, of an integrator in which something does; null: nothing.
  [[nodiscard]] virtual ContactMemories* memories() { return nullptr; }

  /// The trial becomes the world's state, duration_s later. The integrator learns of it: a step
  /// that was not committed leaves no trace in its history.
  virtual void commit(bodies::World& world, double duration_s);

  /// Forgets earlier steps: the world was changed from outside, or its unknowns numbered anew. What
  /// sticks is no step: it lasts.
  virtual void restart() {}

 protected:
  Trial trial_;
};

/// Throws std::invalid_argument for methods of the engine.
[[nodiscard]] std::unique_ptr<Integrator> make_integrator(const scene::Method& method);

}  // namespace stillgrid::dynamics
