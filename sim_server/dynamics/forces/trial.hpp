#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "proto/tool_segment.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"

namespace stillgrid::dynamics {

/// Where a mechanical system is placed.
struct Trial {
  std::vector<bodies::Node> nodes;              // as World::nodes
  std::vector<bodies::RigidBody> rigid_bodies;  // as World::rigid_bodies
  std::vector<bodies::SphereMotion> spheres;    // of World::spheres
  int touching = 0;                             // contacts that touch
};

/// Energy by hand.
using EnergyByHand_J = std::array<double, proto::kMaxHands>;

/// Energy that left or entered by other ways than gravity, springs and contact springs, J. Losses
/// are positive.
struct EnergyFlow {
  double spring_damping_J = 0.0;
  double contact_damping_J = 0.0;
  double friction_J = 0.0;
  double unsolved_J = 0.0;  // a gain: contacts' springs hold it, though no work paid for it, where
                            // iterations ended early
  double given_J = 0.0;  // work done on the world by what is moved from outside: tool, prescribed
  EnergyByHand_J tool_J{};  // of it by the tool of each
};

}  // namespace stillgrid::dynamics
