#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "haptic_server/recording/scene_sample.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/snapshot_reader.hpp"

namespace stillgrid::recording {

/// Takes from a scene what a recording shows of it: a snapshot each, as long as that is no more
/// than kMaxSpheresPerSecond, else fewer; and none that shows what the last one showed. Thread:
/// one.
class SceneSampler {
 public:
  static constexpr std::uint64_t kMaxSpheresPerSecond = 20'000;
  /// Of a sample. Of more, every second is taken, every third, ...
  static constexpr std::size_t kMaxSpheres = 20'000;

  /// The latest snapshot, where it is due and shows something else. Not real-time.
  [[nodiscard]] std::optional<SceneSample> sample(const publication::SceneView& scene);

 private:
  publication::SnapshotReader reader_;
  bool is_first_ = true;      // of this scene
  std::uint64_t due_ns_ = 0;  // on the writer's clock
  std::vector<SampledSphere> last_;
};

}  // namespace stillgrid::recording
