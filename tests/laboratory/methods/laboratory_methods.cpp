#include "tests/laboratory/methods/laboratory_methods.hpp"

#include <array>

#include "tests/laboratory/methods/broyden.hpp"

namespace stillgrid::laboratory {

scene::Integrators laboratory_methods() noexcept {
  static constexpr std::array kAll = {scene::IntegratorKind::kVelocityVerlet,
                                      scene::IntegratorKind::kImplicitEuler,
                                      scene::IntegratorKind::kCvodeBdf, kBroyden};
  return kAll;
}

}  // namespace stillgrid::laboratory
