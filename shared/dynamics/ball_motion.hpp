#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Free balls, the first of the rigid bodies in the order of movers.
struct BallList {
  std::vector<std::int32_t> rigid;  // index into SceneState
  std::vector<std::int32_t> place;  // index into ContactBodies::places
  std::vector<float> radius_m;
  std::vector<Vector4> base;  // of the centre where contacts were listed; w: how far it may move
  std::size_t first_mover = 0;
};

/// A substep of all balls in three passes. First: half a drift, then velocities and places as
/// contacts read them. Deterministic to the bit on every instruction set. Realtime: yes.
void start_balls(const BallList& balls, SceneState& state, ContactBodies& bodies, double substep_s,
                 double falls_m);
/// Second: velocities with the change that gravity makes, for contacts alone.
void kick_balls(const BallList& balls, const SceneState& state, ContactBodies& bodies,
                const Vector4& change_m_s);
/// Third: the state takes over what gravity and contacts changed, then half a drift.
void finish_balls(const BallList& balls, SceneState& state, const ContactBodies& bodies,
                  double substep_s, const Vector4& change_m_s);
/// Turns balls by the angular velocity that they have, for duration_s.
void turn_balls(const BallList& balls, SceneState& state, double duration_s);
/// Whether none leaves the way for which contacts were listed, within duration_s.
[[nodiscard]] bool stay_within(const BallList& balls, const SceneState& state, double duration_s,
                               double falls_m);

}  // namespace stillgrid::dynamics
