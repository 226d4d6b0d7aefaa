#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "shared/local/given_scene.hpp"
#include "shared/local/local_scene.hpp"
#include "shared/publication/moving_fields.hpp"
#include "shared/publication/moving_records.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// A scene's local copy. A scene of our engine is copied whole, with its spheres and fields as a
/// slot has them. A publisher's scene has the bodies near the tools here.
///
/// Thread: that of the haptic loop, once it is constructed.
class LocalCopy {
 public:
  /// Throws std::exception where the scene has no model, or one that is not sound.
  explicit LocalCopy(const publication::SceneView& view);

  using Scene = std::variant<local::LocalScene, local::GivenScene>;
  [[nodiscard]] Scene& scene() noexcept { return scene_; }
  /// Whether the scene is a publisher's.
  [[nodiscard]] bool is_given() const noexcept {
    return std::holds_alternative<local::GivenScene>(scene_);
  }
  /// Puts the given bodies of this tick in the place of the snapshot's. Realtime: yes. Pre:
  /// is_given(), touched is of the same tool.
  void replace(std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) const noexcept;

  /// Shows the scene of this tick. Realtime: yes, but where spheres are entered anew. Pre: not
  /// is_given().
  void show();
  /// Returns the spheres and fields of the last show(). Valid until the next one.
  [[nodiscard]] collision::GridView view() const noexcept;

  /// Bytes of a snapshot's state, to be loaded: room for the largest one.
  [[nodiscard]] std::vector<std::byte>& loaded() noexcept { return loaded_; }

 private:
  void declare(std::size_t count);
  void show_spheres();
  void show_fields() noexcept;

  Scene scene_;
  std::vector<std::byte> loaded_;
  publication::MovingRecords records_;
  std::vector<double> positions_m_, velocities_m_s_;  // one a moving sphere
  publication::MovingFields fields_;
  std::vector<std::uint64_t> field_words_;  // the same records as words
};

}  // namespace stillgrid::rendering
