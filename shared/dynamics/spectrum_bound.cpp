#include "shared/dynamics/spectrum_bound.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "shared/dynamics/at.hpp"

namespace stillgrid::dynamics {
namespace {

/// Of the longest stable substep. Near the limit a stiff vibration swings between several times its
/// energy, and gains where the shape changes.
constexpr double kStableShare = 0.5;
constexpr double kMaxSubsteps = 1e6;

double node_per_kg(const Description& description, int node) {
  const Description::Node& of = description.nodes[at(node)];
  return of.is_pinned ? 0.0 : 1.0 / of.mass_kg;
}

SpectrumBound largest(std::span<const SpectrumBound> sums) {
  SpectrumBound most;
  for (const SpectrumBound& sum : sums) {
    most.stiffness_per_s2 = std::max(most.stiffness_per_s2, sum.stiffness_per_s2);
    most.damping_per_s = std::max(most.damping_per_s, sum.damping_per_s);
  }
  return most;
}

struct EndPlace {
  Eigen::Vector3d position_m, velocity_m_s;
  double arm_m = 0.0;
};
EndPlace place_of(const Description::JointEnd& end, const SceneState& state) {
  if (end.node >= 0)
    return {state.node_position_m[at(end.node)].vector(),
            state.node_velocity_m_s[at(end.node)].vector()};
  if (end.rigid < 0) return {end.point_m, Eigen::Vector3d::Zero()};
  const std::size_t r = at(end.rigid);
  const Eigen::Vector3d arm_m = state.orientation[r].quaternion() * end.point_m;
  return {
      state.rigid_position_m[r].vector() + arm_m,
      state.rigid_velocity_m_s[r].vector() + state.angular_velocity_rad_s[r].vector().cross(arm_m),
      end.point_m.norm()};
}

/// 1 / mass that an end has for a spring or a damper. turning_m2: the square of what a turn of the
/// body by one radian stretches.
double inverse_mass_per_kg(const Description& description, const Description::JointEnd& end,
                           double turning_m2) {
  if (end.node >= 0) return node_per_kg(description, end.node);
  if (end.rigid < 0 || description.rigid_bodies[at(end.rigid)].is_driven) return 0.0;
  const Description::Rigid& body = description.rigid_bodies[at(end.rigid)];
  return 1.0 / body.mass_kg + turning_m2 / body.inertia_kg_m2.minCoeff();
}

}  // namespace

SpectrumBound spring_bound(const Description& description) {
  std::vector<SpectrumBound> sums(description.nodes.size());
  for (const Description::Spring& spring : description.springs) {
    const double per_kg = node_per_kg(description, spring.a) + node_per_kg(description, spring.b);
    for (const int node : {spring.a, spring.b})
      if (!description.nodes[at(node)].is_pinned)
        sums[at(node)] = sums[at(node)] + SpectrumBound{per_kg * spring.stiffness_N_per_m,
                                                        per_kg * spring.damping_N_s_per_m};
  }
  return largest(sums);
}

JointBound::JointBound(const Description& description)
    : sums_(description.joints.empty()
                ? 0
                : description.nodes.size() + description.rigid_bodies.size()) {}

SpectrumBound JointBound::operator()(const Description& description, const SceneState& state,
                                     double within_s) {
  std::ranges::fill(sums_, SpectrumBound{});
  for (const Description::Joint& joint : description.joints) {
    const EndPlace a = place_of(joint.a, state), b = place_of(joint.b, state);
    const double length_m =
        (a.position_m - b.position_m).norm() + within_s * (a.velocity_m_s - b.velocity_m_s).norm();
    // A stretched spring turns its bodies back into its line. Its damper acts on b at the place of
    // a.
    const auto per_kg = [&](double more_m2_of_a, double more_m2_of_b) {
      return std::array{
          inverse_mass_per_kg(description, joint.a, a.arm_m * a.arm_m + more_m2_of_a),
          inverse_mass_per_kg(description, joint.b, b.arm_m * b.arm_m + more_m2_of_b)};
    };
    const auto of_spring = per_kg(a.arm_m * length_m, b.arm_m * length_m);
    const auto of_damper = per_kg(0.0, (2.0 * b.arm_m + length_m) * length_m);
    const SpectrumBound sum{(of_spring[0] + of_spring[1]) * joint.stiffness_N_per_m,
                            (of_damper[0] + of_damper[1]) * joint.damping_N_s_per_m};
    const auto add_to = [&](const Description::JointEnd& end, double own_per_kg) {
      if (own_per_kg == 0.0) return;
      SpectrumBound& of =
          sums_[end.node >= 0 ? at(end.node) : description.nodes.size() + at(end.rigid)];
      of = of + sum;
    };
    add_to(joint.a, of_spring[0]);
    add_to(joint.b, of_spring[1]);
  }
  return largest(sums_);
}

int stable_substeps(const SpectrumBound& bound, double tick_s) {
  const double k = bound.stiffness_per_s2, c = bound.damping_per_s;
  const double asked = 0.25 * tick_s * (c + std::sqrt(c * c + 4.0 * k)) / kStableShare;
  // Written so that what is no number asks for one.
  return asked > 1.0 ? static_cast<int>(std::ceil(std::min(asked, kMaxSubsteps))) : 1;
}

}  // namespace stillgrid::dynamics
