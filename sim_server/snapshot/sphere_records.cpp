#include "sim_server/snapshot/sphere_records.hpp"

#include "shared/collision/sphere_history.hpp"

namespace stillgrid::snapshot {

proto::SphereState state_of(const bodies::SphereMotion& motion) noexcept {
  const Eigen::Vector3f p = motion.position_m.cast<float>();
  const Eigen::Vector3f v = motion.velocity_m_s.cast<float>();
  return {{p.x(), p.y(), p.z()}, {v.x(), v.y(), v.z()}};
}

std::vector<proto::SphereRecord> static_records(const bodies::World& world) {
  std::vector<proto::SphereRecord> records;
  for (const bodies::StaticSphere& sphere : world.static_spheres) {
    proto::SphereRecord& record = records.emplace_back();
    collision::fill_history(record, state_of({sphere.position_m, Eigen::Vector3d::Zero()}));
    describe(sphere, record);
  }
  return records;
}

}  // namespace stillgrid::snapshot
