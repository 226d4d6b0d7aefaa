#pragma once

#include <string>
#include <string_view>

namespace stillgrid::scene_relay {

/// Under which names ROS 2 finds a hand's tool: "/stillgrid/demo/tool_pose", or, of a hand that has
/// a name, "/stillgrid/demo/left/tool_pose".
struct RosNames {
  std::string pose_topic, wrench_topic;
  std::string frame;  // of both: the scene's, which all its hands share: "stillgrid/demo"
};

/// The names of NAME or NAME+HAND; a user's number before it is left out. Throws
/// std::invalid_argument, one line, where NAME or HAND holds what ROS refuses in a topic's name:
/// anything but letters, digits and '_', or a digit first.
/// Source: rmw_validate_full_topic_name of ROS 2.
[[nodiscard]] RosNames ros_names(std::string_view hand_session);

/// The name that ROS 2 gives the topic in DDS: "rt/stillgrid/demo/tool_pose".
/// Source: design.ros2.org, "Topic and Service name mapping to DDS".
[[nodiscard]] std::string dds_name(std::string_view ros_topic);

}  // namespace stillgrid::scene_relay
