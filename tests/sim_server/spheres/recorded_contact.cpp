#include "tests/sim_server/spheres/recorded_contact.hpp"

#include <cmath>
#include <cstdlib>

#include "shared/tables/trajectory.hpp"

namespace stillgrid::spheres {

std::optional<std::filesystem::path> real_data() {
  const char* const named = std::getenv("STILLGRID_DATA");
  const std::filesystem::path data =
      named ? std::filesystem::path(named)
            : std::filesystem::path(STILLGRID_SOURCE_DIR) / ".." / "shared" / "data";
  if (!std::filesystem::exists(data / "trajectories" / "ku_contour_force")) return std::nullopt;
  return data;
}

std::vector<RecordedContact> read_contour_demonstrations(const std::filesystem::path& data) {
  std::vector<RecordedContact> demonstrations;
  for (const char* const name : {"a_1", "a_2", "b_1", "b_2", "c_1", "c_2", "d_1", "d_2"}) {
    const auto file =
        data / "trajectories" / "ku_contour_force" / ("demo_" + std::string(name) + ".csv");
    const tables::Trajectory trajectory = tables::read_trajectory(file.string());
    demonstrations.push_back({name, trajectory.position_m, trajectory.force_N});
  }
  return demonstrations;
}

ContactAgreement agreement(const RecordedContact& recorded, const UnitForce& force) {
  const auto count = static_cast<double>(recorded.position_m.size());
  double touching = 0.0, cosines = 0.0;
  Eigen::ArrayXd model(recorded.position_m.size()), measured(recorded.position_m.size());
  for (std::size_t i = 0; i < recorded.position_m.size(); ++i) {
    const Eigen::Vector3d force_m = force(recorded.position_m[i]);
    model[static_cast<Eigen::Index>(i)] = force_m.norm();
    measured[static_cast<Eigen::Index>(i)] = recorded.force_N[i].norm();
    if (!(force_m.norm() > 0.0)) continue;
    touching += 1.0;
    cosines += force_m.normalized().dot(recorded.force_N[i].normalized());
  }
  model -= model.mean();
  measured -= measured.mean();
  const double spread = std::sqrt(model.square().sum() * measured.square().sum());
  return {touching / count, cosines / touching,
          spread > 0.0 ? (model * measured).sum() / spread : 0.0};
}

}  // namespace stillgrid::spheres
