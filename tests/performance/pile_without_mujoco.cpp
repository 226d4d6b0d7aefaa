#include "tests/performance/pile.hpp"

namespace stillgrid::performance {

std::unique_ptr<PileEngine> mujoco_pile(const Pile& /*pile*/) {
  return nullptr;
}

}  // namespace stillgrid::performance
