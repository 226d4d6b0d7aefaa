#pragma once

#include "proto/stillgrid.h"
#include "proto/tool_segment.hpp"

namespace stillgrid::library {

/// What is told of a tick, of a state that passed its checks. Realtime: yes.
[[nodiscard]] stillgrid_tool tool_figures(const proto::ToolState& state) noexcept;

}  // namespace stillgrid::library
