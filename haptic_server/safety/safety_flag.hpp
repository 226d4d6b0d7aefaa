#pragma once

#include "proto/safety_flag.hpp"

namespace stillgrid {

using proto::kDeviceReasonMask;
using proto::kSafetyFlagNames;
using proto::SafetyFlag;
using enum proto::SafetyFlag;

}  // namespace stillgrid
