#pragma once

#include "proto/safety_flag.hpp"

namespace stillgrid::safety {

using proto::kDeviceReasonMask;
using proto::kDeviceStatusMask;
using proto::kSafetyFlagNames;
using proto::SafetyFlag;
using enum proto::SafetyFlag;

}  // namespace stillgrid::safety
