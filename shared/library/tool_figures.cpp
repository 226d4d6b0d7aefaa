#include "shared/library/tool_figures.hpp"

#include <algorithm>
#include <limits>

#include "proto/device_plugin.h"
#include "shared/publication/tool_segment.hpp"

namespace stillgrid::library {

stillgrid_tool tool_figures(const proto::ToolState& state) noexcept {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  stillgrid_tool tool{};
  tool.struct_size = sizeof tool;
  tool.time_ns = state.time_ns;
  tool.tick = state.tick;
  std::copy(state.position_m.begin(), state.position_m.end(), tool.position_m);
  std::copy(state.orientation_xyzw.begin(), state.orientation_xyzw.end(), tool.orientation_xyzw);
  std::copy(state.velocity_m_s.begin(), state.velocity_m_s.end(), tool.velocity_m_s);
  std::copy(state.force_N.begin(), state.force_N.end(), tool.force_N);
  tool.buttons = state.buttons;
  tool.gripper_m =
      (state.device.told & STILLGRID_STATE_GRIPPER) != 0 ? state.device.gripper_m : kNone;
  std::fill(std::begin(tool.axes), std::end(tool.axes), kNone);
  if ((state.device.told & STILLGRID_STATE_AXES) != 0)
    std::copy(state.device.axes.begin(), state.device.axes.end(), tool.axes);
  if (!publication::has_sound_figures(state)) return tool;
  const proto::TickFigures& before = state.before;
  std::copy(before.torque_N_m.begin(), before.torque_N_m.end(), tool.torque_N_m);
  tool.contacts = before.contacts;
  tool.safety_flags = before.flags;
  tool.missed_ticks = before.missed_ticks;
  tool.work_ns = before.work_ns;
  tool.snapshot_id = before.displayed.snapshot_id;
  tool.age_s = before.displayed.age_s;
  return tool;
}

}  // namespace stillgrid::library
