#pragma once

#include "proto/dds/scene_relay.h"  // of scene_relay.idl

namespace stillgrid::scene_relay {

/// Number of the messages' module: who speaks another is told so and not heard.
inline constexpr std::uint32_t kProtocol = 1;

using Greeting = stillgrid_Greeting;
using Status = stillgrid_relay1_Status;
using ToolMessage = stillgrid_relay1_Tool;
using SceneMessage = stillgrid_relay1_Scene;
using SnapshotMessage = stillgrid_relay1_Snapshot;
using Motion = stillgrid_relay1_Motion;
using Label = stillgrid_relay1_Label;
using FieldMotion = stillgrid_relay1_FieldMotion;

enum class Role : std::uint32_t { kSimulation = 1, kHand = 2 };

}  // namespace stillgrid::scene_relay
