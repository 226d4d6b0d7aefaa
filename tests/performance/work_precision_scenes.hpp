#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::performance {

/// A scene of the work-precision chart, and when its error is looked at.
struct ChartScene {
  std::string name;
  scene::SceneDescription scene;
  double early_s = 0.25;  // before what is chaotic or not smooth has grown
  double end_s = 1.0;
  double rest_s = 0.0;   // later yet: when all has settled, 0: not looked at
  bool smooth = true;    // masses and springs, no contact
  double limit_s = 0.5;  // processor time that a run may take; rivals may take four times as long
};

/// A cloth of nodes x nodes, 1 m x 1 m and 1 kg, level, pinned at two corners of one side, let go
/// under gravity. Shear springs have half and bend springs a tenth of the stiffness; nothing damps.
/// Its four collision spheres are too small to meet.
[[nodiscard]] ChartScene cloth_scene(int nodes, double stiffness_N_per_m);

/// Ten masses of 10 g on links of 0.1 m and 1,000 N/m, let go 30 degrees from the vertical.
[[nodiscard]] ChartScene hanging_chain_scene();

/// The chain of the order test (docs/cases.md, case 3.14): ten masses of 10 g on 100 N/m, let go
/// unstretched, straight down. It is linear.
[[nodiscard]] ChartScene chain_modes_scene();
/// Its exact nodes at time_s, from its modes.
[[nodiscard]] Eigen::Matrix3Xd chain_modes_positions_m(double time_s);

/// The shipped threads, all set swinging alike.
[[nodiscard]] ChartScene threads_scene();

/// The shipped tissue and blocks: contacts with friction.
[[nodiscard]] ChartScene tissue_scene();

/// All of them, in the order of the chart.
[[nodiscard]] std::vector<ChartScene> chart_scenes();

/// Whether a scene is of masses and springs, and nothing damps or touches.
[[nodiscard]] bool is_conservative(const ChartScene& scene);

/// Where a world's nodes and free rigid bodies' centres are, a column each.
[[nodiscard]] Eigen::Matrix3Xd positions_m(const bodies::World& world);

/// Root mean square distance of places from a reference's; infinite for what is no number.
[[nodiscard]] double rms_distance_m(const Eigen::Matrix3Xd& places_m,
                                    const Eigen::Matrix3Xd& reference_m);

}  // namespace stillgrid::performance
