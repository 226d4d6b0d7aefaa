#pragma once

#include "proto/distance_field.hpp"
#include "shared/publication/moving_fields.hpp"
#include "sim_server/bodies/world.hpp"

namespace stillgrid::snapshot {

/// Returns where a field's frame is and how it moves, as it is published: in floats.
[[nodiscard]] proto::FieldState state_of(const bodies::World& world,
                                         const bodies::FieldBody& field) noexcept;

/// The records of the world's moving fields, numbered as World::fields, where they are.
[[nodiscard]] publication::MovingFields moving_fields(const bodies::World& world);

/// One more snapshot of them.
void show(const bodies::World& world, publication::MovingFields& fields) noexcept;

}  // namespace stillgrid::snapshot
