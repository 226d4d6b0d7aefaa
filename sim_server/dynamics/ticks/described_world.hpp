#pragma once

#include <span>
#include <vector>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_model.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::dynamics {

/// A world as the engine of both processes takes it. Nodes and rigid bodies have the numbers that
/// they have in the world. Behind these follow one driven body that carries all static spheres and
/// fields, if there are any, and one for each hand.
struct DescribedWorld {
  Description description;
  SceneState state;
  std::vector<std::size_t> prescribed;  // rigid bodies of the world, in the order of driven bodies
  bool has_static_body = false;         // behind the prescribed ones
  std::size_t hands = 0;                // driven bodies behind these
  std::vector<int> sleeper_of_body;     // bodies of the world: index of Description::bodies, or -1
};

/// Describes a world with its hands, whose tools are away at the start. Shares its distance fields.
[[nodiscard]] DescribedWorld described(const bodies::World& world,
                                       std::span<const scene::Hand> hands, bool may_sleep);
/// Returns the model that two processes step. The caller sets its method.
[[nodiscard]] SceneModel model_of(DescribedWorld described, const bodies::World& world);
/// Returns the speed in m/s below which a free body of the world is at rest. It is 3 % of the
/// radius of its smallest sphere, or of its field's fine cell, a second. It is at most a fifth of
/// its material's slip speed. Zero is for bodies that never sleep.
[[nodiscard]] double rest_speed_m_s(const bodies::World& world, const bodies::BodyRange& body);

/// Describes nodes, springs, joints and rigid bodies without spheres, planes and tools.
[[nodiscard]] DescribedWorld described_without_spheres(const bodies::World& world);

}  // namespace stillgrid::dynamics
