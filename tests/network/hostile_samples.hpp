#pragma once

#include <cstdint>
#include <random>
#include <type_traits>
#include <vector>

#include "shared/tools/scene_relay/messages.hpp"
#include "shared/tools/scene_relay/sequence.hpp"

namespace stillgrid::network {

/// Messages that a relay sent, changed where a program would believe them, or made of random
/// numbers. Each is good until the next of its kind. Thread: one.
class HostileSamples {
 public:
  explicit HostileSamples(std::uint64_t seed) : random_(seed) {}

  [[nodiscard]] scene_relay::Status changed(scene_relay::Status status);
  [[nodiscard]] const scene_relay::ToolMessage& changed(const scene_relay::ToolMessage& tool);
  [[nodiscard]] const scene_relay::SceneMessage& changed(const scene_relay::SceneMessage& scene);
  [[nodiscard]] const scene_relay::SnapshotMessage& changed(
      const scene_relay::SnapshotMessage& snapshot);

 private:
  /// A number that is near the one given, at an end of its range, or any.
  [[nodiscard]] std::uint64_t odd(std::uint64_t number);
  [[nodiscard]] bool happens(double share) { return uniform_(random_) < share; }
  /// Random bits in a few of its words. Pre: it holds no pointer.
  template <class Plain>
  void scribble(Plain& plain);
  /// The elements, some of them scribbled upon, or more or fewer of them, up to `most`.
  template <class Sequence, class Element>
  void change(Sequence& sequence, std::vector<Element>& own, std::size_t most = 300);
  void change_bytes(std::vector<std::uint8_t>& bytes);

  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  scene_relay::ToolMessage tool_message_{};
  scene_relay::SceneMessage scene_{};
  scene_relay::SnapshotMessage snapshot_{};
  std::vector<stillgrid_relay3_Material> materials_;
  std::vector<stillgrid_relay3_Plane> planes_;
  std::vector<stillgrid_relay3_ToolSphere> tool_;
  std::vector<stillgrid_relay3_StaticSphere> spheres_;
  std::vector<stillgrid_relay3_FieldBody> bodies_;
  std::vector<std::uint32_t> moved_, relabelled_;
  std::vector<scene_relay::Motion> motions_;
  std::vector<scene_relay::Label> labels_;
  std::vector<scene_relay::FieldMotion> fields_;
  std::vector<scene_relay::PathSample> path_;
  std::vector<std::uint8_t> model_, state_;
};

}  // namespace stillgrid::network
