#include "sim_server/dynamics/integrators/cvode_step.hpp"

#include <cvode/cvode.h>
#include <cvode/cvode_ls.h>
#include <sunlinsol/sunlinsol_spgmr.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "shared/dynamics/coupled_step.hpp"
#include "shared/dynamics/joint_forces.hpp"
#include "shared/dynamics/rigid_motion.hpp"
#include "shared/dynamics/spring_table.hpp"
#include "sim_server/bodies/rotation.hpp"
#include "sim_server/dynamics/integrators/sundials_memory.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kMaxTurn_rad = 2.0;  // in a tick; at a whole turn rotation vectors end
constexpr long kMaxSteps = 5'000;     // in a part of a tick
constexpr int kKrylov = 30;           // largest dimension of a Krylov space
constexpr double kAnyError = 1e30;    // absolute tolerance of components that choose no step
/// In the state, of a driven body: impulse and moment, of all forces and by driven bodies.
constexpr Eigen::Index kReaction = 12;
constexpr Eigen::Index kLosses = 3;

/// The equations of motion, first order, in
///   y = [displacements from the tick's start; velocities; stretches of friction; reactions;
///   losses].
/// Rotations are rotation vectors p, with p' = J^-1(p) w. Reactions of driven bodies and losses are
/// integrals that choose no step.
class CvodeStep final : public CoupledStep {
 public:
  CvodeStep(const Description& description, double tolerance_m_s);

  void leave_out(const Sleep& sleep) override;
  void restart(const ContactListing& listing) override;
  void solve(SolveFigures& figures, const std::atomic<bool>* stop) override;
  [[nodiscard]] bool passes() const override { return turns_far_ || CoupledStep::passes(); }
  [[nodiscard]] EnergyLosses losses() const override { return losses_; }

 private:
  using Block = Eigen::Map<Eigen::Matrix3Xd>;
  /// Parts of a state, or of its derivative.
  struct Parts {
    Block moved, velocities, stretches, reactions;
    Eigen::Map<Eigen::Vector3d> losses;
  };
  [[nodiscard]] Parts parts_of(N_Vector y) const;
  [[nodiscard]] Eigen::Index size() const;
  [[nodiscard]] SunVector begun_state() const;
  [[nodiscard]] SunVector tolerances() const;
  void place(double at_s, const Parts& y);
  void sum_forces();
  void sum_losses();
  int slope(double at_s, N_Vector y, N_Vector result);
  long integrate(void* memory, N_Vector y);

  double tolerance_m_s_;
  SunContext context_ = make_sun_context();
  SpringTable springs_;
  Description dampers_;
  SpringTable damper_table_;
  std::vector<Description::Joint> joints_, joint_dampers_;  // those that are awake
  std::vector<std::size_t> moving_;                         // nodes, centres, then rotations
  std::vector<std::size_t> driven_;                         // rigid bodies
  const ContactListing* listing_ = nullptr;
  const std::atomic<bool>* stop_ = nullptr;
  Motions displacements_;  // over the tick's length
  Motions damped_;         // forces of dampers alone
  std::vector<Wrench> wrenches_;
  SceneState now_;
  Eigen::Matrix3Xd rates_m_s_;  // of stretches
  EnergyLosses powers_, losses_;
  double reached_s_ = 0.0;
  bool turns_far_ = false;
};

CvodeStep::CvodeStep(const Description& description, double tolerance_m_s)
    : CoupledStep(description),
      tolerance_m_s_(tolerance_m_s),
      springs_(description),
      dampers_(dampers_of(description)),
      damper_table_(dampers_),
      displacements_(velocities_.size()),
      damped_(velocities_.size()),
      wrenches_(description.rigid_bodies.size()) {
  for (std::size_t r = 0; r < description.rigid_bodies.size(); ++r)
    if (description.rigid_bodies[r].is_driven) driven_.push_back(r);
  now_.node_velocity_m_s.resize(description.nodes.size());
  now_.rigid_velocity_m_s.resize(description.rigid_bodies.size());
  now_.angular_velocity_rad_s.resize(description.rigid_bodies.size());
}

void CvodeStep::leave_out(const Sleep& sleep) {
  CoupledStep::leave_out(sleep);
  springs_.leave_out(sleep.nodes());
  damper_table_.leave_out(sleep.nodes());
  find_awake_joints(description_, sleep, joints_);
  find_awake_joints(dampers_, sleep, joint_dampers_);
  std::fill(displacements_.begin(), displacements_.end(), Vector4());
  moving_ = nodes_;
  for (const std::size_t r : bodies_) moving_.push_back(poses_.centre(r));
  for (const std::size_t r : bodies_) moving_.push_back(poses_.spin(r));
}

void CvodeStep::restart(const ContactListing& listing) {
  listing_ = &listing;
  contacts_.start(poses_, listing);
  contacts_.move(poses_);
  rates_m_s_.setZero(3, static_cast<Eigen::Index>(contacts_.couplings().size()));
  turns_far_ = false;
}

CvodeStep::Parts CvodeStep::parts_of(N_Vector y) const {
  double* from = NV_DATA_S(y);
  const auto block = [&](Eigen::Index columns) {
    Block part(from, 3, columns);
    from += 3 * columns;
    return part;
  };
  const auto count = static_cast<Eigen::Index>(moving_.size());
  const auto reactions = kReaction / 3 * static_cast<Eigen::Index>(driven_.size());
  Block moved = block(count), velocities = block(count), stretches = block(rates_m_s_.cols()),
        reaction = block(reactions);
  return {moved, velocities, stretches, reaction, Eigen::Map<Eigen::Vector3d>(from)};
}

Eigen::Index CvodeStep::size() const {
  return static_cast<Eigen::Index>(6 * moving_.size() + kReaction * driven_.size()) +
         rates_m_s_.size() + kLosses;
}

SunVector CvodeStep::begun_state() const {
  SunVector y = make_sun_vector(size(), context_.get());
  values_of(y.get()).setZero();
  const Parts parts = parts_of(y.get());
  contacts_.write_stretches(parts.stretches);
  Block velocities = parts.velocities;
  Eigen::Index column = 0;
  for (const std::size_t i : nodes_)
    velocities.col(column++) = poses_.from().node_velocity_m_s[i].vector();
  for (const std::size_t r : bodies_)
    velocities.col(column++) = poses_.from().rigid_velocity_m_s[r].vector();
  for (const std::size_t r : bodies_)
    velocities.col(column++) = poses_.from().angular_velocity_rad_s[r].vector();
  return y;
}

SunVector CvodeStep::tolerances() const {
  SunVector all = make_sun_vector(size(), context_.get());
  Parts parts = parts_of(all.get());
  parts.velocities.setConstant(tolerance_m_s_);
  auto spins = parts.velocities.rightCols(static_cast<Eigen::Index>(bodies_.size()));
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    spins.col(static_cast<Eigen::Index>(b)) /= reaches_m_[bodies_[b]];
  parts.moved = poses_.step_s() * parts.velocities;
  parts.stretches.setConstant(poses_.step_s() * tolerance_m_s_);
  parts.reactions.setConstant(kAnyError);
  parts.losses.setConstant(kAnyError);
  return all;
}

/// Places all where the state says, with what contacts do there.
void CvodeStep::place(double at_s, const Parts& y) {
  for (std::size_t k = 0; k < moving_.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    displacements_[moving_[k]] = Vector4(Eigen::Vector3d(y.moved.col(column) / poses_.step_s()));
    velocities_[moving_[k]] = Vector4(Eigen::Vector3d(y.velocities.col(column)));
  }
  const double share = at_s / poses_.step_s();
  for (const std::size_t r : driven_)
    for (const std::size_t i : {poses_.centre(r), poses_.spin(r)})
      displacements_[i] = share * velocities_[i];
  poses_.move(displacements_, awake_);
  powers_ = {};
  contacts_.evaluate_instant(poses_, velocities_, y.stretches, rates_m_s_, powers_);
}

/// Sums forces in impulses_, as impulses of one second.
void CvodeStep::sum_forces() {
  const std::size_t nodes = description_.nodes.size(), bodies = wrenches_.size();
  for (Motions* all : {&impulses_, &driven_impulses_})
    std::fill(all->begin(), all->end(), Vector4());
  std::fill(wrenches_.begin(), wrenches_.end(), Wrench());
  now_.node_position_m = poses_.to().node_position_m;
  now_.rigid_position_m = poses_.to().rigid_position_m;
  now_.orientation = poses_.to().orientation;
  std::copy_n(velocities_.begin(), nodes, now_.node_velocity_m_s.begin());
  for (std::size_t r = 0; r < bodies; ++r) {
    now_.rigid_velocity_m_s[r] = velocities_[poses_.centre(r)];
    now_.angular_velocity_rad_s[r] = velocities_[poses_.spin(r)];
  }
  const std::span<Vector4> on_nodes = std::span(impulses_).first(nodes);
  springs_.add_forces(now_.node_position_m, now_.node_velocity_m_s, on_nodes);
  add_joint_forces(joints_, now_, on_nodes, wrenches_);
  for (std::size_t r = 0; r < bodies; ++r) {
    impulses_[poses_.centre(r)] = Vector4(wrenches_[r].force_N);
    impulses_[poses_.spin(r)] = Vector4(wrenches_[r].torque_N_m);
  }
  add_contact_impulses();
}

/// Adds the power of the dampers of springs and joints. Pre: sum_forces() was last.
void CvodeStep::sum_losses() {
  if (dampers_.springs.empty() && dampers_.joints.empty()) return;
  std::fill(damped_.begin(), damped_.end(), Vector4());
  std::fill(wrenches_.begin(), wrenches_.end(), Wrench());
  const std::span<Vector4> on_nodes = std::span(damped_).first(description_.nodes.size());
  damper_table_.add_forces(now_.node_position_m, now_.node_velocity_m_s, on_nodes);
  add_joint_forces(joint_dampers_, now_, on_nodes, wrenches_);
  for (std::size_t r = 0; r < wrenches_.size(); ++r)
    powers_.spring_damping_J -=
        wrenches_[r].force_N.dot(now_.rigid_velocity_m_s[r].vector()) +
        wrenches_[r].torque_N_m.dot(now_.angular_velocity_rad_s[r].vector());
  powers_.spring_damping_J -= dot(damped_, velocities_, awake_);
}

int CvodeStep::slope(double at_s, N_Vector y, N_Vector result) {
  if (stop_ != nullptr && *stop_) return kSunStop;
  if (!values_of(y).allFinite()) return kSunRetry;
  const Parts state = parts_of(y);
  place(at_s, state);
  sum_forces();
  sum_losses();
  Parts rates = parts_of(result);
  rates.moved = state.velocities;
  rates.stretches = rates_m_s_;
  rates.losses << powers_.spring_damping_J, powers_.contact_damping_J, powers_.friction_J;
  Eigen::Index column = 0;
  for (const std::size_t i : nodes_)
    rates.velocities.col(column++) =
        impulses_[i].vector() / description_.nodes[i].mass_kg + description_.gravity_m_s2;
  for (const std::size_t r : bodies_)
    rates.velocities.col(column++) =
        impulses_[poses_.centre(r)].vector() / description_.rigid_bodies[r].mass_kg +
        description_.gravity_m_s2;
  for (const std::size_t r : bodies_) {
    const Eigen::Vector3d& inertia = description_.rigid_bodies[r].inertia_kg_m2;
    const Eigen::Quaterniond orientation = now_.orientation[r].quaternion();
    const Eigen::Vector3d w = state.velocities.col(column);
    const Eigen::Vector3d momentum = turned_inertia(orientation, inertia) * w;
    rates.moved.col(column) = bodies::left_jacobian(state.moved.col(column)).inverse() * w;
    rates.velocities.col(column++) = inverse_inertia(orientation, inertia) *
                                     (impulses_[poses_.spin(r)].vector() - w.cross(momentum));
  }
  column = 0;
  for (const std::size_t r : driven_)
    for (const Motions* all : {&impulses_, &driven_impulses_})
      for (const std::size_t i : {poses_.centre(r), poses_.spin(r)})
        rates.reactions.col(column++) = (*all)[i].vector();
  return values_of(result).allFinite() ? kSunDone : kSunRetry;
}

/// Steps to the end of the tick, until it fails or something leaves its listed way or passes
/// through a body. Returns the steps taken.
long CvodeStep::integrate(void* memory, N_Vector y) {
  const auto spins = static_cast<Eigen::Index>(bodies_.size());
  reached_s_ = 0.0;
  for (long steps = 0;; ++steps) {
    if (steps == kMaxSteps || reached_s_ >= poses_.step_s()) return steps;
    if (CVode(memory, poses_.step_s(), y, &reached_s_, CV_ONE_STEP) < 0) return steps;
    const Parts state = parts_of(y);
    place(reached_s_, state);
    turns_far_ =
        spins > 0 && !(state.moved.rightCols(spins).colwise().norm().maxCoeff() < kMaxTurn_rad);
    if (passes() || !is_within(*listing_)) return steps + 1;
  }
}

void CvodeStep::solve(SolveFigures& figures, const std::atomic<bool>* stop) {
  stop_ = stop;
  losses_ = {};
  const SunVector y = begun_state(), absolute = tolerances();
  // The norm of errors is over all components; those that choose no step are to count for nothing.
  const double share =
      moving_.empty() ? 1.0 : std::sqrt(6.0 * double(moving_.size()) / double(size()));
  N_VScale(share, absolute.get(), absolute.get());
  const SunMemory<CVodeFree> memory(sun_checked(CVodeCreate(CV_BDF, context_.get())));
  const SunLinearSolver linear(
      sun_checked(SUNLinSol_SPGMR(y.get(), SUN_PREC_NONE, kKrylov, context_.get())));
  const auto slope_at = [](sunrealtype at_s, N_Vector state, N_Vector result, void* step) {
    return static_cast<CvodeStep*>(step)->slope(at_s, state, result);
  };
  int failures = CVodeSetUserData(memory.get(), this);
#if SUNDIALS_VERSION_MAJOR < 7
  failures |= CVodeSetErrHandlerFn(memory.get(), ignore_message, nullptr);
#endif
  failures |= CVodeInit(memory.get(), slope_at, 0.0, y.get());
  failures |= CVodeSVtolerances(memory.get(), share * tolerance_m_s_, absolute.get());
  failures |= CVodeSetLinearSolver(memory.get(), linear.get(), nullptr);
  failures |= CVodeSetStopTime(memory.get(), poses_.step_s());
  if (failures != 0) throw std::bad_alloc();

  figures.iterations += static_cast<int>(integrate(memory.get(), y.get()));
  long products = 0;
  CVodeGetNumLinIters(memory.get(), &products);
  figures.products += products;
  figures.converged = reached_s_ >= poses_.step_s();
  const bool is_finite = values_of(y.get()).allFinite();
  figures.residual_m_s = is_finite ? tolerance_m_s_ : std::numeric_limits<double>::quiet_NaN();
  const Parts state = parts_of(y.get());
  place(reached_s_, state);
  losses_.spring_damping_J = state.losses[0];
  losses_.contact_damping_J = state.losses[1];
  losses_.friction_J = state.losses[2];
  Eigen::Index column = 0;
  for (const std::size_t r : driven_)
    for (Motions* all : {&impulses_, &driven_impulses_})
      for (const std::size_t i : {poses_.centre(r), poses_.spin(r)})
        (*all)[i] = Vector4(Eigen::Vector3d(state.reactions.col(column++)));
}

}  // namespace

EngineMethod by_cvode(double tolerance_m_s) {
  const auto make = [](const Description& description, double tolerance) {
    return std::unique_ptr<CoupledStep>(std::make_unique<CvodeStep>(description, tolerance));
  };
  return {.make = make, .tolerance_m_s = tolerance_m_s};
}

}  // namespace stillgrid::dynamics
