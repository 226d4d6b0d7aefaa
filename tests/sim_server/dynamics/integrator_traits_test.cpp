#include <catch2/catch.hpp>

#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid::dynamics::integrator_traits_test {
namespace {

TEST_CASE("What an integrator can is what its family in scene files promises",
          "[integrator_traits]") {
  for (const scene::IntegratorKind& kind : scene::kIntegrators) {
    INFO(scene::name_of(kind));
    const IntegratorTraits traits = make_integrator({.integrator = kind})->traits();
    CHECK(traits.solves == scene::is_implicit(kind));
    CHECK(traits.divides_itself == scene::is_explicit(kind));
    CHECK(traits.always_advances == scene::is_explicit(kind));
    CHECK((traits.most_iterations > 0) == scene::chooses_steps(kind));
  }
}

TEST_CASE("An explicit integrator looks within its step unless its substeps are given",
          "[integrator_traits]") {
  const scene::Method free{.integrator = scene::IntegratorKind::kVelocityVerlet};
  const scene::Method given{.integrator = scene::IntegratorKind::kVelocityVerlet, .substeps = 3};
  CHECK(make_integrator(free)->traits().looks_within);
  CHECK(make_integrator(free)->traits().longest_part_s == 4e-3);
  CHECK_FALSE(make_integrator(given)->traits().looks_within);
}

}  // namespace
}  // namespace stillgrid::dynamics::integrator_traits_test
