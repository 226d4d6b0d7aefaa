#include <catch2/catch.hpp>

#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid::dynamics::integrator_traits_test {
namespace {

TEST_CASE("What an integrator can is what its family in scene files promises",
          "[integrator_traits]") {
  for (const scene::IntegratorKind& kind : scene::kIntegrators) {
    INFO(scene::name_of(kind));
    if (scene::is_explicit(kind)) continue;  // the engine's
    const IntegratorTraits traits = make_integrator({.integrator = kind})->traits();
    CHECK(traits.solves == scene::is_implicit(kind));
    CHECK((traits.most_iterations > 0) == scene::chooses_steps(kind));
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::integrator_traits_test
