#pragma once

#include "shared/publication/scene_segment.hpp"
#include "tests/shared/collision/sphere_state.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication {

/// A scene with every kind of thing in its fixed part but fields.
inline StaticScene small_scene() {
  StaticScene scene;
  scene.name = "small";
  scene.materials = {{500.0F, 1.0F, 0.2F, 1e-3F}, {2000.0F, 4.0F, 0.4F, 2e-3F}};
  scene.planes = {{{0.0F, 0.0F, 1.0F}, -0.1F, 1, 5}};
  scene.tool = {{{0.0F, 0.0F, 0.0F}, 0.005F}, {{0.0F, 0.0F, 0.01F}, 0.004F}};
  for (int i = 0; i < 10; ++i) {
    scene.spheres.push_back(
        collision::static_sphere({0.01F * static_cast<float>(i), 0.0F, -0.05F}, 0.008F));
    scene.spheres.back().material = 1;
    scene.spheres.back().body = 6;
  }
  scene.device = {{0.1, 0.2, 0.3}, {0.0, 0.0, 0.6, 0.8}, 2.0};
  return scene;
}

inline constexpr std::size_t kMovingSpheres = 7;
inline constexpr std::uint64_t kPeriod_ns = 30'000'000;

/// The simulation's end, its moving spheres described.
class SmallSceneWriter {
 public:
  explicit SmallSceneWriter(const TestSession& session)
      : writer_(session.name(), small_scene(), kMovingSpheres, kPeriod_ns, proto::Clock::kVirtual,
                0) {
    for (std::uint32_t i = 0; i < kMovingSpheres; ++i) {
      proto::SphereRecord& record = snapshot_.records()[i];
      record.radius_m = 0.01F;
      record.material = 1;
      record.body = i;
    }
  }

  /// Where snapshot n shows sphere i, and how fast.
  [[nodiscard]] static Eigen::Vector3d position_m(std::size_t i, std::uint64_t n) {
    return {0.03 * static_cast<double>(i), 0.004 * static_cast<double>(n), -0.25};
  }
  [[nodiscard]] static Eigen::Vector3d velocity_m_s(std::size_t i, std::uint64_t n) {
    return {0.5 * static_cast<double>(i), 0.0, static_cast<double>(n)};
  }

  void publish_next() {
    const std::uint64_t n = writer_.snapshot_id() + 1;
    std::vector<proto::SphereState> snapshots;
    for (std::size_t i = 0; i < kMovingSpheres; ++i)
      snapshots.push_back(collision::sphere_state(position_m(i, n), velocity_m_s(i, n)));
    snapshot_.push_snapshot(snapshots);
    snapshot_.enter(collision::history_bounds(snapshot_.records()), 1.0F);
    writer_.publish(snapshot_, {.state_ns = n * kPeriod_ns,
                                .publish_ns = n * kPeriod_ns + 5,
                                .tool_ns = n * kPeriod_ns - 9,
                                .step_ns = 1000 + n,
                                .contacts = n,
                                .tool_work_J = 0.25 * static_cast<double>(n)});
  }

  [[nodiscard]] SceneWriter& writer() noexcept { return writer_; }
  [[nodiscard]] const collision::VoxelGrid& snapshot() const noexcept { return snapshot_; }

 private:
  collision::VoxelGrid snapshot_{sizeof(proto::SnapshotHeader), kMovingSpheres};
  SceneWriter writer_;
};

}  // namespace stillgrid::publication
