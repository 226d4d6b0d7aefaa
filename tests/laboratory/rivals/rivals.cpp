#include "tests/laboratory/rivals/rivals.hpp"

#include "tests/laboratory/rivals/crossfade.hpp"
#include "tests/laboratory/rivals/force_held.hpp"
#include "tests/laboratory/rivals/force_jacobian.hpp"
#include "tests/laboratory/rivals/local_model_renderer.hpp"
#include "tests/laboratory/rivals/local_plane.hpp"
#include "tests/laboratory/rivals/local_sphere.hpp"
#include "tests/laboratory/rivals/proxy.hpp"

namespace stillgrid::laboratory {
namespace {

template <class Local>
std::unique_ptr<rendering::Renderer> local() {
  return std::make_unique<LocalModelRenderer>(std::make_unique<Local>());
}

std::unique_ptr<rendering::Renderer> crossfade() {
  return std::make_unique<CrossfadeRenderer>();
}

constexpr Rival kRivals[] = {
    {"force_held", local<ForceHeld>},          // the slow process's force
    {"force_jacobian", local<ForceJacobian>},  // with its derivatives by place and velocity
    {"plane", local<LocalPlane>},              // the tangent plane, with recovery
    {"sphere", local<LocalSphere>},            // fitted to the surface near the tool
    {"proxy", local<Proxy>},                   // a god-object on the spheres near the tool
    {"crossfade", crossfade},  // the forces of the last two snapshots, one passing to the other
};

}  // namespace

std::span<const Rival> rivals() noexcept {
  return kRivals;
}

const Rival* rival_named(std::string_view name) noexcept {
  for (const Rival& rival : kRivals)
    if (rival.name == name) return &rival;
  return nullptr;
}

std::unique_ptr<rendering::Renderer> make_renderer(const Rival* rival,
                                                   display::Transition transition) {
  return rival != nullptr ? rival->make() : rendering::make_renderer(transition);
}

}  // namespace stillgrid::laboratory
