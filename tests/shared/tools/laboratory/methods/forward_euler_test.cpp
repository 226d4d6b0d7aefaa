#include "shared/tools/laboratory/methods/forward_euler.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sim_server/dynamics/known_answers/oscillator.hpp"

namespace stillgrid::laboratory::forward_euler_test {
namespace {

TEST_CASE("Forward Euler without damper grows at every step, by sqrt(1 + w^2 h^2)",
          "[forward_euler]") {
  const auto [step_s, steps] =
      GENERATE(std::pair(1e-5, 2000), std::pair(1e-3, 500), std::pair(1e-2, 12));
  const double wh = dynamics::kRate_rad_s * step_s;
  CHECK(dynamics::energy_growth(0.0, kForwardEuler, step_s, steps) ==
        Approx(std::pow(1.0 + wh * wh, steps)).epsilon(1e-8));
}

TEST_CASE("Forward Euler with damper decays below 2 zeta / w and grows above", "[forward_euler]") {
  const double damping_ratio = GENERATE(0.05, 0.2, 0.5);
  const double limit_s = 2.0 * damping_ratio / dynamics::kRate_rad_s;
  CHECK(dynamics::energy_growth(damping_ratio, kForwardEuler, 0.99 * limit_s, 40000) < 0.5);
  CHECK(dynamics::energy_growth(damping_ratio, kForwardEuler, 1.01 * limit_s, 40000) > 2.0);
}

}  // namespace
}  // namespace stillgrid::laboratory::forward_euler_test
