#include "shared/dynamics/spectrum_bound.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stillgrid::dynamics {

SpectrumBound spectrum_bound(const Description& description) {
  struct Sums {
    double stiffness = 0.0, damping = 0.0;  // over the mass that each acts on: 1/s^2, 1/s
  };
  std::vector<Sums> nodes(description.nodes.size()), rigid(description.rigid_bodies.size());
  const auto add = [](Sums& sums, double inverse_mass, double stiffness, double damping) {
    sums.stiffness += 2.0 * inverse_mass * stiffness;
    sums.damping += 2.0 * inverse_mass * damping;
  };
  const auto add_node = [&](int node, double stiffness, double damping) {
    const auto i = static_cast<std::size_t>(node);
    if (!description.nodes[i].is_pinned)
      add(nodes[i], 1.0 / description.nodes[i].mass_kg, stiffness, damping);
  };
  for (const Description::Spring& spring : description.springs)
    for (const int node : {spring.a, spring.b})
      add_node(node, spring.stiffness_N_per_m, spring.damping_N_s_per_m);
  for (const Description::Joint& joint : description.joints)
    for (const Description::JointEnd& end : {joint.a, joint.b}) {
      if (end.node >= 0) add_node(end.node, joint.stiffness_N_per_m, joint.damping_N_s_per_m);
      if (end.node >= 0 || end.rigid < 0) continue;
      const auto r = static_cast<std::size_t>(end.rigid);
      const Description::Rigid& body = description.rigid_bodies[r];
      if (body.is_driven) continue;
      const double inverse_mass =
          1.0 / body.mass_kg + end.point_m.squaredNorm() / body.inertia_kg_m2.minCoeff();
      add(rigid[r], inverse_mass, joint.stiffness_N_per_m, joint.damping_N_s_per_m);
    }
  Sums most;
  for (const auto* all : {&nodes, &rigid})
    for (const Sums& sums : *all) {
      most.stiffness = std::max(most.stiffness, sums.stiffness);
      most.damping = std::max(most.damping, sums.damping);
    }
  return {std::sqrt(most.stiffness), most.damping};
}

}  // namespace stillgrid::dynamics
