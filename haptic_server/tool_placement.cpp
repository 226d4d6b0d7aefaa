#include "haptic_server/tool_placement.hpp"

#include <Eigen/Geometry>

#include "shared/files/number_text.hpp"

namespace stillgrid::haptic_server {

std::string ToolOrders::obey(std::string_view key, const std::string& value) {
  if (key == "tool.clutch") {
    if (value != "on" && value != "off") return "value '" + value + "': expected on or off";
    clutch = value == "on";
    return "";
  }
  if (key != "tool.scale") return "expected a known key: tool.clutch, tool.scale";
  const auto number = files::finite_number(value);
  if (!number || *number < 0.01 || *number > 100.0)
    return "value '" + value + "': expected a number from 0.01 to 100";
  scale = *number;
  return "";
}

Eigen::Vector3d ToolPlacement::place(const proto::DeviceFrame& frame,
                                     const Eigen::Vector3d& device_m, bool is_held,
                                     double scale) noexcept {
  const auto& [x, y, z, w] = frame.orientation_xyzw;
  const Eigen::Vector3d at_m = Eigen::Vector3d(frame.position_m.data()) +
                               frame.scale * scale * (Eigen::Quaterniond(w, x, y, z) * device_m);
  if (tool_m_ && (is_held || scale != scale_))
    offset_m_ = *tool_m_ - at_m;
  else
    tool_m_ = at_m + offset_m_;
  scale_ = scale;
  return *tool_m_;
}

}  // namespace stillgrid::haptic_server
