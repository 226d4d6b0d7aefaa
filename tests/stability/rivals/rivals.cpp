#include "tests/stability/rivals/rivals.hpp"

#include <array>
#include <cstddef>

#include "tests/stability/rivals/crossfade.hpp"
#include "tests/stability/rivals/force_held.hpp"
#include "tests/stability/rivals/force_jacobian.hpp"
#include "tests/stability/rivals/local_model_renderer.hpp"
#include "tests/stability/rivals/local_plane.hpp"
#include "tests/stability/rivals/local_sphere.hpp"
#include "tests/stability/rivals/proxy.hpp"

namespace stillgrid {
namespace {

template <class Local>
std::unique_ptr<Renderer> local(Transition) {
  return std::make_unique<LocalModelRenderer>(std::make_unique<Local>());
}

std::unique_ptr<Renderer> crossfade(Transition) {
  return std::make_unique<CrossfadeRenderer>();
}

constexpr std::array kModels = {
    ModelRow{Model::kGrid, "grid", make_renderer},
    ModelRow{Model::kForceHeld, "force_held", local<ForceHeld>},
    ModelRow{Model::kForceJacobian, "force_jacobian", local<ForceJacobian>},
    ModelRow{Model::kPlane, "plane", local<LocalPlane>},
    ModelRow{Model::kSphere, "sphere", local<LocalSphere>},
    ModelRow{Model::kProxy, "proxy", local<Proxy>},
    ModelRow{Model::kCrossfade, "crossfade", crossfade},
};

}  // namespace

std::span<const ModelRow> models() noexcept {
  return kModels;
}

std::string_view name_of(Model model) noexcept {
  return kModels[static_cast<std::size_t>(model)].name;
}

std::optional<Model> model_named(std::string_view name) noexcept {
  for (const ModelRow& row : kModels)
    if (row.name == name) return row.model;
  return std::nullopt;
}

std::unique_ptr<Renderer> make_renderer(Model model, Transition transition) {
  return kModels[static_cast<std::size_t>(model)].make(transition);
}

}  // namespace stillgrid
