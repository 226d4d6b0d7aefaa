#pragma once

#include <array>

#include "proto/tool_segment.hpp"

namespace stillgrid::dynamics {

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
  double given_J = 0.0;     // gift of tools and prescribed bodies to the world
  double proxies_J = 0.0;   // part of given_J that no work paid for: as proxies of tools moved
  EnergyByHand_J tool_J{};  // each tool's part of given_J
};

}  // namespace stillgrid::dynamics
