#include "shared/dynamics/implicit_step.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "shared/dynamics/implicit_joints.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr int kIterations = 24, kProducts = 400, kTrials = 8, kFrictionIterations = 6;
constexpr double kLinearShare = 1e-3;  // to which each linear system is solved
constexpr double kSlopeLeft = 0.25;    // of a search along a line, beyond its end

Eigen::Matrix3d turned_inertia(const Eigen::Quaterniond& orientation,
                               const Eigen::Vector3d& inertia_kg_m2) {
  const Eigen::Matrix3d axes = orientation.toRotationMatrix();
  return axes * inertia_kg_m2.asDiagonal() * axes.transpose();
}

/// Distances of the farthest points of rigid bodies, or radii of gyration where they have none.
std::vector<double> reaches_m(const Description& description) {
  std::vector<double> reaches;
  for (const Description::Rigid& body : description.rigid_bodies)
    reaches.push_back(body.is_driven ? 0.0
                                     : std::sqrt(body.inertia_kg_m2.maxCoeff() / body.mass_kg));
  for (const Description::Sphere& sphere : description.spheres) {
    if (sphere.rigid < 0) continue;
    double& reach = reaches[static_cast<std::size_t>(sphere.rigid)];
    reach = std::max(reach, sphere.local_m.norm() + sphere.radius_m);
  }
  return reaches;
}

}  // namespace

ImplicitStep::ImplicitStep(const Description& description, double tolerance_m_s)
    : description_(description),
      tolerance_m_s_(tolerance_m_s),
      poses_(description),
      springs_(description),
      joints_(joint_couplings(description)),
      contacts_(description),
      gradients_(description.nodes.size() + 2 * description.rigid_bodies.size()) {
  const std::size_t count = description.nodes.size() + 2 * description.rigid_bodies.size();
  for (Motions* all : {&velocities_, &base_, &residual_, &wanted_, &change_, &impulses_})
    all->resize(count);
  inverses_.nodes.resize(description.nodes.size());
  inverses_.rigid.resize(description.rigid_bodies.size());
  spin_masses_.resize(description.rigid_bodies.size());
  momenta_.resize(description.rigid_bodies.size());
  reaches_m_ = reaches_m(description);
  for (std::size_t i = 0; i < description.nodes.size(); ++i)
    if (!description.nodes[i].is_pinned) nodes_.push_back(i);
  for (std::size_t r = 0; r < description.rigid_bodies.size(); ++r)
    if (!description.rigid_bodies[r].is_driven) bodies_.push_back(r);
}

void ImplicitStep::leave_out(std::span<const std::uint8_t> sleeping_nodes,
                             std::span<const std::uint8_t> sleeping_rigid_bodies) {
  nodes_.clear();
  bodies_.clear();
  for (std::size_t i = 0; i < sleeping_nodes.size(); ++i)
    if (!description_.nodes[i].is_pinned && sleeping_nodes[i] == 0) nodes_.push_back(i);
  for (std::size_t r = 0; r < sleeping_rigid_bodies.size(); ++r)
    if (!description_.rigid_bodies[r].is_driven && sleeping_rigid_bodies[r] == 0)
      bodies_.push_back(r);
  for (Motions* all : {&residual_, &wanted_, &change_})
    std::fill(all->begin(), all->end(), Vector4());
}

void ImplicitStep::start(const SceneState& state, double step_s) {
  poses_.start(state, step_s);
  std::fill(velocities_.begin(), velocities_.end(), Vector4());
  for (const std::size_t i : nodes_) velocities_[i] = state.node_velocity_m_s[i];
  for (std::size_t r = 0; r < momenta_.size(); ++r) {
    velocities_[poses_.centre(r)] = state.rigid_velocity_m_s[r];
    velocities_[poses_.spin(r)] = state.angular_velocity_rad_s[r];
  }
  for (const std::size_t r : bodies_) {
    const Eigen::Quaterniond orientation = state.orientation[r].quaternion();
    const Eigen::Vector3d& inertia = description_.rigid_bodies[r].inertia_kg_m2;
    Eigen::Vector3d spin = state.angular_velocity_rad_s[r].vector();
    momenta_[r] = Vector4(turned_inertia(orientation, inertia) * spin);
    Eigen::Quaterniond end = orientation;
    turn_freely(end, spin, inertia, step_s);
    velocities_[poses_.spin(r)] = Vector4(spin);
  }
  springs_.start(state.node_position_m);
  poses_.move(velocities_);
}

void ImplicitStep::restart(const ContactListing& listing) {
  contacts_.start(poses_, listing);
  evaluate();
  contacts_.limit_friction();
  evaluate();
}

void ImplicitStep::evaluate_body(std::size_t r) {
  const Description::Rigid& body = description_.rigid_bodies[r];
  const SceneState& from = poses_.from();
  const std::size_t centre = poses_.centre(r), spin = poses_.spin(r);
  const Vector4 falls = poses_.step_s() * Vector4(description_.gravity_m_s2);
  residual_[centre] =
      body.mass_kg * (velocities_[centre] - from.rigid_velocity_m_s[r] - falls) - impulses_[centre];
  const Eigen::Matrix3d inertia =
      turned_inertia(poses_.to().orientation[r].quaternion(), body.inertia_kg_m2);
  residual_[spin] = Vector4(inertia * velocities_[spin].vector()) - momenta_[r] - impulses_[spin];
  spin_masses_[r] = inertia;
}

/// Calls visit(coupling) for all that push or hold.
template <class Visit>
void ImplicitStep::each_coupling(const Visit& visit) const {
  for (const Coupling& joint : joints_) visit(joint);
  for (const Coupling& contact : contacts_.couplings())
    if (contact.is_active) visit(contact);
}

/// Computes impulses, the residual and all slopes at the trial velocities.
void ImplicitStep::evaluate() {
  const double h = poses_.step_s();
  poses_.move(velocities_);
  std::fill(impulses_.begin(), impulses_.end(), Vector4());
  springs_.add_impulses(poses_.to().node_position_m, h, impulses_);
  evaluate_joints(description_, poses_, velocities_, joints_);
  contacts_.evaluate(poses_, velocities_);
  each_coupling([&](const Coupling& coupling) {
    add_impulse(coupling.a, coupling.impulse_N_s, poses_, impulses_);
    add_impulse(coupling.b, -coupling.impulse_N_s, poses_, impulses_);
  });
  const Vector4 falls = h * Vector4(description_.gravity_m_s2);
  for (const std::size_t i : nodes_)
    residual_[i] = description_.nodes[i].mass_kg *
                       (velocities_[i] - poses_.from().node_velocity_m_s[i] - falls) -
                   impulses_[i];
  for (const std::size_t r : bodies_) evaluate_body(r);
  each_coupling([&](const Coupling& coupling) {
    add_righting(coupling.a, coupling.impulse_N_s, h, spin_masses_);
    add_righting(coupling.b, -coupling.impulse_N_s, h, spin_masses_);
  });
}

void ImplicitStep::multiply(const Motions& p, Motions& out) const {
  std::fill(out.begin(), out.end(), Vector4());
  for (const std::size_t i : nodes_) out[i] = description_.nodes[i].mass_kg * p[i];
  for (const std::size_t r : bodies_) {
    const std::size_t centre = poses_.centre(r), spin = poses_.spin(r);
    out[centre] = description_.rigid_bodies[r].mass_kg * p[centre];
    out[spin] = Vector4(spin_masses_[r] * p[spin].vector());
  }
  springs_.multiply(p, out);
  each_coupling([&](const Coupling& coupling) {
    const Eigen::Vector3d push = coupling.slope_kg * relative_velocity(coupling, p, poses_);
    add_impulse(coupling.a, push, poses_, out);
    add_impulse(coupling.b, -push, poses_, out);
  });
}

void ImplicitStep::factorise() {
  for (auto& block : inverses_.nodes) block.setZero();
  for (auto& block : inverses_.rigid) block.setZero();
  springs_.add_blocks(inverses_);
  each_coupling([&](const Coupling& coupling) {
    add_block(coupling.a, coupling, inverses_);
    add_block(coupling.b, coupling, inverses_);
  });
  for (const std::size_t i : nodes_) {
    Eigen::Matrix3d& block = inverses_.nodes[i];
    block.diagonal().array() += description_.nodes[i].mass_kg;
    block = block.inverse().eval();
  }
  for (const std::size_t r : bodies_) {
    MassBlocks::Block6& block = inverses_.rigid[r];
    block.diagonal().head<3>().array() += description_.rigid_bodies[r].mass_kg;
    block.bottomRightCorner<3, 3>() += spin_masses_[r];
    block = block.llt().solve(MassBlocks::Block6::Identity()).eval();
  }
}

/// Leaves zero where nothing moves by forces.
void ImplicitStep::precondition(const Motions& r, Motions& out) const {
  for (const std::size_t i : nodes_) out[i] = Vector4(inverses_.nodes[i] * r[i].vector());
  for (const std::size_t body : bodies_) {
    Eigen::Matrix<double, 6, 1> both;
    both << r[poses_.centre(body)].vector(), r[poses_.spin(body)].vector();
    both = (inverses_.rigid[body] * both).eval();
    out[poses_.centre(body)] = Vector4(Eigen::Vector3d(both.head<3>()));
    out[poses_.spin(body)] = Vector4(Eigen::Vector3d(both.tail<3>()));
  }
}

/// Of a rotation: the speed at the body's farthest point.
double ImplicitStep::residual_m_s() const {
  double sum = 0.0;
  for (const std::size_t i : nodes_)
    sum += residual_[i].vector().squaredNorm() /
           (description_.nodes[i].mass_kg * description_.nodes[i].mass_kg);
  for (const std::size_t r : bodies_) {
    const Description::Rigid& body = description_.rigid_bodies[r];
    const Eigen::Vector3d across =
        poses_.to().orientation[r].quaternion().conjugate() * residual_[poses_.spin(r)].vector();
    sum += residual_[poses_.centre(r)].vector().squaredNorm() / (body.mass_kg * body.mass_kg) +
           (reaches_m_[r] * across.cwiseQuotient(body.inertia_kg_m2)).squaredNorm();
  }
  const std::size_t count = nodes_.size() + 2 * bodies_.size();
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(3 * count));
}

/// Shortens the change until the residual along it has not turned round by much: the equations are
/// nearly the derivative of a convex function along the line.
double ImplicitStep::search_line() {
  base_ = velocities_;
  const double before = -dot(residual_, change_);
  double length = 1.0;
  for (int trial = 0;; ++trial) {
    for (std::size_t i = 0; i < base_.size(); ++i) velocities_[i] = base_[i] + length * change_[i];
    evaluate();
    const double after = dot(residual_, change_);
    if (trial == kTrials || after <= kSlopeLeft * before) return length;
    length *= std::max(0.1, before / (before + after));
  }
}

void ImplicitStep::solve(SolveFigures& figures) {
  double residual = residual_m_s();
  for (int k = 0; k < kIterations && residual > tolerance_m_s_; ++k) {
    factorise();
    for (std::size_t i = 0; i < residual_.size(); ++i) wanted_[i] = -1.0 * residual_[i];
    figures.products += gradients_.solve(
        wanted_, kLinearShare, 0.0, kProducts,
        [&](const Motions& p, Motions& out) { multiply(p, out); },
        [&](const Motions& r, Motions& out) { precondition(r, out); }, change_);
    contacts_.aim_friction(poses_, change_);
    contacts_.turn_aims(search_line());
    if (k < kFrictionIterations) contacts_.limit_friction();
    evaluate();
    residual = residual_m_s();
    ++figures.iterations;
  }
  figures.converged = residual <= tolerance_m_s_;
  figures.residual_m_s = residual;
}

void ImplicitStep::write_velocities(SceneState& state) const {
  for (const std::size_t i : nodes_) state.node_velocity_m_s[i] = velocities_[i];
  for (const std::size_t r : bodies_) {
    state.rigid_velocity_m_s[r] = velocities_[poses_.centre(r)];
    state.angular_velocity_rad_s[r] = velocities_[poses_.spin(r)];
  }
}

void ImplicitStep::finish(SceneState& state, RowList& rows) const {
  write_velocities(state);
  state.node_position_m = poses_.to().node_position_m;
  state.rigid_position_m = poses_.to().rigid_position_m;
  for (std::size_t r = 0; r < state.orientation.size(); ++r)
    if (!velocities_[poses_.spin(r)].vector().isZero(0.0))  // else rounding would turn it
      state.orientation[r] = poses_.to().orientation[r];
  contacts_.write(rows);
}

EnergyLosses ImplicitStep::losses() const {
  EnergyLosses losses;
  losses.spring_damping_J = springs_.damping_J(poses_.to().node_position_m, poses_.step_s()) +
                            joint_damping_J(description_, poses_, velocities_, joints_);
  contacts_.add_losses(poses_, velocities_, losses);
  return losses;
}

}  // namespace stillgrid::dynamics
