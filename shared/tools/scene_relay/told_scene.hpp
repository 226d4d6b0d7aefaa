#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "shared/tools/scene_relay/messages.hpp"

namespace stillgrid::scene_relay {

/// Why a message is not used, one line.
class MessageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// More moving spheres than a message may ask room for: 300 MB of segment.
inline constexpr std::uint32_t kMaxSpheres = 1'000'000;

/// Bytes of a model, and of a state, that a message may have at most.
inline constexpr std::size_t kMaxModel_bytes = std::size_t{64} << 20U;

/// What a simulation publishes once, as a message that lives as long as this. The model of a
/// session of several hands is left out: the other side has no path of the other hands' tools.
class ToldScene {
 public:
  /// least_period_ns: between two snapshots that are sent; the simulation's own may be shorter.
  ToldScene(const publication::SceneView& view, std::uint64_t relay_id,
            std::uint64_t least_period_ns = 0);
  ToldScene(const ToldScene&) = delete;
  ToldScene& operator=(const ToldScene&) = delete;
  ToldScene(ToldScene&&) = delete;
  ToldScene& operator=(ToldScene&&) = delete;
  ~ToldScene() = default;

  [[nodiscard]] const SceneMessage& message() const noexcept { return message_; }

 private:
  void tell_fields(const publication::SceneView& view);
  void tell_model(const publication::SceneView& view);

  struct FieldNumbers {
    std::vector<float> coarse, stiffness, fine;
    std::vector<std::uint32_t> numbers;
  };
  SceneMessage message_{};
  std::vector<stillgrid_relay3_Material> materials_;
  std::vector<stillgrid_relay3_Plane> planes_;
  std::vector<stillgrid_relay3_ToolSphere> tool_;
  std::vector<stillgrid_relay3_StaticSphere> spheres_;
  std::vector<FieldNumbers> numbers_;
  std::vector<stillgrid_relay3_DistanceField> fields_;
  std::vector<stillgrid_relay3_FieldBody> bodies_;
  std::vector<stillgrid_relay3_Hand> hands_;
  std::vector<std::uint8_t> model_;
};

/// The same to publish on this side. Throws MessageError unless every count, index and number is
/// sound, of which each reader would refuse the segment too. The bytes of the model are checked by
/// who decodes them.
[[nodiscard]] publication::StaticScene scene_of(const SceneMessage& message);

}  // namespace stillgrid::scene_relay
