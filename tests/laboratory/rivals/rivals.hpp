#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "shared/rendering/renderer.hpp"

namespace stillgrid::laboratory {

/// What stands for the scene between two snapshots instead of the product's grid, to be measured
/// beside it: docs/algorithms/intermediate_models.md.
struct Rival {
  std::string_view name;  // as --model of the laboratory takes it
  std::unique_ptr<rendering::Renderer> (*make)();
};
/// Those that are made of snapshots alone.
[[nodiscard]] std::span<const Rival> rivals() noexcept;

/// Null where there is none of that name.
[[nodiscard]] const Rival* rival_named(std::string_view name) noexcept;

/// The rival's renderer; without one the product's own, the grid, with that transition.
[[nodiscard]] std::unique_ptr<rendering::Renderer> make_renderer(const Rival* rival,
                                                                 display::Transition transition);

}  // namespace stillgrid::laboratory
