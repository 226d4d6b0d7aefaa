#include <stdexcept>

#include "tests/performance/work_precision_mujoco.hpp"

namespace stillgrid::performance {

RunResult run_mujoco(const ChartScene& /*scene*/, const ChartPoint& /*point*/, double /*limit_s*/) {
  throw std::logic_error("no MuJoCo in this build");
}

Eigen::Matrix3Xd mujoco_at_rest_m(const scene::SceneDescription& /*scene*/, double /*step_s*/,
                                  int /*steps*/) {
  throw std::logic_error("no MuJoCo in this build");
}

std::vector<Curve> mujoco_curves(const ChartScene& /*scene*/) {
  return {};
}

}  // namespace stillgrid::performance
