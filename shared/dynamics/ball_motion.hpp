#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/work_sharing.hpp"

namespace stillgrid::dynamics {

/// Free balls, the first of the rigid bodies in the order of movers.
struct BallList {
  std::vector<std::int32_t> rigid;  // index into SceneState
  std::vector<std::int32_t> place;  // index into ContactBodies::places
  std::vector<float> radius_m;
  std::vector<Vector4> base;  // centre at the last listing; w: longest way until the next
  std::size_t first_mover = 0;
  const WorkSharing* sharing = &WorkSharing::alone();
};

/// A substep of all balls in three passes. First: half a drift, then velocities and places as
/// contacts read them. Deterministic to the bit on every instruction set. Realtime: yes.
void start_balls(const BallList& balls, SceneState& state, ContactBodies& bodies, double substep_s,
                 double falls_m);
/// Second: velocities with the change that gravity makes, for contacts alone.
void kick_balls(const BallList& balls, const SceneState& state, ContactBodies& bodies,
                const Vector4& change_m_s);
/// Third: adds the changes by gravity and contacts to the state, then half a drift.
void finish_balls(const BallList& balls, SceneState& state, const ContactBodies& bodies,
                  double substep_s, const Vector4& change_m_s);
/// Turns balls by the angular velocity that they have, for duration_s.
void turn_balls(const BallList& balls, SceneState& state, double duration_s);
/// Whether all balls stay within the way that contacts were listed for, for duration_s.
[[nodiscard]] bool stay_within(const BallList& balls, const SceneState& state, double duration_s,
                               double falls_m);

}  // namespace stillgrid::dynamics
