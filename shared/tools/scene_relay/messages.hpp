#pragma once

#include "proto/dds/scene_relay.h"  // of scene_relay.idl

namespace stillgrid::scene_relay {

/// Number of the messages' module: who speaks another is told so and not heard.
inline constexpr std::uint32_t kProtocol = 3;

using Greeting = stillgrid_Greeting;
using Status = stillgrid_relay3_Status;
using ToolMessage = stillgrid_relay3_Tool;
using SceneMessage = stillgrid_relay3_Scene;
using SnapshotMessage = stillgrid_relay3_Snapshot;
using Motion = stillgrid_relay3_Motion;
using Label = stillgrid_relay3_Label;
using FieldMotion = stillgrid_relay3_FieldState;
using PathSample = stillgrid_relay3_PathSample;

enum class Role : std::uint32_t { kSimulation = 1, kHand = 2 };

}  // namespace stillgrid::scene_relay
