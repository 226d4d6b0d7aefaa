#pragma once

#include <dds/dds.h>

#include <string>
#include <string_view>

namespace stillgrid::scene_relay {

/// By which ROS 2, from its release Iron on, tells versions of a message's definition apart: the
/// SHA-256 of its names and types [REP 2016].
inline constexpr std::string_view kPoseTypeHash =
    "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8";
inline constexpr std::string_view kWrenchTypeHash =
    "RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77";

/// A topic as a ROS 2 node publishes it by default: reliable, volatile, the last 10 kept. Such a
/// writer matches subscribers with the default profile and with that of sensor data.
class RosWriter {
 public:
  /// ros_topic: "/stillgrid/demo/tool_pose". Throws std::runtime_error, one line.
  RosWriter(dds_entity_t participant, const std::string& ros_topic,
            const dds_topic_descriptor_t& type, std::string_view type_hash);
  ~RosWriter();
  RosWriter(const RosWriter&) = delete;
  RosWriter& operator=(const RosWriter&) = delete;
  RosWriter(RosWriter&&) = delete;
  RosWriter& operator=(RosWriter&&) = delete;

  /// Sends one message of the type. False where the middleware does not take it; a subscriber that
  /// has stopped reading is not waited for.
  [[nodiscard]] bool write(const void* message) const noexcept;

 private:
  dds_entity_t topic_ = 0, writer_ = 0;
};

}  // namespace stillgrid::scene_relay
