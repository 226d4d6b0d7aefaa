#pragma once

#include <vector>

#include "tests/performance/work_precision_run.hpp"

namespace stillgrid::performance {

/// A cloth scene run by Bullet's deformable body (3.24, double precision): the same nodes, masses
/// and springs, backward Euler or, for the point's solver "explicit", its explicit steps. Nothing
/// damps, nothing collides.
[[nodiscard]] RunResult run_bullet(const ChartScene& scene, const ChartPoint& point,
                                   double limit_s);

/// As run_bullet(), let settle: all velocities are set to zero after every step. The places at the
/// end; for holding its statics against the catalogue's.
[[nodiscard]] Eigen::Matrix3Xd bullet_at_rest_m(const scene::SceneDescription& scene, double step_s,
                                                int steps);

/// The curves of Bullet's for a scene; none where it is not conservative.
[[nodiscard]] std::vector<Curve> bullet_curves(const ChartScene& scene);

}  // namespace stillgrid::performance
