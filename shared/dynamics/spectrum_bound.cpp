#include "shared/dynamics/spectrum_bound.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stillgrid::dynamics {
namespace {

/// Of the longest stable substep. Near the limit a stiff vibration swings between several times its
/// energy, and gains where the shape changes.
constexpr double kStableShare = 0.5;
constexpr double kMaxSubsteps = 1e6;

struct Rates {
  double stiffness_per_s2 = 0.0, damping_per_s = 0.0;
};

/// 1 / mass of a joint's end along any direction, with what the body turns; 0 if it never moves.
double inverse_mass_per_kg(const Description& description, const Description::JointEnd& end) {
  if (end.node >= 0) {
    const Description::Node& node = description.nodes[static_cast<std::size_t>(end.node)];
    return node.is_pinned ? 0.0 : 1.0 / node.mass_kg;
  }
  if (end.rigid < 0) return 0.0;
  const Description::Rigid& body = description.rigid_bodies[static_cast<std::size_t>(end.rigid)];
  if (body.is_driven) return 0.0;
  return 1.0 / body.mass_kg + end.point_m.squaredNorm() / body.inertia_kg_m2.minCoeff();
}

}  // namespace

SpectrumBound spectrum_bound(const Description& description) {
  std::vector<Rates> nodes(description.nodes.size()), rigid(description.rigid_bodies.size());
  const auto add = [&](const Description::JointEnd& a, const Description::JointEnd& b,
                       double stiffness_N_per_m, double damping_N_s_per_m) {
    const double of_a = inverse_mass_per_kg(description, a);
    const double of_b = inverse_mass_per_kg(description, b);
    const auto add_to = [&](const Description::JointEnd& end, double own) {
      if (own == 0.0) return;
      Rates& rates = end.node >= 0 ? nodes[static_cast<std::size_t>(end.node)]
                                   : rigid[static_cast<std::size_t>(end.rigid)];
      rates.stiffness_per_s2 += (of_a + of_b) * stiffness_N_per_m;
      rates.damping_per_s += (of_a + of_b) * damping_N_s_per_m;
    };
    add_to(a, of_a);
    add_to(b, of_b);
  };
  for (const Description::Spring& spring : description.springs)
    add({.node = spring.a}, {.node = spring.b}, spring.stiffness_N_per_m, spring.damping_N_s_per_m);
  for (const Description::Joint& joint : description.joints)
    add(joint.a, joint.b, joint.stiffness_N_per_m, joint.damping_N_s_per_m);
  Rates most;
  for (const auto* all : {&nodes, &rigid})
    for (const Rates& rates : *all) {
      most.stiffness_per_s2 = std::max(most.stiffness_per_s2, rates.stiffness_per_s2);
      most.damping_per_s = std::max(most.damping_per_s, rates.damping_per_s);
    }
  return {std::sqrt(most.stiffness_per_s2), most.damping_per_s};
}

int stable_substeps(const SpectrumBound& bound, double tick_s) {
  const double w = bound.frequency_rad_s, d = bound.damping_per_s;
  const double asked = 0.25 * tick_s * (d + std::sqrt(d * d + 4.0 * w * w)) / kStableShare;
  // Written so that what is no number asks for one.
  return asked > 1.0 ? static_cast<int>(std::ceil(std::min(asked, kMaxSubsteps))) : 1;
}

}  // namespace stillgrid::dynamics
