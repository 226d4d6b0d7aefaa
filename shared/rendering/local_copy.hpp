#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/local/local_scene.hpp"
#include "shared/publication/moving_fields.hpp"
#include "shared/publication/moving_records.hpp"
#include "shared/publication/scene_segment.hpp"

namespace stillgrid::rendering {

/// A scene's local copy, with its spheres and fields as a slot would have them.
///
/// Thread: that of the haptic loop, once it is constructed.
class LocalCopy {
 public:
  /// Throws std::exception where the scene has no model, or one that is not sound.
  explicit LocalCopy(const publication::SceneView& view);

  [[nodiscard]] local::LocalScene& scene() noexcept { return scene_; }
  /// Shows the scene of this tick. Realtime: yes, but where spheres are entered anew.
  void show();
  /// Returns the spheres and fields of the last show(). Valid until the next one.
  [[nodiscard]] collision::GridView view() const noexcept;

  /// Bytes of a snapshot's state, to be loaded: room for the largest one.
  [[nodiscard]] std::vector<std::byte>& loaded() noexcept { return loaded_; }

 private:
  void show_spheres();
  void show_fields() noexcept;

  local::LocalScene scene_;
  std::vector<std::byte> loaded_;
  publication::MovingRecords records_;
  std::vector<double> positions_m_, velocities_m_s_;  // one a moving sphere
  publication::MovingFields fields_;
  std::vector<std::uint64_t> field_words_;  // the same records as words
};

}  // namespace stillgrid::rendering
