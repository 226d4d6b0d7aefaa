#pragma once

#include "proto/scene_segment.hpp"

namespace stillgrid::collision {

/// The same snapshot twice: of what stands still, and of a first snapshot.
inline void fill_history(proto::SphereRecord& record, const proto::SphereState& snapshot) noexcept {
  record.newest = record.before = snapshot;
}

/// One more snapshot.
inline void push_snapshot(proto::SphereRecord& record,
                          const proto::SphereState& snapshot) noexcept {
  record.before = record.newest;
  record.newest = snapshot;
}

}  // namespace stillgrid::collision
