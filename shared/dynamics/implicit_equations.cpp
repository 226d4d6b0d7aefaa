// The equations of an implicit step and their derivative.
#include <Eigen/Cholesky>
#include <cmath>

#include "shared/dynamics/implicit_joints.hpp"
#include "shared/dynamics/implicit_step.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {

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

void ImplicitStep::collect_active() {
  active_.clear();
  const auto add = [&](const std::vector<Coupling>& couplings) {
    for (const Coupling& coupling : couplings)
      if (coupling.is_active) active_.push_back(&coupling);
  };
  add(joints_);
  add(contacts_.couplings());
}

void ImplicitStep::evaluate() {
  const double h = poses_.step_s();
  poses_.move(velocities_, awake_);
  each_awake(awake_, [&](std::size_t i) { impulses_[i] = driven_impulses_[i] = Vector4(); });
  springs_.add_impulses(poses_.to().node_position_m, h, impulses_);
  evaluate_joints(description_, poses_, velocities_, joints_);
  contacts_.evaluate(poses_, velocities_);
  collect_active();
  for (const Coupling& joint : joints_) {
    if (!joint.is_active) continue;
    add_impulse(joint.a, joint.impulse_N_s, poses_, impulses_);
    add_impulse(joint.b, -joint.impulse_N_s, poses_, impulses_);
  }
  add_contact_impulses();
  const Vector4 falls = h * Vector4(description_.gravity_m_s2);
  for (const std::size_t i : nodes_)
    residual_[i] = description_.nodes[i].mass_kg *
                       (velocities_[i] - poses_.from().node_velocity_m_s[i] - falls) -
                   impulses_[i];
  for (const std::size_t r : bodies_) evaluate_body(r);
  for (const Coupling* const active : active_) {
    const Coupling& coupling = *active;
    add_righting(coupling.a, coupling.impulse_N_s, h, spin_masses_);
    add_righting(coupling.b, -coupling.impulse_N_s, h, spin_masses_);
  }
}

void ImplicitStep::multiply(const Motions& p, Motions& out) const {
  each_awake(awake_, [&](std::size_t i) { out[i] = Vector4(); });
  for (const std::size_t i : nodes_) out[i] = description_.nodes[i].mass_kg * p[i];
  for (const std::size_t r : bodies_) {
    const std::size_t centre = poses_.centre(r), spin = poses_.spin(r);
    out[centre] = description_.rigid_bodies[r].mass_kg * p[centre];
    out[spin] = Vector4(spin_masses_[r] * p[spin].vector());
  }
  springs_.multiply(p, out);
  for (const Coupling* const active : active_) {
    const Coupling& coupling = *active;
    const Eigen::Vector3d push = coupling.slope_kg * relative_velocity(coupling, p, poses_);
    add_impulse(coupling.a, push, poses_, out);
    add_impulse(coupling.b, -push, poses_, out);
  }
}

void ImplicitStep::factorise() {
  const std::size_t nodes = inverses_.nodes.size(), bodies = inverses_.rigid.size();
  each_awake(awake_, [&](std::size_t i) {
    if (i < nodes)
      inverses_.nodes[i].setZero();
    else if (i < nodes + bodies)
      inverses_.rigid[i - nodes].setZero();
  });
  springs_.add_blocks(inverses_);
  for (const Coupling* const active : active_) {
    const Coupling& coupling = *active;
    add_block(coupling.a, coupling, inverses_);
    add_block(coupling.b, coupling, inverses_);
  }
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

}  // namespace stillgrid::dynamics
