#pragma once

#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
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
  return scene;
}

/// What a snapshot tells beside the present.
struct ShownPrediction {
  std::uint64_t period_ns = 0;                          // without a period nothing is predicted
  std::vector<Eigen::Vector3d> predicted_velocity_m_s;  // of each sphere; none: its velocity
  std::vector<proto::ResponseMode> modes;
  std::vector<proto::SphereResponse> responses;  // of each sphere in turn; none: of no more
  std::uint64_t late_ns = 0;                     // published so long after what it shows
  std::vector<proto::TurningBody> turning = {};
};

/// A mode of inertia alone, in which spheres move by these for a newton on the first, which the
/// tool pushes so in the snapshot.
inline void add_mode(ShownPrediction& shown, const std::vector<Eigen::Vector3d>& compliance_m_per_N,
                     const Eigen::Vector3d& push_N) {
  const double root = std::sqrt(compliance_m_per_N.front().norm());
  const std::size_t mode = shown.modes.size();
  shown.responses.resize(std::max(shown.responses.size(), compliance_m_per_N.size()));
  for (std::size_t i = 0; i < compliance_m_per_N.size(); ++i)
    Eigen::Map<Eigen::Vector3f>(shown.responses[i].modes[mode].data()) =
        (compliance_m_per_N[i] / root).cast<float>();
  shown.modes.push_back({.inertia_share = 1.0F,
                         .push = static_cast<float>(compliance_m_per_N.front().dot(push_N) / root),
                         .displacement = 0.0F,
                         .at_velocity = 0.0F,
                         .damping_share = proto::kOneStep});
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
            std::uint64_t tool_ns = 0, const ShownPrediction& prediction = {}) {
    std::vector<proto::SphereState> snapshots;
    for (std::size_t i = 0; i < positions_m.size(); ++i)
      snapshots.push_back(collision::sphere_state(positions_m[i], velocities_m_s[i]));
    snapshot_.push_snapshot(snapshots);
    const auto tell = [](std::array<float, 3>& number, const Eigen::Vector3d& value) {
      Eigen::Map<Eigen::Vector3f>(number.data()) = value.cast<float>();
    };
    for (std::size_t i = 0; i < prediction.predicted_velocity_m_s.size(); ++i)
      tell(snapshot_.records()[i].predicted_velocity_m_s, prediction.predicted_velocity_m_s[i]);
    for (std::size_t i = 0; i < std::min(prediction.responses.size(), positions_m.size()); ++i)
      snapshot_.records()[i].response = static_cast<std::uint32_t>(i) + 1;
    const double predicted_s = 1e-9 * static_cast<double>(prediction.period_ns);
    snapshot_.enter(
        collision::history_bounds(snapshot_.records(), proto::kPredictionPeriods * predicted_s),
        1.0F);
    writer_.publish(
        snapshot_,
        {.state_ns = time_ns, .publish_ns = time_ns + prediction.late_ns, .tool_ns = tool_ns},
        {.period_ns = prediction.period_ns,
         .modes = prediction.modes,
         .turning = prediction.turning,
         .responses = prediction.responses},
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
