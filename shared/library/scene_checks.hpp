#pragma once

#include <vector>

#include "proto/stillgrid.h"
#include "shared/local/given_state.hpp"
#include "shared/publication/session.hpp"

namespace stillgrid::library {

/// What a session is opened with, of what was declared; fails at what no reader would take.
int read_scene(const stillgrid_scene& scene, publication::SessionSpec& spec,
               std::vector<publication::HandScene>& hands);

/// Returns the model of a session's given bodies: its tools and materials.
[[nodiscard]] local::GivenModel given_model(const publication::SessionSpec& spec,
                                            std::span<const publication::HandScene> hands);

/// Whether shapes have what moving ones (or static ones, with positions) must have, and materials
/// that there are. Realtime: yes.
[[nodiscard]] int check_shapes(const stillgrid_shapes& shapes, std::uint32_t material_count,
                               bool is_static) noexcept;

}  // namespace stillgrid::library
