#pragma once

#include <vector>

#include "tests/performance/work_precision_run.hpp"

namespace stillgrid::performance {

/// A conservative scene run by MuJoCo (2.2.2): each free node a body on three slides, each spring a
/// tendon, moved on by the integrator that the point's solver names: "euler", "rk4" or "implicit".
[[nodiscard]] RunResult run_mujoco(const ChartScene& scene, const ChartPoint& point,
                                   double limit_s);

/// As run_mujoco() by "euler", let settle: all velocities are set to zero after every step. The
/// places at the end; for holding its statics against the catalogue's.
[[nodiscard]] Eigen::Matrix3Xd mujoco_at_rest_m(const scene::SceneDescription& scene, double step_s,
                                                int steps);

/// The curves of MuJoCo's for a scene; none where it is not conservative, MuJoCo has no room for it
/// or the build no MuJoCo.
[[nodiscard]] std::vector<Curve> mujoco_curves(const ChartScene& scene);

}  // namespace stillgrid::performance
