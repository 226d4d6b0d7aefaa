#pragma once

#include <Eigen/Core>
#include <atomic>
#include <optional>
#include <string>
#include <string_view>

#include "proto/scene_segment.hpp"

namespace stillgrid::haptic_server {

/// The user's orders to the tool while ticks go on. Thread: any.
struct ToolOrders {
  int clutch_button = -1;  // number on the device, from 0; -1: no clutch
  std::atomic<bool> clutch = false;
  std::atomic<double> scale = 1.0;  // that the scene's is multiplied by, once no force is felt

  /// Obeys `tool.clutch=on|off` and `tool.scale=NUMBER`. Returns a refusal, or "".
  [[nodiscard]] std::string obey(std::string_view key, const std::string& value);
  /// Whether the tool is to stay while the device moves. buttons: of the device. Realtime: yes.
  [[nodiscard]] bool holds_tool(std::uint32_t buttons) const noexcept {
    return clutch || (clutch_button >= 0 && (buttons >> clutch_button & 1U) != 0);
  }
};

/// Places the tool in the scene. A clutch holds it while the device is moved to another place. It
/// goes on from where it is when the clutch is let go, and when the scale changes.
///
/// Thread: one. Realtime: yes.
class ToolPlacement {
 public:
  /// Returns the tool's position in m, in the scene. device_m: in the device's frame. scale: that
  /// the frame's is multiplied by.
  [[nodiscard]] Eigen::Vector3d place(const proto::DeviceFrame& frame,
                                      const Eigen::Vector3d& device_m, bool is_held,
                                      double scale) noexcept;
  /// That of the last place().
  [[nodiscard]] double scale() const noexcept { return scale_; }

 private:
  std::optional<Eigen::Vector3d> tool_m_;
  Eigen::Vector3d offset_m_ = Eigen::Vector3d::Zero();
  double scale_ = 1.0;
};

}  // namespace stillgrid::haptic_server
