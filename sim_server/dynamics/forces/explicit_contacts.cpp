#include "sim_server/dynamics/forces/explicit_contacts.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::dynamics {
namespace {

using Eigen::Vector3d;

/// Of a contact's own oscillation in a substep: the energy that symplectic Euler may give a bounce
/// without damper then stays below 2.5 %.
constexpr double kUndampedPhase_rad = 0.5;
/// Of the smaller radius, that two spheres come nearer in a substep: none passes another unseen.
constexpr double kMaxApproach = 0.5;

std::size_t index_of(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

void ExplicitContacts::take(const bodies::World& world, std::span<const contact::Contact> contacts,
                            const ExplicitState& state) {
  for (const Sphere& sphere : spheres_) place_of_[index_of(sphere.number)] = -1;
  place_of_.resize(world.spheres.size(), -1);
  spheres_.clear();
  pairs_.clear();
  struck_ = false;
  const auto enter = [&](int sphere) {
    int& place = place_of_[index_of(sphere)];
    if (place >= 0) return place;
    place = static_cast<int>(spheres_.size());
    Sphere& entered = spheres_.emplace_back();
    entered.number = sphere;
    entered.binding = &world.spheres[index_of(sphere)];
    for (std::size_t i = 0; i < index_of(entered.binding->node_count); ++i) {
      const double weight = entered.binding->weights[i];
      entered.inverse_mass_per_kg +=
          weight * weight * state.inverse_mass_per_kg[index_of(entered.binding->nodes[i])];
    }
    return place;
  };
  for (const contact::Contact& contact : contacts)
    pairs_.push_back({enter(contact.a), contact.b < 0 ? -1 : enter(contact.b),
                      contact.radius_a_m + contact.radius_b_m, &contact});
}

void ExplicitContacts::place(const ExplicitState& state) {
  for (Sphere& sphere : spheres_) {
    const bodies::SphereBinding& binding = *sphere.binding;
    if (binding.rigid >= 0) {
      const RigidState& body = state.rigid[index_of(binding.rigid)];
      sphere.arm_m = body.rotation * binding.local_m;
      sphere.position_m = body.position_m + sphere.arm_m;
      continue;
    }
    sphere.position_m.setZero();
    for (std::size_t i = 0; i < index_of(binding.node_count); ++i)
      sphere.position_m += binding.weights[i] * state.position_m[index_of(binding.nodes[i])].map();
  }
}

std::optional<ExplicitContacts::Touch> ExplicitContacts::touch_of(const Pair& pair,
                                                                  double share) const {
  const contact::Contact& contact = *pair.contact;
  const Vector3d& position_m = spheres_[index_of(pair.a)].position_m;
  if (contact.is_plane) {
    const double height_m = contact.plane_normal.dot(position_m) - contact.plane_offset_m;
    if (!(height_m < contact.radius_a_m)) return std::nullopt;
    return Touch{&pair, contact.plane_normal, contact.radius_a_m * contact.plane_normal,
                 contact.radius_a_m - height_m};
  }
  const Vector3d other_m = pair.b >= 0 ? spheres_[index_of(pair.b)].position_m
                                       : contact::kinematic_position_m(contact, share);
  const Vector3d line_m = position_m - other_m;
  const double squared_m2 = line_m.squaredNorm();
  if (!(squared_m2 < pair.contact_distance_m * pair.contact_distance_m)) return std::nullopt;
  const double distance_m = std::sqrt(squared_m2);
  // Concentric spheres push along any one direction: up.
  if (distance_m < 1e-12) return Touch{&pair, Vector3d::UnitZ(), line_m, pair.contact_distance_m};
  return Touch{&pair, line_m / distance_m, line_m, pair.contact_distance_m - distance_m};
}

void ExplicitContacts::push(double share, ExplicitState& state) {
  place(state);
  touches_.clear();
  for (const Pair& pair : pairs_) {
    const std::optional<Touch> touch = touch_of(pair, share);
    if (!touch) continue;
    struck_ = true;
    touches_.push_back(*touch);
    const Vector3d force_N =
        pair.contact->material.stiffness_N_per_m * touch->depth_m * touch->normal;
    press(spheres_[index_of(pair.a)], force_N, state);
    if (pair.b >= 0) press(spheres_[index_of(pair.b)], -force_N, state);
  }
}

int ExplicitContacts::count_touching(const ExplicitState& state) {
  place(state);
  return static_cast<int>(std::count_if(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
    return touch_of(pair, 1.0).has_value();
  }));
}

void ExplicitContacts::press(const Sphere& sphere, const Vector3d& force_N, ExplicitState& state) {
  const bodies::SphereBinding& binding = *sphere.binding;
  if (binding.rigid >= 0) {
    RigidState& body = state.rigid[index_of(binding.rigid)];
    body.force_N += force_N;
    body.torque_N_m += sphere.arm_m.cross(force_N);
    return;
  }
  for (std::size_t i = 0; i < index_of(binding.node_count); ++i)
    state.force_N[index_of(binding.nodes[i])].map() += binding.weights[i] * force_N;
}

/// One side of a touch while velocities change: a sphere on nodes or on a rigid body, or what
/// stands in the contact.
class ExplicitContacts::Side {
 public:
  Side(const Sphere* sphere, const contact::Contact& contact, const Vector3d& to_point_m,
       double drift_s, ExplicitState& state)
      : sphere_(sphere),
        contact_(contact),
        to_point_m_(to_point_m),
        drift_s_(drift_s),
        state_(state) {
    if (sphere_ != nullptr && sphere_->binding->rigid >= 0)
      rigid_ = &state_.rigid[index_of(sphere_->binding->rigid)];
  }

  /// Of the centre.
  [[nodiscard]] Vector3d velocity() const {
    return sphere_ == nullptr ? contact_.velocity_b_m_s : velocity_m_s(*sphere_, state_);
  }
  /// Of the point of contact; soft bodies do not turn.
  [[nodiscard]] Vector3d point_velocity() const {
    if (sphere_ == nullptr)
      return contact_.velocity_b_m_s + contact_.spin_b_rad_s.cross(to_point_m_);
    if (rigid_ == nullptr) return velocity();
    return rigid_->velocity_m_s + rigid_->spin_rad_s.cross(sphere_->arm_m + to_point_m_);
  }
  /// 1 / mass that a push along unit vector u feels, at the centre or at the point of contact.
  [[nodiscard]] double inverse_mass_per_kg(const Vector3d& u, bool at_point) const {
    if (sphere_ == nullptr) return 0.0;
    if (rigid_ == nullptr) return sphere_->inverse_mass_per_kg;
    const Vector3d turn_m = arm_m(at_point).cross(u);
    return rigid_->inverse_mass_per_kg + turn_m.dot(rigid_->inverse_inertia_per_kg_m2 * turn_m);
  }
  void apply_impulse(const Vector3d& impulse_N_s, bool at_point) {
    if (sphere_ == nullptr) return;
    if (rigid_ != nullptr) {
      if (!rigid_->free) return;
      const Vector3d angular_impulse_N_m_s = arm_m(at_point).cross(impulse_N_s);
      rigid_->velocity_m_s += rigid_->inverse_mass_per_kg * impulse_N_s;
      rigid_->angular_momentum_N_m_s += angular_impulse_N_m_s;
      rigid_->spin_rad_s += rigid_->inverse_inertia_per_kg_m2 * angular_impulse_N_m_s;
      return;
    }
    const bodies::SphereBinding& binding = *sphere_->binding;
    for (std::size_t i = 0; i < index_of(binding.node_count); ++i) {
      const std::size_t node = index_of(binding.nodes[i]);
      const Vector3d change_m_s =
          binding.weights[i] * state_.inverse_mass_per_kg[node] * impulse_N_s;
      state_.velocity_m_s[node].map() += change_m_s;
      state_.position_m[node].map() += drift_s_ * change_m_s;
    }
  }
  /// Moved from outside, so that what pushes it is worked against.
  [[nodiscard]] bool is_kinematic() const {
    return sphere_ == nullptr || (rigid_ != nullptr && !rigid_->free);
  }

 private:
  [[nodiscard]] Vector3d arm_m(bool at_point) const {
    return at_point ? Vector3d(sphere_->arm_m + to_point_m_) : sphere_->arm_m;
  }

  const Sphere* sphere_;
  const contact::Contact& contact_;
  Vector3d to_point_m_;  // from the centre to the point of contact
  double drift_s_;
  ExplicitState& state_;
  RigidState* rigid_ = nullptr;
};

/// Both sides of a touch while an impulse after another changes their velocities.
struct ExplicitContacts::Meeting {
  Side a, b;
  const collision::ContactMaterial& material;
  const Vector3d& normal;  // towards a
  double duration_s;
  EnergyFlow& flow;

  /// An impulse on a, against it on b.
  void oppose(double impulse_N_s, const Vector3d& along, bool at_point) {
    a.apply_impulse(impulse_N_s * along, at_point);
    b.apply_impulse(-impulse_N_s * along, at_point);
    const auto speed = [&](const Side& side) {
      return along.dot(at_point ? side.point_velocity() : side.velocity());
    };
    if (b.is_kinematic()) flow.given_J += impulse_N_s * speed(b);
    if (a.is_kinematic()) flow.given_J -= impulse_N_s * speed(a);
  }

  /// The approach damper; returns its force, N.
  double damp() {
    if (!(material.damping_N_s_per_m > 0.0)) return 0.0;
    const double approach_m_s = -normal.dot(a.velocity() - b.velocity());
    if (!(approach_m_s > 0.0)) return 0.0;
    const double inverse_mass_per_kg =
        a.inverse_mass_per_kg(normal, false) + b.inverse_mass_per_kg(normal, false);
    const double after_m_s =
        approach_m_s / (1.0 + duration_s * material.damping_N_s_per_m * inverse_mass_per_kg);
    const double force_N = material.damping_N_s_per_m * after_m_s;
    flow.contact_damping_J += 0.5 * duration_s * force_N * (approach_m_s + after_m_s);
    oppose(duration_s * force_N, normal, false);
    return force_N;
  }

  void apply_friction(double normal_load_N) {
    if (!(material.friction > 0.0)) return;
    Vector3d slip_m_s = a.point_velocity() - b.point_velocity();
    slip_m_s -= normal.dot(slip_m_s) * normal;
    const double speed_m_s = slip_m_s.norm();
    if (!(speed_m_s > 0.0)) return;
    const Vector3d back = -slip_m_s / speed_m_s;
    const double slowing_m_s =
        duration_s * material.friction * normal_load_N *
        (a.inverse_mass_per_kg(back, true) + b.inverse_mass_per_kg(back, true));
    // Sliding still at its end, or creeping.
    const double creep_m_s = material.slip_speed_m_s;
    const double after_m_s = speed_m_s - slowing_m_s >= creep_m_s
                                 ? speed_m_s - slowing_m_s
                                 : speed_m_s * creep_m_s / (creep_m_s + slowing_m_s);
    const double force_N = material.friction * normal_load_N * std::min(1.0, after_m_s / creep_m_s);
    flow.friction_J += 0.5 * duration_s * force_N * (speed_m_s + after_m_s);
    oppose(duration_s * force_N, back, true);
  }
};

void ExplicitContacts::resist(double duration_s, double step_s, double drift_s,
                              ExplicitState& state, EnergyFlow& flow) const {
  for (const Touch& touch : touches_) {
    const contact::Contact& contact = *touch.pair->contact;
    const contact::ContactShares shares = contact::contact_shares(contact);
    const Vector3d& n = touch.normal;
    const Sphere* other = touch.pair->b < 0 ? nullptr : &spheres_[index_of(touch.pair->b)];
    Meeting meeting{
        Side(&spheres_[index_of(touch.pair->a)], contact, -shares.a * touch.line_m, drift_s, state),
        Side(other, contact, shares.b * touch.line_m, drift_s, state),
        contact.material,
        n,
        duration_s,
        flow};
    const double push_N = contact.material.stiffness_N_per_m * touch.depth_m;
    // The spring's work on what is led is by its path, the others' by its velocity.
    if (other == nullptr)
      flow.given_J +=
          duration_s / step_s * push_N * n.dot(contact.position_b_m - contact.start_b_m);
    else if (meeting.b.is_kinematic())
      flow.given_J += duration_s * push_N * n.dot(meeting.b.velocity());
    if (meeting.a.is_kinematic()) flow.given_J -= duration_s * push_N * n.dot(meeting.a.velocity());
    meeting.apply_friction(push_N + meeting.damp());
  }
}

Vector3d ExplicitContacts::velocity_m_s(const Sphere& sphere, const ExplicitState& state) {
  const bodies::SphereBinding& binding = *sphere.binding;
  if (binding.rigid >= 0) {
    const RigidState& body = state.rigid[index_of(binding.rigid)];
    return body.velocity_m_s + body.spin_rad_s.cross(sphere.arm_m);
  }
  Vector3d velocity_m_s = Vector3d::Zero();
  for (std::size_t i = 0; i < index_of(binding.node_count); ++i)
    velocity_m_s += binding.weights[i] * state.velocity_m_s[index_of(binding.nodes[i])].map();
  return velocity_m_s;
}

/// Of a pair of spheres, in their smaller radius a second; below a plane all is solid.
double ExplicitContacts::approach_per_s(const Pair& pair, const ExplicitState& state,
                                        double step_s) const {
  const contact::Contact& contact = *pair.contact;
  if (contact.is_plane) return 0.0;
  const Vector3d other_m_s = pair.b >= 0
                                 ? velocity_m_s(spheres_[index_of(pair.b)], state)
                                 : Vector3d((contact.position_b_m - contact.start_b_m) / step_s);
  const Vector3d apart_m_s = velocity_m_s(spheres_[index_of(pair.a)], state) - other_m_s;
  return apart_m_s.norm() / std::min(contact.radius_a_m, contact.radius_b_m);
}

ExplicitContacts::Rates ExplicitContacts::rates(const ExplicitState& state, double step_s) {
  node_load_.assign(state.position_m.size(), 0.0);
  rigid_load_.assign(state.rigid.size(), {});
  place(state);
  const auto load = [&](const Sphere& sphere, double stiffness_N_per_m) {
    const bodies::SphereBinding& binding = *sphere.binding;
    if (binding.rigid >= 0) {
      RigidLoad& on = rigid_load_[index_of(binding.rigid)];
      on.pushing_N_per_m += stiffness_N_per_m;
      on.turning_N += stiffness_N_per_m * sphere.arm_m.norm();
      return;
    }
    for (std::size_t i = 0; i < index_of(binding.node_count); ++i)
      node_load_[index_of(binding.nodes[i])] += stiffness_N_per_m * binding.weights[i];
  };
  for (const Pair& pair : pairs_) {
    load(spheres_[index_of(pair.a)], pair.contact->material.stiffness_N_per_m);
    if (pair.b >= 0) load(spheres_[index_of(pair.b)], pair.contact->material.stiffness_N_per_m);
  }
  const auto row = [&](const Sphere& sphere) {
    const bodies::SphereBinding& binding = *sphere.binding;
    if (binding.rigid >= 0) {
      const RigidState& body = state.rigid[index_of(binding.rigid)];
      const RigidLoad& on = rigid_load_[index_of(binding.rigid)];
      return body.inverse_mass_per_kg * on.pushing_N_per_m +
             body.inverse_principal_inertia_per_kg_m2.maxCoeff() * sphere.arm_m.norm() *
                 on.turning_N;
    }
    double sum_per_s2 = 0.0;
    for (std::size_t i = 0; i < index_of(binding.node_count); ++i) {
      const std::size_t node = index_of(binding.nodes[i]);
      sum_per_s2 += binding.weights[i] * state.inverse_mass_per_kg[node] * node_load_[node];
    }
    return sum_per_s2;
  };
  Rates most;
  for (const Pair& pair : pairs_) {
    const double per_s2 =
        row(spheres_[index_of(pair.a)]) + (pair.b < 0 ? 0.0 : row(spheres_[index_of(pair.b)]));
    const collision::ContactMaterial& material = pair.contact->material;
    const double rate_rad_s = std::sqrt(per_s2);
    // A damper of damping ratio zeta takes 1.5 zeta of a bounce, of which the step may give back
    // 0.11 phase^2; stability ends at 2.
    const double damping_ratio =
        material.stiffness_N_per_m > 0.0
            ? 0.5 * rate_rad_s * material.damping_N_s_per_m / material.stiffness_N_per_m
            : 0.0;
    const double phase_rad = std::min(2.0, kUndampedPhase_rad + 4.0 * damping_ratio);
    most.stiffness_per_s2 = std::max(most.stiffness_per_s2, per_s2);
    most.substeps_per_s = std::max({most.substeps_per_s, rate_rad_s / phase_rad,
                                    approach_per_s(pair, state, step_s) / kMaxApproach});
  }
  return most;
}

}  // namespace stillgrid::dynamics
