#include "sim_server/dynamics/integrators/sundials_integrator.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/dynamics/forces/mechanical_system.hpp"
#include "sim_server/dynamics/integrators/implicit_stage.hpp"
#include "sim_server/dynamics/integrators/sundials_stepper.hpp"
#include "sim_server/dynamics/solvers/linear_solver.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kMaxTurn_rad = 2.0;  // from the base; at a whole turn rotation vectors end
constexpr double kByVelocity = 0.0;   // contact dampers act on velocities

/// Whether what is free stands and moves in `world` exactly as in `trial`.
bool same_state(const bodies::World& world, const Trial& trial) {
  const auto same = [](const auto& a, const auto& b) {
    return a.unknown == b.unknown && a.position_m == b.position_m &&
           a.velocity_m_s == b.velocity_m_s;
  };
  const auto same_body = [&](const bodies::RigidBody& a, const bodies::RigidBody& b) {
    return same(a, b) && a.orientation.coeffs() == b.orientation.coeffs() &&
           a.angular_velocity_rad_s == b.angular_velocity_rad_s;
  };
  return std::ranges::equal(world.nodes, trial.nodes, same) &&
         std::ranges::equal(world.rigid_bodies, trial.rigid_bodies, same_body);
}

}  // namespace

/// The equations of motion, first order, in y = [displacements from a base; velocities]:
///   q' = u (rotation vectors: J^-1 u),  u' = M^-1 (f - gyroscopic torque).
struct SundialsIntegrator::Run {
  Run(MakeStepper make_stepper, double tolerance_m_s, const bodies::World& world,
      double duration_s);

  void take(std::span<const contact::Contact> next, double duration_s);
  bool integrate(bool may_pass, long most_steps);
  int derivative(double at_s, N_Vector y, N_Vector result);
  int solve_linear(N_Vector x, N_Vector b, double tolerance);
  void load(double at_s);
  Eigen::VectorXd stiffness_times(const Eigen::VectorXd& direction);
  void date_back(contact::Contact& contact, double stage_s) const;
  void date_back_field(contact::Contact& contact, double stage_s) const;
  [[nodiscard]] double share_of(double at_s) const {  // of the step that is over then
    return std::clamp((at_s - start_s) / (end_s - start_s), 0.0, 1.0);
  }
  [[nodiscard]] bool turned_far() const;
  [[nodiscard]] Eigen::Index size() const { return base.unknown_count; }

  // Freed in the reverse order: the context last.
  SunContext context = make_sun_context();
  SunVector state;
  SunLinearSolver linear;
  std::unique_ptr<SundialsStepper> stepper;

  bodies::World base;
  std::vector<contact::Contact> contacts;
  MechanicalSystem system;
  KrylovLinearSolver jacobians;
  double now_s = 0.0, start_s = 0.0, end_s = 0.0;  // since the base
  double loaded_s = 0.0;
  bool passed = false;  // steps may have gone beyond now_s
  Eigen::VectorXd displacement, velocity, force;
  N_Vector weights = nullptr;  // of errors, SUNDIALS'
  Budget clock;                // without its iterations
  std::exception_ptr thrown;
};

namespace {

/// The solver SUNDIALS asks for (1 - gamma J) x = b, as an object of its kind.
template <class Run>
SunLinearSolver make_linear_solver(Run& run, SUNContext context) {
  SunLinearSolver solver(sun_checked(SUNLinSolNewEmpty(context)));
  solver->content = &run;
  solver->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_MATRIX_EMBEDDED; };
  solver->ops->setscalingvectors = [](SUNLinearSolver self, N_Vector weights, N_Vector) {
    static_cast<Run*>(self->content)->weights = weights;
    return 0;
  };
  solver->ops->solve = [](SUNLinearSolver self, SUNMatrix, N_Vector x, N_Vector b,
                          sunrealtype tolerance) {
    Run& owner = *static_cast<Run*>(self->content);
    const int result =
        keep_exception(owner.thrown, [&] { return owner.solve_linear(x, b, tolerance); });
    return result == kSunStop ? static_cast<int>(SUNLS_ATIMES_FAIL_UNREC) : result;
  };
  solver->ops->free = [](SUNLinearSolver self) {
    SUNLinSolFreeEmpty(self);
    return 0;
  };
  return solver;
}

}  // namespace

SundialsIntegrator::Run::Run(MakeStepper make_stepper, double tolerance_m_s,
                             const bodies::World& world, double duration_s)
    : state(make_sun_vector(2 * world.unknown_count, context.get())),
      linear(make_linear_solver(*this, context.get())),
      base(world) {
  system.take(base, {});
  values_of(state.get()).head(size()).setZero();
  values_of(state.get()).tail(size()) = system.velocity();
  // Scales turn momenta into speeds, so scale times mass is what makes a speed of an unknown.
  const SunVector absolute = make_sun_vector(2 * size(), context.get());
  const Eigen::VectorXd speed =
      tolerance_m_s * system.momentum_scale().cwiseProduct(system.mass_diagonal()).cwiseInverse();
  values_of(absolute.get()).head(size()) = duration_s * speed;
  values_of(absolute.get()).tail(size()) = speed;

  const auto slope_at = [](sunrealtype at_s, N_Vector y, N_Vector result, void* data) {
    Run& run = *static_cast<Run*>(data);
    return keep_exception(run.thrown, [&] { return run.derivative(at_s, y, result); });
  };
  stepper = make_stepper({.context = context.get(),
                          .state = state.get(),
                          .slope = slope_at,
                          .data = this,
                          .relative_tolerance = tolerance_m_s,
                          .absolute_tolerances = absolute.get(),
                          .linear = linear.get()});
}

/// The contacts to come, from now for duration_s.
void SundialsIntegrator::Run::take(std::span<const contact::Contact> next, double duration_s) {
  contacts.assign(next.begin(), next.end());
  system.take(base, contacts);
  start_s = now_s;
  end_s = now_s + duration_s;
}

/// On to end_s; whether it got there.
bool SundialsIntegrator::Run::integrate(bool may_pass, long most_steps) {
  passed = may_pass;
  constexpr double kFar_s = 1e9;  // a stop once set cannot be taken back
  const bool went_on = stepper->evolve(end_s, may_pass ? kFar_s : end_s, most_steps, now_s);
  if (thrown) std::rethrow_exception(thrown);
  return went_on && now_s == end_s;
}

/// Places the system where displacement and velocity say, and finds the forces there.
void SundialsIntegrator::Run::load(double at_s) {
  loaded_s = at_s;
  system.place(displacement, velocity, at_s, share_of(at_s));
  system.force(kByVelocity, force);
}

int SundialsIntegrator::Run::derivative(double at_s, N_Vector y, N_Vector result) {
  if (clock.spent()) return kSunStop;
  displacement = values_of(y).head(size());
  velocity = values_of(y).tail(size());
  if (!displacement.allFinite() || !velocity.allFinite()) return kSunRetry;
  load(at_s);
  auto moves = values_of(result).head(size());
  auto changes = values_of(result).tail(size());
  moves = velocity;
  changes = force.cwiseQuotient(system.mass_diagonal());
  for (const bodies::RigidBody& body : system.trial().rigid_bodies) {
    if (body.unknown == bodies::kNoUnknown) continue;
    const Eigen::Index turn = body.unknown + 3;
    const Eigen::Vector3d w = body.angular_velocity_rad_s;
    const Eigen::Matrix3d inertia = bodies::world_inertia_kg_m2(body);
    moves.segment<3>(turn) = bodies::left_jacobian(displacement.segment<3>(turn)).inverse() * w;
    changes.segment<3>(turn) = inertia.inverse() * (force.segment<3>(turn) - w.cross(inertia * w));
  }
  return changes.allFinite() ? kSunDone : kSunRetry;
}

/// How the forces change with the displacement along `direction`, where all was loaded last.
Eigen::VectorXd SundialsIntegrator::Run::stiffness_times(const Eigen::VectorXd& direction) {
  constexpr double kSmall_m = 1e-7;
  const double most = direction.cwiseAbs().maxCoeff();
  if (!(most > 0.0)) return Eigen::VectorXd::Zero(size());
  const Eigen::VectorXd here_m = displacement, here_N = force;
  displacement += kSmall_m / most * direction;
  load(loaded_s);
  const Eigen::VectorXd change = most / kSmall_m * (force - here_N);
  displacement = here_m;
  load(loaded_s);
  return change;
}

/// Solves (1 - gamma J) x = b where the derivative was asked for last. With D and K the forces'
/// Jacobians by velocity and displacement, b = [r; s] and x = [r + gamma z; z] it is
///   (M - gamma D - gamma^2 K) z = M s + gamma K r,
/// of half the size, symmetric but for friction and spin, and an implicit stage's own Jacobian.
int SundialsIntegrator::Run::solve_linear(N_Vector x, N_Vector b, double tolerance) {
  const double gamma_s = stepper->gamma_s();
  const auto moved = values_of(b).head(size()), sped = values_of(b).tail(size());
  Eigen::VectorXd right = system.mass_diagonal().cwiseProduct(sped);
  for (const bodies::RigidBody& body : system.trial().rigid_bodies)
    if (body.unknown != bodies::kNoUnknown)
      right.segment<3>(body.unknown + 3) =
          bodies::world_inertia_kg_m2(body) * sped.segment<3>(body.unknown + 3);
  right += gamma_s * stiffness_times(moved);

  for (contact::Contact& contact : contacts) date_back(contact, gamma_s);
  StageRule rule;
  rule.stage_s = gamma_s;
  rule.end_s = loaded_s;
  ImplicitStage stage(system, rule);
  // The solver's norm is of momenta: where a spin weighs little it must look closer.
  const Eigen::VectorXd& scale = system.momentum_scale();
  const double accuracy = std::clamp(tolerance / N_VWL2Norm(b, weights), 1e-9, 0.02) *
                          scale.minCoeff() / scale.maxCoeff();
  const bool symmetric = contacts.empty() && base.rigid_bodies.empty();
  Eigen::VectorXd z(size());
  if (!jacobians.solve(stage, symmetric ? JacobianKind::kSymmetric : JacobianKind::kExact, right,
                       accuracy, clock, z))
    return SUNLS_CONV_FAIL;
  values_of(x).tail(size()) = z;
  for (const bodies::RigidBody& body : base.rigid_bodies)
    if (body.unknown != bodies::kNoUnknown) {
      const Eigen::Matrix3d by_turn =
          bodies::left_jacobian(displacement.segment<3>(body.unknown + 3));
      z.segment<3>(body.unknown + 3) = (by_turn.inverse() * z.segment<3>(body.unknown + 3)).eval();
    }
  values_of(x).head(size()) = moved + gamma_s * z;
  return kSunDone;
}

/// Jacobians know a damper's rate by the depth a stage before: the depth that means the speed of
/// now.
void SundialsIntegrator::Run::date_back(contact::Contact& contact, double stage_s) const {
  const std::vector<bodies::SphereMotion>& spheres = system.trial().spheres;
  if (bodies::is_field(base, contact.a) || bodies::is_field(base, contact.b)) {
    date_back_field(contact, stage_s);
    return;
  }
  bodies::SphereMotion relative = spheres[static_cast<std::size_t>(contact.a)];
  Eigen::Vector3d normal = contact.plane_normal;
  if (!contact.is_plane) {
    const bodies::SphereMotion given{contact::kinematic_position_m(contact, share_of(loaded_s)),
                                     contact.velocity_b_m_s};
    const bodies::SphereMotion& other =
        contact.b >= 0 ? spheres[static_cast<std::size_t>(contact.b)] : given;
    relative.position_m -= other.position_m;
    relative.velocity_m_s -= other.velocity_m_s;
    normal = relative.position_m.normalized();
  }
  contact.depth_before_m = contact::contact_depth_m(contact, relative.position_m) +
                           stage_s * normal.dot(relative.velocity_m_s);
}

void SundialsIntegrator::Run::date_back_field(contact::Contact& contact, double stage_s) const {
  const Trial& trial = system.trial();
  const bool is_first = bodies::is_field(base, contact.a);
  const bodies::FieldBody& field = bodies::field_of(base, is_first ? contact.a : contact.b);
  const bodies::SphereMotion other =
      is_first ? bodies::SphereMotion{contact::kinematic_position_m(contact, share_of(loaded_s)),
                                      contact.velocity_b_m_s}
               : trial.spheres[static_cast<std::size_t>(contact.a)];
  const contact::FieldTouch touch =
      contact::touch_of(field, contact::pose_of(field, trial.rigid_bodies), other.position_m,
                        is_first ? contact.radius_b_m : contact.radius_a_m);
  Eigen::Vector3d apart_m_s = other.velocity_m_s;
  if (field.rigid >= 0) {
    const bodies::RigidBody& body = trial.rigid_bodies[static_cast<std::size_t>(field.rigid)];
    apart_m_s -=
        body.velocity_m_s + body.angular_velocity_rad_s.cross(other.position_m - body.position_m);
  }
  contact.depth_before_m = touch.depth_m + stage_s * touch.normal.dot(apart_m_s);
}

bool SundialsIntegrator::Run::turned_far() const {
  return std::ranges::any_of(base.rigid_bodies, [&](const bodies::RigidBody& body) {
    return body.unknown != bodies::kNoUnknown &&
           displacement.segment<3>(body.unknown + 3).norm() > kMaxTurn_rad;
  });
}

SundialsIntegrator::SundialsIntegrator(MakeStepper make_stepper, double tolerance_m_s)
    : make_stepper_(make_stepper), tolerance_m_s_(tolerance_m_s) {}
SundialsIntegrator::~SundialsIntegrator() = default;

SolveReport SundialsIntegrator::advance(const bodies::World& world,
                                        std::span<const contact::Contact> contacts,
                                        double duration_s, Budget& budget) {
  SolveReport report;
  report.converged = true;
  if (world.unknown_count == 0) {
    MechanicalSystem still(world, contacts);
    still.place(Eigen::VectorXd(), Eigen::VectorXd(), duration_s);
    trial_ = still.trial();
    return report;
  }
  const bool goes_on = run_ && run_is_world_ && run_->size() == world.unknown_count &&
                       !(run_->passed && !contacts.empty()) && !run_->turned_far() &&
                       same_state(world, trial_);
  if (!goes_on) run_ = std::make_unique<Run>(make_stepper_, tolerance_m_s_, world, duration_s);
  run_is_world_ = false;
  Run& run = *run_;
  run.take(contacts, duration_s);
  run.clock = budget;
  run.clock.iterations = std::numeric_limits<int>::max();
  const long before = run.stepper->steps_taken();
  report.converged = !budget.spent() && run.integrate(contacts.empty(), budget.iterations);
  report.iterations = static_cast<int>(run.stepper->steps_taken() - before);
  budget.iterations -= report.iterations;
  report.residual = report.converged ? tolerance_m_s_ : std::numeric_limits<double>::infinity();
  run.displacement = values_of(run.state.get()).head(run.size());
  run.velocity = values_of(run.state.get()).tail(run.size());
  trial_.is_finite = run.displacement.allFinite() && run.velocity.allFinite();
  if (!trial_.is_finite) {
    report.converged = false;
    return report;
  }
  run.load(run.now_s);
  trial_ = run.system.trial();
  return report;
}

void SundialsIntegrator::commit(bodies::World& world, double duration_s) {
  Integrator::commit(world, duration_s);
  run_is_world_ = run_ && run_->now_s == run_->end_s;
}

void SundialsIntegrator::restart() {
  run_.reset();
  run_is_world_ = false;
}

std::unique_ptr<Integrator> make_cvode_integrator(double tolerance_m_s) {
  return std::make_unique<SundialsIntegrator>(make_cvode_stepper, tolerance_m_s);
}

}  // namespace stillgrid::dynamics
