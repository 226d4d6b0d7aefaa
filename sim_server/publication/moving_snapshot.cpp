#include "sim_server/publication/moving_snapshot.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shared/collision/sphere_history.hpp"
#include "sim_server/publication/sphere_records.hpp"

namespace stillgrid {
namespace {

Eigen::Map<const Eigen::Vector3f> vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data());
}

}  // namespace

MovingSnapshot::MovingSnapshot(const World& world, Detection& detection)
    : images_(world.spheres.size()) {
  const auto records = detection.spheres().grid().records();
  for (std::size_t i = 0; i < records.size(); ++i) describe(world.spheres[i], records[i]);
  show(detection);
}

void MovingSnapshot::show(Detection& detection) {
  const std::span<const SphereMotion> motions = detection.motions();
  for (std::size_t i = 0; i < images_.size(); ++i) images_[i] = image_of(motions[i]);
  show(images_, detection.spheres());
}

void MovingSnapshot::show(std::span<const proto::SphereImage> images, MovingSpheres& spheres) {
  StillGrid& grid = spheres.grid();
  grid.push_image(images);
  const auto records = grid.records();
  const bool is_entered_anew = spheres.entered_count() != shown_entry_;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const proto::SphereRecord& record = records[i];
    const Eigen::Array3f centre_m = vector(spheres.cover(i).centre_m);
    const auto distance_m2 = [&](const std::array<float, 3>& position_m) {
      return (vector(position_m).array() - centre_m).square().sum();
    };
    float farthest_m2 = distance_m2(record.newest.position_m);
    if (is_entered_anew)
      farthest_m2 = std::max({farthest_m2, distance_m2(record.older[0].position_m),
                              distance_m2(record.older[1].position_m),
                              distance_m2(record.oldest_position_m)});
    const float room_m = (1.0F - kCoverSlack) * spheres.cover(i).reach_m - record.radius_m;
    if (farthest_m2 > room_m * std::abs(room_m))
      grid.grow(i, (std::sqrt(farthest_m2) + record.radius_m) * (1.0F + kCoverSlack));
  }
  shown_entry_ = spheres.entered_count();
  spheres.reshape();
}

void MovingSnapshot::foretell(std::span<const SphereForesight> foresight, double drift_s,
                              double lag_s, MovingSpheres& spheres) {
  StillGrid& grid = spheres.grid();
  const auto records = grid.records();
  for (std::size_t i = 0; i < foresight.size(); ++i) {
    proto::SphereRecord& record = records[i];
    const Eigen::Vector3f drift_m_s = foresight[i].drift_m_s.cast<float>();
    const Eigen::Vector3f answer_m_N = foresight[i].answer_m_N.cast<float>();
    record.drift_m_s = {drift_m_s.x(), drift_m_s.y(), drift_m_s.z()};
    record.answer_m_N = {answer_m_N.x(), answer_m_N.y(), answer_m_N.z()};
    // The grid may have been entered anew since the images were shown: their places too.
    const Cover& cover = grid.cover(i);
    const Eigen::Vector3f newest_m = vector(record.newest.position_m);
    float far_m = 0.0F;
    const auto hold = [&](const Eigen::Vector3f& at_m) {
      far_m = std::max(far_m, (at_m - vector(cover.centre_m)).norm());
    };
    for (std::size_t age = 0; age < proto::kHistoryLength; ++age)
      hold(vector(position_m(record, age)));
    hold(newest_m + static_cast<float>(drift_s) * drift_m_s);
    hold(newest_m - static_cast<float>(lag_s) * drift_m_s);
    const float reach_m = (far_m + record.radius_m) * (1.0F + kCoverSlack);
    if (reach_m > cover.reach_m) grid.grow(i, reach_m);
  }
  shown_entry_ = spheres.entered_count();
  spheres.reshape();
}

}  // namespace stillgrid
