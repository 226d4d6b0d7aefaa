#include "sim_server/snapshot/moving_snapshot.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim_server/snapshot/sphere_records.hpp"

namespace stillgrid::snapshot {
namespace {

Eigen::Map<const Eigen::Vector3f> vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data());
}

}  // namespace

MovingSnapshot::MovingSnapshot(const bodies::World& world, contact::Detection& detection)
    : snapshots_(world.spheres.size()) {
  const auto records = detection.spheres().grid().records();
  for (std::size_t i = 0; i < records.size(); ++i) {
    describe(world.spheres[i], records[i]);
    if (world.spheres[i].is_field_point) records[i].material = proto::kFieldPoint;
  }
  show(detection);
}

void MovingSnapshot::show(contact::Detection& detection) {
  const std::span<const bodies::SphereMotion> motions = detection.motions();
  for (std::size_t i = 0; i < snapshots_.size(); ++i) snapshots_[i] = state_of(motions[i]);
  show(snapshots_, detection.spheres());
}

void MovingSnapshot::show(std::span<const proto::SphereState> snapshots,
                          contact::MovingSpheres& spheres) {
  collision::VoxelGrid& grid = spheres.grid();
  grid.push_snapshot(snapshots);
  const auto records = grid.records();
  const bool is_entered_anew = spheres.entered_count() != shown_entry_;
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    const proto::SphereRecord& record = records[i];
    const Eigen::Array3f centre_m = vector(spheres.swept_bound(i).centre_m);
    const auto distance_m2 = [&](const std::array<float, 3>& position_m) {
      return (vector(position_m).array() - centre_m).square().sum();
    };
    float farthest_m2 = distance_m2(record.newest.position_m);
    if (is_entered_anew)
      farthest_m2 = std::max({farthest_m2, distance_m2(record.older[0].position_m),
                              distance_m2(record.older[1].position_m),
                              distance_m2(record.oldest_position_m)});
    const float room_m =
        (1.0F - contact::kBoundSlack) * spheres.swept_bound(i).bounding_radius_m - record.radius_m;
    if (farthest_m2 > room_m * std::abs(room_m))
      grid.grow(i, (std::sqrt(farthest_m2) + record.radius_m) * (1.0F + contact::kBoundSlack));
  }
  shown_entry_ = spheres.entered_count();
  spheres.reshape();
}

void MovingSnapshot::forget_predictions(contact::MovingSpheres& moving) {
  for (proto::SphereRecord& record : moving.grid().records()) {
    record.predicted_velocity_m_s = record.newest.velocity_m_s;
    record.response = 0;
  }
}

void MovingSnapshot::take_predictions(std::span<const std::uint32_t> spheres,
                                      std::span<const bodies::SpherePrediction> prediction,
                                      double prediction_s, double lag_s,
                                      contact::MovingSpheres& moving) {
  collision::VoxelGrid& grid = moving.grid();
  const auto records = grid.records();
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    proto::SphereRecord& record = records[spheres[k]];
    const Eigen::Vector3f velocity_m_s = prediction[k].predicted_velocity_m_s.cast<float>();
    record.predicted_velocity_m_s = {velocity_m_s.x(), velocity_m_s.y(), velocity_m_s.z()};
    record.response = prediction[k].response;
  }
  const auto ahead = static_cast<float>(prediction_s), behind = static_cast<float>(lag_s);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const proto::SphereRecord& record = records[i];
    const collision::SweptBound& swept_bound = grid.swept_bound(i);
    const Eigen::Vector3f from_m = vector(record.newest.position_m) - vector(swept_bound.centre_m);
    const Eigen::Vector3f velocity_m_s = vector(record.predicted_velocity_m_s);
    const float farthest_m2 = std::max((from_m + ahead * velocity_m_s).squaredNorm(),
                                       (from_m - behind * velocity_m_s).squaredNorm());
    const float bounding_radius_m =
        (std::sqrt(farthest_m2) + record.radius_m) * (1.0F + contact::kBoundSlack);
    if (bounding_radius_m > swept_bound.bounding_radius_m) grid.grow(i, bounding_radius_m);
  }
  moving.reshape();
}

}  // namespace stillgrid::snapshot
