#pragma once

#include <unistd.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "shared/rendering/snapshot_renderer.hpp"
#include "tests/shared/collision/sphere_state.hpp"

namespace stillgrid::rendering {

inline constexpr std::uint64_t kMillisecond_ns = 1'000'000;

/// One material and a tool of one sphere: enough for the known answers.
inline publication::StaticScene plain_scene(float stiffness_N_per_m, float tool_radius_m,
                                            float damping_N_s_per_m = 0.0F) {
  publication::StaticScene scene;
  scene.name = "fixture";
  scene.materials = {{stiffness_N_per_m, damping_N_s_per_m, 0.0F, 1e-3F}};
  scene.tool = {{{0.0F, 0.0F, 0.0F}, tool_radius_m}};
  scene.device = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}, 1.0};
  scene.tool_slip_speed_m_s = 0.05F;  // no proxy: tests put the tool where they like
  return scene;
}

/// Both ends of a scene segment in one process: what is shown goes through shared memory.
class PublishedScene {
 public:
  PublishedScene(const publication::StaticScene& scene, const std::vector<float>& radii_m,
                 std::uint64_t period_ns)
      : session_("render-" + std::to_string(::getpid()) + "-" + std::to_string(count_++)),
        writer_(session_, scene, radii_m.size(), period_ns, proto::Clock::kVirtual, 0),
        view_(*publication::SegmentReader::open(session_, proto::SegmentKind::kScene,
                                                proto::kSceneLayoutHash)),
        snapshot_(sizeof(proto::SnapshotHeader), radii_m.size()) {
    for (std::size_t i = 0; i < radii_m.size(); ++i) snapshot_.records()[i].radius_m = radii_m[i];
  }

  ~PublishedScene() {
    ::unlink(
        (publication::own_segment_path(session_, proto::SegmentKind::kScene) + ".lock").c_str());
  }
  PublishedScene(const PublishedScene&) = delete;
  PublishedScene& operator=(const PublishedScene&) = delete;
  PublishedScene(PublishedScene&&) = delete;
  PublishedScene& operator=(PublishedScene&&) = delete;

  /// Shows the spheres at time_ns, simulated and published at once. tool_ns: of the tool sample
  /// they are taken to be computed with, 0: none. NaN: a sphere is absent.
  void show(const std::vector<Eigen::Vector3d>& positions_m,
            const std::vector<Eigen::Vector3d>& velocities_m_s, std::uint64_t time_ns,
            std::uint64_t tool_ns = 0) {
    std::vector<proto::SphereState> snapshots;
    for (std::size_t i = 0; i < positions_m.size(); ++i)
      snapshots.push_back(collision::sphere_state(positions_m[i], velocities_m_s[i]));
    snapshot_.push_snapshot(snapshots);
    snapshot_.enter(collision::history_bounds(snapshot_.records()), 1.0F);
    writer_.publish(snapshot_, {.state_ns = time_ns, .publish_ns = time_ns, .tool_ns = tool_ns},
                    fields);
  }
  void show(const std::vector<Eigen::Vector3d>& positions_m, std::uint64_t time_ns) {
    show(positions_m, std::vector<Eigen::Vector3d>(positions_m.size(), Eigen::Vector3d::Zero()),
         time_ns);
  }

  [[nodiscard]] const publication::SceneView& view() const { return view_; }
  [[nodiscard]] publication::SceneWriter& writer() { return writer_; }
  [[nodiscard]] std::span<proto::SphereRecord> records() { return snapshot_.records(); }

  std::vector<proto::FieldRecord> fields;  // that move, as the next snapshot shows them

 private:
  inline static int count_ = 0;
  std::string session_;
  publication::SceneWriter writer_;
  publication::SceneView view_;
  collision::VoxelGrid snapshot_;
};

}  // namespace stillgrid::rendering
