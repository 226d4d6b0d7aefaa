#include "shared/tools/laboratory/methods/laboratory_methods.hpp"

#include <algorithm>
#include <array>

#include "shared/tools/laboratory/methods/arkode_integrator.hpp"
#include "shared/tools/laboratory/methods/broyden.hpp"
#include "shared/tools/laboratory/methods/forward_euler.hpp"
#include "shared/tools/laboratory/methods/kinsol_solver.hpp"

namespace stillgrid::laboratory {
namespace {

template <class Kind, std::size_t kOurs, std::size_t kMore>
constexpr auto joined(const std::array<Kind, kOurs>& ours, const std::array<Kind, kMore>& more) {
  std::array<Kind, kOurs + kMore> all{};
  std::copy(more.begin(), more.end(), std::copy(ours.begin(), ours.end(), all.begin()));
  return all;
}

constexpr auto kAllIntegrators =
    joined(scene::kIntegrators, std::array{kForwardEuler, kArkodeDirk});
constexpr auto kAllSolvers = joined(
    scene::kSolvers, std::array{kBroyden, kBroydenMass, kKinsolNewtonKrylov, kKinsolAnderson});

}  // namespace

scene::MethodTable laboratory_methods() noexcept {
  return {kAllIntegrators, kAllSolvers};
}

}  // namespace stillgrid::laboratory
