#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "haptic_server/rendering/renderer.hpp"

namespace stillgrid {

/// What stands for the scene between two snapshots: the product's grid, and what is measured beside
/// it (docs/algorithms/intermediate_models.md). A row of models() each.
enum class Model : std::uint8_t {
  kGrid,           // the whole snapshot, passing to the next by a transition: the paper's
  kForceHeld,      // the slow process's force
  kForceJacobian,  // that force with its derivatives by the tool's place and velocity
  kPlane,          // the tangent plane, with recovery
  kSphere,         // a sphere fitted to the surface near the tool
  kProxy,          // a god-object on the spheres near the tool
  kCrossfade,      // the forces of the last two snapshots, one passing to the other
};

struct ModelRow {
  Model model;
  std::string_view name;  // as --model of the laboratory takes it
  std::unique_ptr<Renderer> (*make)(Transition transition);
};

/// In the order of the enumeration.
[[nodiscard]] std::span<const ModelRow> models() noexcept;

[[nodiscard]] std::string_view name_of(Model model) noexcept;
[[nodiscard]] std::optional<Model> model_named(std::string_view name) noexcept;

/// transition: of the grid; the others have none.
[[nodiscard]] std::unique_ptr<Renderer> make_renderer(Model model, Transition transition);

}  // namespace stillgrid
