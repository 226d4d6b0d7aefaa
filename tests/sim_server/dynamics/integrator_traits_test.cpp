#include <catch2/catch.hpp>

#include "shared/tools/laboratory/methods/laboratory_methods.hpp"
#include "sim_server/dynamics/integrators/integrator.hpp"

namespace stillgrid {
namespace {

TEST_CASE("What an integrator can is what its family in scene files promises",
          "[integrator_traits]") {
  for (const IntegratorKind& kind : laboratory_methods().integrators) {
    INFO(name_of(kind));
    const IntegratorTraits traits = make_integrator({.integrator = kind})->traits();
    CHECK(traits.solves == needs_solver(kind));
    CHECK(traits.divides_itself == is_explicit(kind));
    CHECK(traits.always_advances == is_explicit(kind));
    CHECK((traits.most_iterations > 0) == chooses_steps(kind));
  }
}

TEST_CASE("An explicit integrator looks within its step unless its substeps are given",
          "[integrator_traits]") {
  const Method free{.integrator = IntegratorKind::kVelocityVerlet};
  const Method given{.integrator = IntegratorKind::kVelocityVerlet, .substeps = 3};
  CHECK(make_integrator(free)->traits().looks_within);
  CHECK(make_integrator(free)->traits().longest_part_s == 4e-3);
  CHECK_FALSE(make_integrator(given)->traits().looks_within);
}

}  // namespace
}  // namespace stillgrid
