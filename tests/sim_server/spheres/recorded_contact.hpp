#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::spheres {

/// Radius of the sphere that stands for the recorded tool, which is known by its contact point
/// only. Three times the largest rms of the authors' registration to the mesh (1.54 mm), rounded
/// up: the least at which a tool that touches is found touching. Chosen before any force was
/// compared.
inline constexpr double kRecordedTool_m = 0.005;

/// Places of a tool's contact point and the force on it, m and N, in the mesh's frame.
struct RecordedContact {
  std::string name;
  std::vector<Eigen::Vector3d> position_m, force_N;
};

/// The folder of real inputs, if it is there: $STILLGRID_DATA, or ../shared/data of the project.
[[nodiscard]] std::optional<std::filesystem::path> real_data();

/// The demonstrations a to d, twice each, of people who pressed a tool along an edge.
[[nodiscard]] std::vector<RecordedContact> read_contour_demonstrations(
    const std::filesystem::path& data);

/// How a model's forces go with those measured.
struct ContactAgreement {
  double share_in_contact = 0.0;  // of samples at which the model has a force
  double mean_cosine = 0.0;       // with the measured force, over those
  double correlation = 0.0;       // of its size with the measured one's, over all (Pearson's)
};
[[nodiscard]] ContactAgreement agreement(const RecordedContact& recorded, const UnitForce& force);

}  // namespace stillgrid::spheres
